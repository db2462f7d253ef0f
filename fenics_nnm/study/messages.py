"""What is wrong with a study file, in one line."""

from __future__ import annotations

import difflib
import re
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from fenics_nnm.geometry.lengths import WRONG_LENGTH
from fenics_nnm.study.tagged import is_tag, key_of, records

#: Where the description of a key says that it is a length.
_IN_METRES = re.compile(r"\bin m\b(?![\^/])")

#: Whole numbers that are read better in another way.
_MANY_DIGITS = re.compile(r"\d{16,}")

#: Characters of a value that a message shows.
_LONGEST = 80

#: Errors that are reported before all others.
_FIRST = {"extra_forbidden": 0, WRONG_LENGTH: 1}

#: What pydantic says of programs, said of study files.
_WORDS = {
    "int_parsing_size": "is too large",
    "int_type": "must be an integer",
    "missing": "has too few items",
    "model_attributes_type": "must be a section with keys",
    "model_type": "must be a section with keys",
    "path_type": "must be a name in quotes",
    "string_too_short": "must not be empty",
    "too_long": "has too many items",
    "too_short": "has too few items",
    "tuple_type": "must be a list",
    "union_tag_not_found": "must be a section with keys",
}


def first_error(
    error: ValidationError,
    record: type[BaseModel],
    values: Any,
    place: tuple[str, ...],
    unit: str = "m",
) -> str:
    """One line for the first error.

    Unknown keys come first, since they cause others, then texts that are no length, about which
    the other types that a value may have know less.

    Args:
        error: What pydantic found.
        record: Record that the values were checked as.
        values: Values of the study file.
        place: Keys that lead to them.
        unit: Unit of lengths without one, outside of [mesh].
    """
    errors = sorted(error.errors(), key=lambda item: _FIRST.get(item["type"], len(_FIRST)))
    first = errors[0]
    loc = first["loc"]
    value = _found(loc, values)
    name = _written((*place, *_places(loc, values)))
    if first["type"] == "extra_forbidden":
        return f"{name}: {_unknown(record, loc, _found(loc[:-1], values), name)}"
    if first["type"] == "missing" and _is_key(loc[-1]):
        return f"{name}: is missing{_in(unit, _needed(record, loc, place))}"
    if first["type"] == "value_error":
        message = first["msg"].removeprefix("Value error, ")
        joint = ": " if message.startswith("must ") else "."  # of the section, or of a key in it
        return f"{name}{joint}{message}" if name else message
    if first["type"] in ("union_tag_invalid", "union_tag_not_found") and isinstance(value, dict):
        return _wrong_tag(record, loc, value, name, first)
    vague = _has_alternatives(loc) and first["type"] != WRONG_LENGTH
    message = "is not allowed" if vague else _plain_message(first)
    return f"{name} = {shown(value)}: {message}{_in(unit, _wanted(record, loc))}"


def _wrong_tag(
    record: type[BaseModel], loc: tuple[Any, ...], values: dict[str, Any], name: str, error: Any
) -> str:
    """What is said of a section whose tag is missing, or has a value that is none of its kinds."""
    kinds = _alternatives(record, loc)
    key = key_of(error.get("ctx", {}).get("tag") or kinds[0][0])
    known = [tag.partition(" = ")[2].replace('"', "'") for tag, _ in kinds if key_of(tag) == key]
    wanted = _wanted(record, (*loc, kinds[0][0], key))
    if key not in values:
        return f"{name}.{key}: is missing{wanted}".removeprefix(".")
    must = f"must be {_listed(known)}{wanted}"
    return f"{name}.{key} = {shown(values[key])}: {must}".removeprefix(".")


def _listed(words: list[str]) -> str:
    return " or ".join(filter(None, [", ".join(words[:-1]), words[-1]]))


def _plain_message(error: Any) -> str:
    message = _WORDS.get(error["type"]) or _with_short_number(error)
    return message.replace("Input should be", "must be").replace(" valid", "")


def _with_short_number(error: Any) -> str:
    """What pydantic says, with a bound such as 1e+30 not in thirty digits."""
    return _MANY_DIGITS.sub(lambda digits: f"{float(digits[0]):g}", str(error["msg"]))


def _places(place: tuple[Any, ...], values: Any) -> tuple[str | int, ...]:
    """Keys of pydantic's location, and numbers of sections of which there are several."""
    found: list[str | int] = []
    for part in place:
        if isinstance(part, int) and _is_section(values, part):
            found.append(part)
            values = values[part]
        elif _is_key(part):
            found.append(part)
            values = values.get(part) if isinstance(values, dict) else None
    return tuple(found)


def _is_section(values: Any, number: int) -> bool:
    """Whether values are a list with a section at a place."""
    return isinstance(values, list) and number < len(values) and isinstance(values[number], dict)


def _found(place: tuple[Any, ...], values: Any) -> Any:
    """The value at pydantic's location, None where it is missing."""
    for part in _places(place, values):
        inside = isinstance(values, list) or (isinstance(values, dict) and part in values)
        values = values[part] if inside else None
    return values


def _written(places: tuple[str | int, ...]) -> str:
    """Keys with dots in between, and numbers of sections from 1, as in "contact.patch[2].gap"."""
    words = (f".{part}" if isinstance(part, str) else f"[{part + 1}]" for part in places)
    return "".join(words).removeprefix(".")


def _has_alternatives(place: tuple[Any, ...]) -> bool:
    """Whether pydantic's location names one alternative of several for a value."""
    return any(isinstance(p, str) and not (_is_key(p) or is_tag(p)) for p in place)


def _is_key(part: Any) -> bool:
    """Whether part of pydantic's location is a key of the file, not the name of an alternative."""
    return (
        isinstance(part, str)
        and part.isidentifier()
        and part.islower()
        and part not in ("float", "int", "str", "tuple")
    )


def shown(value: Any) -> str:
    """A value as it stands in the study file, cut where it is long."""
    if isinstance(value, bool):
        return str(value).lower()
    text = f'"{value}"' if isinstance(value, str | Path) else f"{value}"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _alternatives(
    record: type[BaseModel], location: tuple[Any, ...]
) -> list[tuple[str, type[BaseModel]]]:
    """Records that a location can stand for with their tags: one, or the kinds of a section."""
    kinds: list[tuple[str, type[BaseModel]]] = [("", record)]
    for part in location:
        if is_tag(part):
            kinds = [(tag, kind) for tag, kind in kinds if tag == part]
        elif _is_key(part) and kinds:
            field = _fields(kinds[0][1]).get(part)
            kinds = list(records(field.annotation)) if field else []
    return kinds


def _holder(
    record: type[BaseModel], location: tuple[Any, ...]
) -> tuple[str, type[BaseModel] | None]:
    """Record that holds the last key of a location, and its tag."""
    kinds = _alternatives(record, location[:-1])
    return kinds[0] if kinds else ("", None)


def _fields(record: type[BaseModel]) -> dict[str, Any]:
    return {field.alias or name: field for name, field in record.model_fields.items()}


def _unknown(record: type[BaseModel], location: tuple[Any, ...], section: Any, name: str) -> str:
    """What is said of an unknown key: why it is not here, who has it, or which one was meant."""
    key, (tag, holder) = location[-1], _holder(record, location)
    reasons = getattr(holder, "absent", {})
    if key in reasons:
        return str(reasons[key])
    owners = [other for other, kind in _siblings(record, location) if key in _fields(kind)]
    if owners and isinstance(section, dict) and key_of(tag) not in section:
        return f"needs {_listed(owners)}"
    if owners:
        here = f"{name.removesuffix(key)}{tag}"
        return f"does not belong: {here} has no {key}: needs {_listed(owners)}"
    known = list(_fields(holder)) if holder else []
    close = difflib.get_close_matches(key, known, n=1)
    if close:
        return f'unknown key: did you mean "{close[0]}"?'
    return f"unknown key: the keys here are {', '.join(known)}" if known else "unknown key"


def _siblings(
    record: type[BaseModel], location: tuple[Any, ...]
) -> list[tuple[str, type[BaseModel]]]:
    """All kinds of the section that holds the last key of a location, none if it has no tag."""
    tagged = len(location) > 1 and is_tag(location[-2])
    return _alternatives(record, location[:-2]) if tagged else []


def _needed(record: type[BaseModel], location: tuple[Any, ...], place: tuple[str, ...]) -> str:
    """Who needs a key that is missing, and what it is."""
    tag, _ = _holder(record, location)
    section = _written((*place, *(part for part in location[:-1] if _is_key(part))))
    needs = f": {section}.{tag} needs {location[-1]}" if tag else ""
    return f"{needs}{_wanted(record, location)}"


def _wanted(record: type[BaseModel], location: tuple[Any, ...]) -> str:
    keys = [n for n, part in enumerate(location) if _is_key(part)]
    if not keys:
        return ""
    location = location[: keys[-1] + 1]
    _, holder = _holder(record, location)
    field = _fields(holder).get(location[-1]) if holder else None
    return f" ({field.description})" if field is not None and field.description else ""


def _in(unit: str, description: str) -> str:
    """What is wanted of a number, with the unit that lengths without one have."""
    return _IN_METRES.sub(f"in {unit}", description)


def plain(error: Exception) -> str:
    """Reason of an error, without the number and the file of the operating system."""
    return getattr(error, "strerror", None) or str(error)
