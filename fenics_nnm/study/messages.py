"""What is wrong with a study file, in one line."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

#: Characters of a value that a message shows.
_LONGEST = 80

#: What pydantic says of programs, said of study files.
_WORDS = {
    "int_type": "must be an integer",
    "missing": "has too few items",
    "model_attributes_type": "must be a section with keys",
    "model_type": "must be a section with keys",
    "path_type": "must be a name in quotes",
    "too_long": "has too many items",
    "too_short": "has too few items",
    "tuple_type": "must be a list",
}


def first_error(
    error: ValidationError, record: type[BaseModel], values: Any, place: tuple[str, ...]
) -> str:
    """One line for the first error; unknown keys come first, since they cause others."""
    errors = sorted(error.errors(), key=lambda item: item["type"] != "extra_forbidden")
    first = errors[0]
    location, value = _found(first["loc"], values)
    name = _written((*place, *_places(first["loc"], values)))
    if first["type"] == "extra_forbidden":
        return f"{name}: unknown key{_suggestion(record, location)}"
    if first["type"] == "missing" and _is_key(first["loc"][-1]):
        return f"{name}: is missing{_wanted(record, location)}"
    if first["type"] == "value_error":
        message = first["msg"].removeprefix("Value error, ")
        return f"{name}.{message}" if name else message
    message = "is not allowed" if _has_alternatives(first["loc"]) else _plain_message(first)
    return f"{name} = {shown(value)}: {message}{_wanted(record, location)}"


def _plain_message(error: Any) -> str:
    message = _WORDS.get(error["type"], error["msg"])
    return message.replace("Input should be", "must be").replace(" valid", "")


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


def _found(place: tuple[Any, ...], values: Any) -> tuple[tuple[str, ...], Any]:
    """Keys of pydantic's location alone, and the value there, None where it is missing."""
    places = _places(place, values)
    for part in places:
        inside = isinstance(values, list) or (isinstance(values, dict) and part in values)
        values = values[part] if inside else None
    return tuple(part for part in places if isinstance(part, str)), values


def _written(places: tuple[str | int, ...]) -> str:
    """Keys with dots in between, and numbers of sections from 1, as in "contact.patch[2].gap"."""
    words = (f".{part}" if isinstance(part, str) else f"[{part + 1}]" for part in places)
    return "".join(words).removeprefix(".")


def _has_alternatives(place: tuple[Any, ...]) -> bool:
    """Whether pydantic's location names one alternative of several for a value."""
    return any(isinstance(part, str) and not _is_key(part) for part in place)


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


def _record_at(record: type[BaseModel], location: tuple[str, ...]) -> type[BaseModel] | None:
    """Record that holds the last key of a location."""
    for key in location[:-1]:
        field = _fields(record).get(key)
        options = [field.annotation, *getattr(field.annotation, "__args__", ())] if field else []
        records = [o for o in options if isinstance(o, type) and issubclass(o, BaseModel)]
        if not records:
            return None
        record = records[0]
    return record


def _fields(record: type[BaseModel]) -> dict[str, Any]:
    return {field.alias or name: field for name, field in record.model_fields.items()}


def _suggestion(record: type[BaseModel], location: tuple[str, ...]) -> str:
    holder = _record_at(record, location)
    known = list(_fields(holder)) if holder else []
    close = difflib.get_close_matches(location[-1], known, n=1)
    if close:
        return f': did you mean "{close[0]}"?'
    return f": the keys here are {', '.join(known)}" if known else ""


def _wanted(record: type[BaseModel], location: tuple[str, ...]) -> str:
    holder = _record_at(record, location)
    field = _fields(holder).get(location[-1]) if holder and location else None
    return f" ({field.description})" if field is not None and field.description else ""


def plain(error: Exception) -> str:
    """Reason of an error, without the number and the file of the operating system."""
    return getattr(error, "strerror", None) or str(error)
