"""Units of the values of a study, as the descriptions of its keys name them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from fenics_nnm.study.settings import Setting, parts_of
from fenics_nnm.study.study import Study

_UNIT = re.compile(r"\bin (length_unit|m\^2|m|kg/m\^3|kg|Pa|N/m\^3|N/m|degrees)(?!\w|\^)")

_OF_LENGTHS = ("m", "length_unit")


def unit_of(study: Study, key: str) -> str:
    """Unit of a value of a study, empty where it has none.

    Args:
        study: Study.
        key: Key with its sections, as in "contact.patch[2].gap".
    """
    unit = _described(*_holder(study, key))
    if unit != "length_unit":
        return unit
    return str(getattr(getattr(study, "mesh", None), "length_unit", "m"))


def in_its_unit(study: Study, setting: Setting) -> Any:
    """Value of a setting of a study: a length in the unit of its key, others as they are given.

    So lengths that are given in several units can be compared.
    """
    holder, last = _holder(study, setting.key)
    if _described(holder, last) not in _OF_LENGTHS:
        return setting.value
    found = _listed(getattr(holder, _names(holder)[last]))
    same = found == setting.value or isinstance(found, Path)
    return setting.value if same else found


def _holder(study: Study, key: str) -> tuple[Any, str]:
    """What has the last part of a key, and that part."""
    *sections, (last, _) = parts_of(key)
    holder: Any = study
    for name, number in sections:
        holder = _inside(holder, name, number)
    return holder, last


def _names(holder: Any) -> dict[str, str]:
    """Names of the fields of a section by their keys; none of what is no section."""
    if not isinstance(holder, BaseModel):
        return {}
    fields = type(holder).model_fields
    return {field.alias or name: name for name, field in fields.items()}


def _described(holder: Any, key: str) -> str:
    """Unit that the description of a key names, empty without one."""
    name = _names(holder).get(key)
    description = type(holder).model_fields[name].description if name else None
    found = _UNIT.search(description or "")
    return found.group(1) if found else ""


def _inside(holder: Any, name: str, number: int | None) -> Any:
    """A section in a section; the first one of several if no number is given."""
    if isinstance(holder, Mapping):
        found = holder.get(name)
    else:
        found = getattr(holder, _names(holder).get(name, name), None)
    if isinstance(found, tuple) and found:
        return found[(number or 1) - 1]
    return found


def _listed(value: Any) -> Any:
    """A value with lists in place of tuples, as it stands in a study file."""
    return [_listed(each) for each in value] if isinstance(value, tuple) else value
