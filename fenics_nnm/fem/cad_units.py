"""The length unit that a CAD file declares."""

from __future__ import annotations

import re
from pathlib import Path

#: Names of units in STEP files, those of conversions included.
_STEP_UNITS = {
    **{"METRE": "m", "CENTI": "cm", "MILLI": "mm", "MICRO": "um"},
    **{"INCH": "in", "FOOT": "ft", "FEET": "ft", "MIL": "mil", "MILS": "mil"},
}

#: Numbers of units in the global section of IGES files.
_IGES_UNITS = {"1": "in", "2": "mm", "4": "ft", "6": "m", "8": "mil", "9": "um", "10": "cm"}

#: Parameter of the global section of an IGES file that has the unit, from 0.
_IGES_PLACE = 13


def declared_unit(path: Path) -> str | None:
    """Unit of a STEP or IGES file, a key of `METRES`; None where there is none, or several.

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
    converted = [re.search(r"CONVERSION_BASED_UNIT\s*\(\s*'(\w+)'", entity) for entity in entities]
    names = {found[1].upper() for found in converted if found}
    if not names:
        plain = [re.search(r"SI_UNIT\s*\(\s*(\$|\.(\w+)\.)\s*,\s*\.METRE\.", e) for e in entities]
        names = {found[2] or "METRE" for found in plain if found}
    units = {_STEP_UNITS.get(name) for name in names}
    return units.pop() if len(units) == 1 else None


def _of_iges(text: str) -> str | None:
    """The global section: parameters between commas, texts as their length, H and themselves."""
    rest = "".join(line[:72] for line in text.splitlines() if line[72:73] == "G")
    delimiter = rest[2] if rest.startswith("1H") else ","
    parameters: list[str] = []
    while rest and len(parameters) <= _IGES_PLACE:
        held = re.match(r"\s*(\d+)H", rest)
        end = rest.find(delimiter, held.end() + int(held[1]) if held else 0)
        parameters.append(rest[: end if end >= 0 else len(rest)].strip())
        rest = rest[end + 1 :] if end >= 0 else ""
    return _IGES_UNITS.get(parameters[_IGES_PLACE]) if len(parameters) > _IGES_PLACE else None
