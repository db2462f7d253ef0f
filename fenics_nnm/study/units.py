"""Units of the values of a study, as the descriptions of its keys name them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from fenics_nnm.study.settings import parts_of
from fenics_nnm.study.study import Study

_UNIT = re.compile(r"\bin (length_unit|m\^2|m|kg/m\^3|kg|Pa|N/m\^3|N/m|degrees)(?!\w|\^)")


def unit_of(study: Study, key: str) -> str:
    """Unit of a value of a study, empty where it has none.

    Args:
        study: Study.
        key: Key with its sections, as in "contact.patch[2].gap".
    """
    *sections, (last, _) = parts_of(key)
    holder: Any = study
    for name, number in sections:
        holder = _inside(holder, name, number)
    if not isinstance(holder, BaseModel):
        return ""
    fields = type(holder).model_fields
    fields = {**fields, **{field.alias: field for field in fields.values() if field.alias}}
    found = _UNIT.search((last in fields and fields[last].description) or "")
    unit = found.group(1) if found else ""
    if unit != "length_unit":
        return unit
    return str(getattr(getattr(study, "mesh", None), "length_unit", "m"))


def _inside(holder: Any, name: str, number: int | None) -> Any:
    """A section in a section; the first one of several if no number is given."""
    found = holder.get(name) if isinstance(holder, Mapping) else getattr(holder, name, None)
    if isinstance(found, tuple) and found:
        return found[(number or 1) - 1]
    return found
