"""Keys of a study that are set outside its file: `contact.gap=1e-4`."""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fenics_nnm.errors import StudyError
from fenics_nnm.geometry.lengths import like_a_length
from fenics_nnm.study.messages import shown
from fenics_nnm.study.reading import study_from
from fenics_nnm.study.study import Study
from fenics_nnm.study.toml_text import toml_text, toml_value

#: A key, or a quoted one, with the number of one of several sections behind it.
_PART = re.compile(r'(?:([\w-]+)|"([^"]+)")(?:\[(\d+)\])?')

#: A value without quotes that is taken for text, such as massless.
_WORD = re.compile(r"[A-Za-z_./][\w./+-]*")

_BRACKETS = {"[": 1, "{": 1, "]": -1, "}": -1}


@dataclass(frozen=True, slots=True)
class Setting:
    """A key of a study with its value.

    Attributes:
        key: Key with its sections, as in "contact.patch[2].gap".
        value: Value as `tomllib` gives it.
    """

    key: str
    value: Any

    def __str__(self) -> str:
        return f"{self.key} = {toml_value(self.value)}"

    @property
    def argument(self) -> str:
        """The setting as `--set` takes it."""
        return f"{self.key}={toml_value(self.value)}"


def settings_from(text: str) -> tuple[Setting, ...]:
    """Settings of `KEY=VALUE,VALUE,...`, one for each value.

    Values are those of TOML; quotes may be left out around a word, and around a length as 0.5 mm.

    Raises:
        StudyError: if it is not of this form.
    """
    key, equals, values = text.partition("=")
    key = key.strip()
    if not equals or not key or not values.strip():
        raise StudyError(f"--set {text}: must be KEY=VALUE, or KEY=VALUE,VALUE,...")
    parts_of(key)
    return tuple(Setting(key, value_from(item, key)) for item in _items(values))


def value_from(text: str, key: str) -> Any:
    """A value of TOML, or a word or a length with a unit without quotes.

    Raises:
        StudyError: if it is neither.
    """
    text = text.strip()
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError as error:
        if _WORD.fullmatch(text) or like_a_length(text):
            return text
        raise StudyError(
            f"{key} = {shown(text)}: must be a value of TOML: a number, a text in quotes, "
            "true or false, or [a, list]"
        ) from error


def parts_of(key: str) -> list[tuple[str, int | None]]:
    """Names of a key, each with the number of one of several sections, from 1.

    Raises:
        StudyError: if it is not names with dots in between.
    """
    found: list[tuple[str, int | None]] = []
    end = 0
    for match in _PART.finditer(key):
        between = key[end : match.start()]
        if between != ("." if found else ""):
            break
        bare, quoted, number = match.groups()
        found.append((bare or quoted, int(number) if number else None))
        end = match.end()
    if end != len(key) or not found:
        raise StudyError(
            f"{key}: is no key: must be names with dots in between, and a number in brackets for "
            "one of several sections, as in contact.gap or contact.patch[2].gap"
        )
    return found


def with_settings(values: dict[str, Any], settings: Iterable[Setting]) -> dict[str, Any]:
    """A copy of the values of a study file with some keys set.

    Raises:
        StudyError: if a key leads through something that is no section, or to one of several
            sections that does not exist.
    """
    changed = copy.deepcopy(values)
    for setting in settings:
        _set(changed, setting)
    return changed


def study_with(
    values: dict[str, Any], path: Path, settings: tuple[Setting, ...]
) -> tuple[Study, str]:
    """The study of a file with some keys set, and the text of its own study file.

    Args:
        values: Values of the study file.
        path: Its place.
        settings: Keys to set.

    Raises:
        StudyError: as `study_from`, with the settings in front.
    """
    given = ", ".join(map(str, settings))
    try:
        changed = with_settings(values, settings)
        study = study_from(changed, path)
    except StudyError as error:
        raise StudyError(f"with {shown_settings(settings)}: {error}") from error
    return study, f"# {path.name} with {given}\n\n{toml_text(changed)}"


def shown_settings(settings: Iterable[Setting]) -> str:
    """Settings in a line, long values cut."""
    return ", ".join(f"{setting.key} = {shown(setting.value)}" for setting in settings)


def _set(values: dict[str, Any], setting: Setting) -> None:
    *sections, (last, number) = parts_of(setting.key)
    if number is not None:
        raise StudyError(f"{setting.key}: names a section: must name one of its keys")
    place = ""
    for name, index in sections:
        place = f"{place}.{name}".removeprefix(".")
        values = _section(values, name, index, place)
    values[last] = setting.value


def _section(values: dict[str, Any], name: str, index: int | None, place: str) -> dict[str, Any]:
    """A section in a section, made where there is none."""
    found = values.setdefault(name, {}) if index is None else values.get(name)
    if index is not None:
        several = found if isinstance(found, list) else []
        if not 1 <= index <= len(several):
            raise StudyError(
                f"{place}[{index}]: there is none: the study has {len(several)} [[{place}]]"
            )
        found = several[index - 1]
    elif isinstance(found, list):
        raise StudyError(f"{place}: there are {len(found)}: must name one, as in {place}[1]")
    if not isinstance(found, dict):
        raise StudyError(f"{place} = {shown(found)}: is no section with keys")
    return found


def _items(text: str) -> list[str]:
    """Parts between the commas that are outside of brackets and quotes."""
    items, depth, quote = [""], 0, ""
    for letter in text:
        if letter in "\"'" and quote in ("", letter):
            quote = "" if quote else letter
        if not quote:
            depth += _BRACKETS.get(letter, 0)
        if letter == "," and not quote and depth == 0:
            items.append("")
        else:
            items[-1] += letter
    return items
