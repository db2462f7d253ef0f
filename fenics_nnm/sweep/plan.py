"""Which studies a sweep has: combinations of values, checked before anything runs."""

from __future__ import annotations

import hashlib
import itertools
import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fenics_nnm.errors import StudyError
from fenics_nnm.study.inputs import input_files
from fenics_nnm.study.reading import read_values
from fenics_nnm.study.settings import Setting, settings_from, shown_settings, study_with
from fenics_nnm.study.toml_text import toml_value
from fenics_nnm.sweep.asked import Asked
from fenics_nnm.sweep.case import Case, Kind, Plan, Settings
from fenics_nnm.sweep.settings_table import read_table

_NOTHING = Asked()

#: Longest name of a folder; longer ones are cut.
_LONGEST = 100


def plan(
    file: Path,
    folder: Path,
    lists: Sequence[str],
    kind: Kind,
    *,
    table: Path | None = None,
    zipped: bool = False,
    asked: Asked = _NOTHING,
) -> Plan:
    """Combine values and check all studies that they make.

    Args:
        file: Study file.
        folder: Folder of the sweep.
        lists: Texts `KEY=VALUE,VALUE,...`.
        kind: What is found of each study.
        table: A CSV file whose rows are combined with the lists: keys in its first row.
        zipped: Take the first values of all lists together, then the second ones, and so on,
            in place of all combinations.
        asked: Points for the table; without ratios those that the studies report.

    Raises:
        StudyError: if a key or value is wrong, a study would come twice, or a ratio has no point.
    """
    values = read_values(file)
    settings = [settings_from(text) for text in lists]
    rows = read_table(table) if table else ((),)
    if not settings and not table:
        raise StudyError("nothing to sweep: give --set KEY=VALUE,VALUE,... or --table FILE.csv")
    keys = [*(items[0].key for items in settings), *(each.key for each in rows[0])]
    _assert_keys_differ(keys)
    common = asked.settings(values, keys)
    combinations = [
        (*row, *chosen) for row in rows for chosen in _combined(settings, zipped=zipped)
    ]
    return _planned(Base(file, values, common), folder, combinations, kind, asked)


def plan_of(path: Path, text: str, folder: Path, lists: Sequence[Settings], kind: Kind) -> Plan:
    """Combine values of keys of a study that is no file, and check all studies that they make.

    Args:
        path: Place of the study, that files are relative to.
        text: Text of its study file.
        folder: Folder of the sweep.
        lists: Settings of each key.
        kind: What is found of each study.

    Raises:
        StudyError: as of `plan`.
    """
    if not lists or not all(lists):
        raise StudyError("nothing to sweep: give values of one key at least")
    _assert_keys_differ([items[0].key for items in lists])
    base = Base(path, tomllib.loads(text), ())
    return _planned(base, folder, _combined(lists, zipped=False), kind, _NOTHING)


def _planned(
    base: Base, folder: Path, combinations: Sequence[Settings], kind: Kind, asked: Asked
) -> Plan:
    cases = tuple(_cases(base, folder, combinations, kind))
    keys = tuple(setting.key for setting in combinations[0])
    return Plan(base.file, folder, keys, cases, kind.ratios(cases, asked), base.common)


@dataclass(frozen=True, slots=True)
class Base:
    """What all studies are made from.

    Attributes:
        file: Study file.
        values: Its values.
        common: Keys that all studies have anew.
    """

    file: Path
    values: dict[str, Any]
    common: Settings


def _combined(lists: Sequence[Settings], *, zipped: bool) -> list[Settings]:
    if not zipped:
        return list(itertools.product(*lists))
    lengths = {items[0].key: len(items) for items in lists}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{key} has {length}" for key, length in lengths.items())
        raise StudyError(f"--zip: needs lists of equal length: {listed}")
    return list(zip(*lists, strict=True)) if lists else [()]


def _assert_keys_differ(keys: Sequence[str]) -> None:
    for key in keys:
        if keys.count(key) > 1:
            raise StudyError(f"{key}: is set twice: give all its values in one list")
        if key == "output.folder":
            raise StudyError("output.folder: each study of a sweep has a folder in --output DIR")


def _cases(
    base: Base, folder: Path, combinations: Sequence[Settings], kind: Kind
) -> Iterator[Case]:
    taken: dict[str, Settings] = {}
    for number, settings in enumerate(combinations, start=1):
        study, text = study_with(base.values, base.file, (*base.common, *settings))
        kind.assert_possible(study)
        name = folder_name(settings)
        if name in taken:
            raise StudyError(f"{shown_settings(settings)}: comes twice")
        taken[name] = settings
        for key, path in input_files(study).items():
            if not path.is_file():
                raise StudyError(
                    f"with {shown_settings(settings)}: {key} = {path}: there is no such file"
                )
        yield Case(number, settings, study, text, folder / name, kind)


def folder_name(settings: Settings) -> str:
    """Name of the folder of a study, the same in whatever order its keys are set."""
    parts, exact = [], []
    for setting in sorted(settings, key=lambda setting: setting.key):
        value = setting.value
        word = value if isinstance(value, str) else toml_value(value)
        parts.append(f"{setting.key}={word}")
        exact.append(f"{setting.key}={toml_value(value)}")
    name = "_".join(parts)
    plain = re.sub(r"[^\w.+=,-]+", "-", name)
    if plain == name and len(name) <= _LONGEST and not any(map(_like_a_number, settings)):
        return name
    digest = hashlib.sha256(",".join(exact).encode()).hexdigest()[:8]
    return f"{plain[:_LONGEST]}-{digest}"


def _like_a_number(setting: Setting) -> bool:
    """Whether a text could be taken for a number, so that its folder needs a name of its own."""
    if not isinstance(setting.value, str):
        return False
    try:
        float(setting.value)
    except ValueError:
        return setting.value in ("true", "false")
    return True
