"""Keys of a study with their values, sections within sections taken apart."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any


def leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Keys and values of a section, of all of its name, and of the sections in it.

    They are named as `study.reading` names them: one of several by its number, counted from 1; a
    section that is no part of another one may be the only one of its name, without a number.

    Args:
        name: Name of the section.
        value: What `model_dump` gives for it.
    """
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(f"{name}.{key}", inner)
    elif isinstance(value, tuple) and value and isinstance(value[0], dict):
        alone = len(value) == 1 and "." not in name
        for number, part in enumerate(value, 1):
            yield from leaves(name if alone else f"{name}[{number}]", part)
    else:
        yield name, value
