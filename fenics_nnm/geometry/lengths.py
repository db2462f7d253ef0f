"""Lengths of a study: numbers, or texts of a number with a unit, as in "0.5 mm".

A field of one of the annotated types below is a number in a known unit once it is read: in m, or in
`mesh.length_unit` for the lengths of [mesh]. What a number without a unit means is said by `Units`,
the context that the records of a study are checked with.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal
from math import inf
from typing import Any, Literal

from pydantic import BeforeValidator, ValidationInfo
from pydantic_core import PydanticCustomError

LengthUnit = Literal["m", "cm", "mm", "um", "in", "ft", "mil"]

METRES: dict[str, float] = {
    "m": 1.0,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1e-6,
    "in": 0.0254,
    "ft": 0.3048,
    "mil": 2.54e-5,
}
"""Metres in one length unit."""

#: The units in a line.
KNOWN = f"{', '.join(list(METRES)[:-1])} or {list(METRES)[-1]}"

#: Type of the errors of pydantic about a text that is no length.
WRONG_LENGTH = "wrong_length"

_NUMBER = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"

#: A number with a unit; 1e-3 is none of the unit e-3.
WITH_UNIT = re.compile(rf"(?!{_NUMBER}$)({_NUMBER})\s*([^\W\d_]\S*)")

#: A longer text is no length.
_LONGEST = 80

#: The two letters of Unicode for micro.
_MICRO = str.maketrans({"\u00b5": "u", "\u03bc": "u"})


@dataclass(frozen=True, slots=True)
class Units:
    """Units of lengths without one.

    Attributes:
        study: Unit everywhere but in [mesh].
        mesh: Unit in [mesh], which its lengths have when they are read, too.
    """

    study: str = "m"
    mesh: str = "m"


def converted(value: float, unit: str, wanted: str) -> float:
    """A length in another unit, rounded once: 0.3 mm are 3e-4 m to the last digit."""
    if unit == wanted:
        return value
    factor = Decimal(repr(METRES[unit])) / Decimal(repr(METRES[wanted]))
    return float(Decimal(repr(value)) * factor)


def like_a_length(text: str) -> bool:
    """Whether a text is a number with letters behind it, be they a unit or not."""
    return len(text) <= _LONGEST and WITH_UNIT.fullmatch(text.strip()) is not None


def length_in_metres(text: str) -> float:
    """A length in m of a number with a unit.

    Raises:
        ValueError: if it is none.
    """
    return converted(*_parsed(text), "m")


def _in_metres(value: Any, info: ValidationInfo) -> Any:
    return _read(value, _units(info).study, "m")


def _in_unit_of_mesh(value: Any, info: ValidationInfo) -> Any:
    if info.context is None and isinstance(value, str):
        raise _wrong("must be a number in length_unit outside of a study file")
    unit = _units(info).mesh
    return _read(value, unit, unit)


#: Makes a number of a length in m.
InMetres = BeforeValidator(_in_metres)

#: Makes a number of a length in `mesh.length_unit`.
InUnitOfMesh = BeforeValidator(_in_unit_of_mesh)


def _units(info: ValidationInfo) -> Units:
    return Units() if info.context is None else info.context


def _read(value: Any, plain: str, wanted: str) -> Any:
    """A length in a wanted unit; what is neither number nor text is left to the type."""
    if isinstance(value, str):
        return converted(*_parsed(value), wanted)
    if isinstance(value, bool) or not isinstance(value, int | float) or plain == wanted:
        return value
    try:
        return converted(float(value), plain, wanted)
    except OverflowError:  # of a large integer
        return inf


def _parsed(text: str) -> tuple[float, str]:
    """Number and unit of a text."""
    found = WITH_UNIT.fullmatch(text.strip()) if len(text) <= _LONGEST else None
    if found is None:
        raise _wrong(
            f'must be a number, or a number with a unit, as in "0.5 mm"; units are {KNOWN}'
        )
    number, unit = float(found[1]), found[2].translate(_MICRO)
    if unit not in METRES:
        raise _wrong(f'the unit "{found[2]}" is not known: must be {KNOWN}')
    return number, unit


def _wrong(reason: str) -> PydanticCustomError:
    return PydanticCustomError(WRONG_LENGTH, "{reason}", {"reason": reason})
