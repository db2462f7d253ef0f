"""Amounts with units: stresses, energies, frequencies and lengths, as in "300 MPa" or "1.2 J"."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from typing import Any

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from fenics_nnm.geometry.lengths import METRES, WITH_UNIT, WRONG_LENGTH

#: What an amount is of, by the SI unit of it, with the factors of its units.
UNITS: Mapping[str, Mapping[str, float]] = {
    "m": METRES,
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "psi": 6894.757, "ksi": 6894757.0},
    "J": {"J": 1.0, "mJ": 1e-3, "uJ": 1e-6, "kJ": 1e3},
    "Hz": {"Hz": 1.0, "kHz": 1e3},
}

#: A longer text is no amount.
_LONGEST = 80

#: The two letters of Unicode for micro.
_MICRO = str.maketrans({"\u00b5": "u", "\u03bc": "u"})


def known_units(*kinds: str) -> str:
    """Units of some kinds, in a line."""
    names = [name for kind in kinds or UNITS for name in UNITS[kind]]
    return f"{', '.join(names[:-1])} or {names[-1]}"


def amount(text: str, *kinds: str) -> tuple[float, str]:
    """An amount in SI units, and which: 1200.0 and "J" of "1.2 kJ".

    Args:
        text: A number with a unit.
        kinds: SI units of what it may be of; all of them unless given.

    Raises:
        ValueError: if it is none.
    """
    found = WITH_UNIT.fullmatch(text.strip()) if len(text) <= _LONGEST else None
    if found is None:
        raise ValueError(f"must be a number with a unit: {known_units(*kinds)}")
    unit = found[2].translate(_MICRO)
    for kind in kinds or UNITS:
        if unit in UNITS[kind]:
            return float(Decimal(found[1]) * Decimal(repr(UNITS[kind][unit]))), kind
    raise ValueError(f'the unit "{found[2]}" is not known: must be {known_units(*kinds)}')


def _in_pascal(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    try:
        return amount(value, "Pa")[0]
    except ValueError as error:
        reason = f"{error}, or a number in Pa"
        raise PydanticCustomError(WRONG_LENGTH, "{reason}", {"reason": reason}) from error


#: Makes a number in Pa of a stress.
InPascal = BeforeValidator(_in_pascal)
