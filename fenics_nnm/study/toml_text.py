"""From values of a study back to the text of a study file."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(values: dict[str, Any]) -> str:
    """A TOML file with these values, sections in their order; `tomllib.loads` gives them again.

    Args:
        values: Values as `tomllib.loads` gives them, without dates.
    """
    plain = {key: value for key, value in values.items() if not _sections(value)}
    blocks = [list(_lines(plain))] if plain else []
    for name, value in values.items():
        several = isinstance(value, list)
        heading = f"[[{_key(name)}]]" if several else f"[{_key(name)}]"
        blocks += [[heading, *_lines(each)] for each in _sections(value)]
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


def toml_value(value: Any) -> str:
    """A value as it stands in a TOML file, sections in braces."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return f"{{ {', '.join(_lines(value))} }}" if value else "{}"
    if isinstance(value, list):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)


def _sections(value: Any) -> list[dict[str, Any]]:
    """Sections that a value of the top level stands for, none if it is a plain value."""
    if isinstance(value, dict):
        return [value]
    listed = isinstance(value, list) and value and all(isinstance(item, dict) for item in value)
    return value if listed else []


def _lines(values: dict[str, Any]) -> Iterator[str]:
    return (f"{_key(name)} = {toml_value(value)}" for name, value in values.items())


def _key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else toml_value(name)
