"""Which studies a sweep has: combinations of values, checked before anything runs."""

from __future__ import annotations

import hashlib
import itertools
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fenics_nnm.errors import StudyError
from fenics_nnm.structure.motions import wanted_motions
from fenics_nnm.study import Study
from fenics_nnm.study.inputs import input_files
from fenics_nnm.study.reading import read_values
from fenics_nnm.study.settings import Setting, settings_from, shown_settings, study_with
from fenics_nnm.study.toml_text import toml_value
from fenics_nnm.study.units import in_its_unit
from fenics_nnm.sweep.settings_table import read_table

#: Two gamma ratios nearer than this are the same.
SAME_RATIO = 1e-6

#: Longest name of a folder; longer ones are cut.
_LONGEST = 100

Settings = tuple[Setting, ...]


@dataclass(frozen=True, slots=True)
class Case:
    """One study of a sweep.

    Attributes:
        number: Its number, from 1.
        settings: Keys that differ from the study file.
        study: The study.
        text: Text of its own study file.
        folder: Folder of its results.
    """

    number: int
    settings: Settings
    study: Study
    text: str
    folder: Path

    def __str__(self) -> str:
        return shown_settings(self.settings)

    @property
    def values(self) -> tuple[Any, ...]:
        """Values of its settings, lengths in the unit of their key."""
        return tuple(in_its_unit(self.study, setting) for setting in self.settings)


@dataclass(frozen=True, slots=True)
class Plan:
    """All studies of a sweep.

    Attributes:
        file: Study file that they are made from.
        folder: Folder that has one folder of each, and the table.
        keys: Keys that are set, in the order of the command line.
        cases: The studies.
        ratios: Gamma ratios that the table gives the frequency at, ascending.
    """

    file: Path
    folder: Path
    keys: tuple[str, ...]
    cases: tuple[Case, ...]
    ratios: tuple[float, ...]


def plan(
    file: Path,
    folder: Path,
    lists: Sequence[str],
    *,
    table: Path | None = None,
    zipped: bool = False,
    ratios: Sequence[float] = (),
) -> Plan:
    """Combine values and check all studies that they make.

    Args:
        file: Study file.
        folder: Folder of the sweep.
        lists: Texts `KEY=VALUE,VALUE,...`.
        table: A CSV file whose rows are combined with the lists: keys in its first row.
        zipped: Take the first values of all lists together, then the second ones, and so on,
            in place of all combinations.
        ratios: Gamma ratios for the table; those that the studies report if none are given.

    Raises:
        StudyError: if a key or value is wrong, a study would come twice, or a ratio has no point.
    """
    values = read_values(file)
    settings = [settings_from(text) for text in lists]
    rows = read_table(table) if table else ((),)
    if not settings and not table:
        raise StudyError("nothing to sweep: give --set KEY=VALUE,VALUE,... or --table FILE.csv")
    _assert_keys_differ([items[0].key for items in settings], [each.key for each in rows[0]])
    combinations = [
        (*row, *chosen) for row in rows for chosen in _combined(settings, zipped=zipped)
    ]
    cases = tuple(_cases(values, file, folder, combinations))
    keys = tuple(setting.key for setting in combinations[0])
    return Plan(file, folder, keys, cases, _ratios(cases, ratios))


def _combined(lists: Sequence[Settings], *, zipped: bool) -> list[Settings]:
    if not zipped:
        return list(itertools.product(*lists))
    lengths = {items[0].key: len(items) for items in lists}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{key} has {length}" for key, length in lengths.items())
        raise StudyError(f"--zip: needs lists of equal length: {listed}")
    return list(zip(*lists, strict=True)) if lists else [()]


def _assert_keys_differ(*groups: Sequence[str]) -> None:
    keys = [key for group in groups for key in group]
    for key in keys:
        if keys.count(key) > 1:
            raise StudyError(f"{key}: is set twice: give all its values in one list")
        if key == "output.folder":
            raise StudyError("output.folder: each study of a sweep has a folder in --output DIR")


def _cases(
    values: dict[str, Any], file: Path, folder: Path, combinations: Sequence[Settings]
) -> Iterator[Case]:
    taken: dict[str, Settings] = {}
    for number, settings in enumerate(combinations, start=1):
        study, text = study_with(values, file, settings)
        name = folder_name(settings)
        if name in taken:
            raise StudyError(f"{shown_settings(settings)}: comes twice")
        taken[name] = settings
        for key, path in input_files(study).items():
            if not path.is_file():
                raise StudyError(
                    f"with {shown_settings(settings)}: {key} = {path}: there is no such file"
                )
        yield Case(number, settings, study, text, folder / name)


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


def _ratios(cases: Sequence[Case], asked: Sequence[float]) -> tuple[float, ...]:
    """Gamma ratios for the table, each of which the studies have a point at."""
    reported = {ratio for case in cases for ratio in case.study.continuation.report_at}
    for ratio in asked:
        if not math.isfinite(ratio) or ratio <= 0:
            raise StudyError(f"--gamma {ratio:g}: must be a positive number")
        for case in cases:
            _assert_has_point(case, ratio)
    return tuple(sorted(set(asked) or reported))


def _assert_has_point(case: Case, ratio: float) -> None:
    known = wanted_motions(case.study).certain_ratios
    if any(abs(ratio - each) <= SAME_RATIO for each in known):
        return
    nearest = sorted(known, key=lambda each: abs(each - ratio))[:2]
    near = f"; there are {' and '.join(f'{each:g}' for each in sorted(nearest))}" if nearest else ""
    raise StudyError(
        f"--gamma {ratio:g}: no point is wanted there with {case}{near}: name it in "
        "continuation.report_at"
    )
