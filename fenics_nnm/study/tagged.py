"""Sections of which one key, the tag, says which other keys there are.

Each kind of such a section is a record with the keys that have an effect, and no others, so that no
key has to be checked against the tag: a key of another kind is unknown here, and messages name the
kind that has it.
"""

from __future__ import annotations

import types
from collections.abc import Iterator
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, Discriminator, Tag

#: Between the key and the value of a tag, as in 'method = "massless"'; no key has it.
_IS = " = "


def tag_text(key: str, value: object) -> str:
    """A tag as it stands in the study file."""
    return f'{key}{_IS}"{value}"'


def by_key(key: str, default: str | None = None) -> Discriminator:
    """Choose the kind of a section by the value of a key, and of its default where it has one."""

    def chosen(section: Any) -> str | None:
        value = value_of(section, key, default)
        return None if value is None else tag_text(key, value)

    return Discriminator(chosen)


def value_of(section: Any, key: str, default: Any) -> Any:
    """Value of a key of a section, which is a dictionary still, or a record already."""
    found = section.get(key) if isinstance(section, dict) else getattr(section, key, None)
    return default if found is None else found


def is_tag(part: Any) -> bool:
    """Whether part of pydantic's location is a tag."""
    return isinstance(part, str) and _IS in part


def key_of(tag: str) -> str:
    """Key of a tag."""
    return tag.partition(_IS)[0]


def records(annotation: Any, tag: str = "") -> Iterator[tuple[str, type[BaseModel]]]:
    """Records that a type can stand for, each with its tag, empty where it has none."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield tag, annotation
    elif get_origin(annotation) is Annotated:
        inner, *notes = get_args(annotation)
        tags = [note.tag for note in notes if isinstance(note, Tag)]
        yield from records(inner, tags[0] if tags else tag)
    elif get_origin(annotation) in (Union, types.UnionType, tuple):
        for each in get_args(annotation):
            yield from records(each, tag)
