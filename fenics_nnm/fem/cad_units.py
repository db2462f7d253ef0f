"""The length unit that a CAD file declares."""

from __future__ import annotations

import re
from pathlib import Path

#: Names of units: prefixes of the metre, those of conversions, and those in IGES files.
_NAMES = {
    **{"METRE": "m", "CENTI": "cm", "MILLI": "mm", "MICRO": "um"},
    **{"INCH": "in", "INCHES": "in", "IN": "in", "FOOT": "ft", "FEET": "ft", "FT": "ft"},
    **{"MIL": "mil", "MILS": "mil", "M": "m", "CM": "cm", "MM": "mm", "UM": "um"},
}

#: What OpenCASCADE converts to: units that are not known here, and several ones.
_CONVERTED = "mm"

#: Numbers of units in the global section of IGES files, and the one for a name that comes next.
_IGES_UNITS = {"1": "in", "2": "mm", "4": "ft", "6": "m", "8": "mil", "9": "um", "10": "cm"}

_NAMED = "3"

#: Parameter of the global section of an IGES file that has the unit, from 0.
_IGES_PLACE = 13


def declared_unit(path: Path) -> str | None:
    """Unit of a STEP or IGES file, a key of `METRES`; None where there is none.

    Where there are several, or one that is not known here, it is the one that all are converted to.

    STEP: ISO 10303-41, entities LENGTH_UNIT; IGES 5.3: parameter 14 of the global section.
    """
    text = path.read_text(encoding="latin-1")
    if path.suffix.lower() in (".step", ".stp"):
        return _of_step(text)
    if path.suffix.lower() in (".iges", ".igs"):
        return _of_iges(text)
    return None


def _of_step(text: str) -> str | None:
    entities = re.findall(r"=\s*\(?([^;]*LENGTH_UNIT\s*\(\s*\)[^;]*);", text)
    converted = [re.search(r"CONVERSION_BASED_UNIT\s*\(\s*'([^']*)'", e) for e in entities]
    names = {found[1].strip(" .").upper() for found in converted if found}
    if not names:
        plain = [re.search(r"SI_UNIT\s*\(\s*(\$|\.(\w+)\.)\s*,\s*\.METRE\.", e) for e in entities]
        names = {found[2] or "METRE" for found in plain if found}
    units = {_NAMES.get(name, _CONVERTED) for name in names}
    return (units.pop() if len(units) == 1 else _CONVERTED) if units else None


def _of_iges(text: str) -> str | None:
    """The global section: parameters between commas, texts as their length, H and themselves."""
    rest = "".join(line[:72] for line in text.splitlines() if line[72:73] == "G")
    delimiter = rest[2] if rest.startswith("1H") else ","
    parameters: list[str] = []
    while rest and len(parameters) <= _IGES_PLACE + 1:
        held = re.match(r"\s*(\d+)H", rest)
        end = rest.find(delimiter, held.end() + int(held[1]) if held else 0)
        parameters.append(rest[: end if end >= 0 else len(rest)].strip())
        rest = rest[end + 1 :] if end >= 0 else ""
    if len(parameters) <= _IGES_PLACE + 1:
        return None
    number, name = parameters[_IGES_PLACE:]
    if number == _NAMED:
        return _NAMES.get(name.partition("H")[2].strip(" .").upper(), _CONVERTED)
    return _IGES_UNITS.get(number, _CONVERTED)
