"""What the folder of a study holds: whether it is done, and its backbone."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

from fenics_nnm.errors import OutputError, StudyError
from fenics_nnm.results import branch_file
from fenics_nnm.results.resume import difference, stored_run
from fenics_nnm.results.staging import running_folders, stopped_runs
from fenics_nnm.results.stored_text import values_of
from fenics_nnm.study.inputs import input_digests
from fenics_nnm.sweep.plan import SAME_RATIO, Case


class RunState(Enum):
    """How far a study is."""

    NEW = "not run"
    #: A run was stopped, or ended for other energies or files: its points are taken over.
    BEGUN = "stopped"
    ENDED = "ended"


@dataclass(frozen=True, slots=True)
class TableRow:
    """A point of a backbone, as backbone.csv has it; frequency in Hz, energy in J."""

    gamma_ratio: float
    frequency: float
    energy: float
    status: str
    stability: str


@dataclass(frozen=True, slots=True)
class Outcome:
    """What is known of a study.

    Attributes:
        case: The study.
        status: "complete", "incomplete" (ended, but some energies have no point), "stopped",
            "failed" or "not run".
        message: Why it is not complete; empty if it is.
        linear_frequency: Frequency of its linear mode in Hz; None without results.
        rows: Its points in the order of the branch.
    """

    case: Case
    status: str
    message: str = ""
    linear_frequency: float | None = None
    rows: tuple[TableRow, ...] = ()

    @property
    def complete(self) -> bool:
        """Whether all that was asked for is there."""
        return self.status == "complete"

    def at(self, ratio: float) -> TableRow | None:
        """The first point at a gamma ratio, none if there is none."""
        found = (each for each in self.rows if abs(each.gamma_ratio - ratio) <= SAME_RATIO)
        return next(found, None)


def state_of(case: Case) -> RunState:
    """How far a study is.

    Raises:
        StudyError: if its folder has results of another study, or a file that it names has changed.
        OutputError: if the results cannot be read.
    """
    folder = case.folder
    branch, summary = folder / "branch.h5", folder / "summary.json"
    if branch.exists() and summary.exists():
        return _state_of_ended(case, branch_file.study_text(branch), _read(summary))
    if branch.exists() or running_folders(folder):
        stored = stored_run(folder, stopped_runs(folder), case.text)
        return RunState.BEGUN if stored else RunState.NEW
    return RunState.NEW


def _state_of_ended(case: Case, stored: str, summary: Mapping[str, Any]) -> RunState:
    advice = f"remove {case.folder}, or choose another --output"
    found = difference(stored, case.text)
    if found:
        raise StudyError(f"{case.folder}: is of another study: {found}: {advice}")
    for key, digest in input_digests(case.study).items():
        if summary.get("inputs_sha256", {}).get(key) != digest:
            raise StudyError(
                f"{case.folder}: is of another study: the file of {key} has changed: {advice}"
            )
    same = values_of(stored) == values_of(case.text)
    return RunState.ENDED if same else RunState.BEGUN


def outcome_of(case: Case, state: RunState, failure: str = "") -> Outcome:
    """What the folder of a study holds.

    Args:
        case: Study.
        state: How far it is.
        failure: Why it could not be run, if it could not.

    Raises:
        OutputError: if the results cannot be read.
    """
    if state is not RunState.ENDED:
        status = "failed" if failure else state.value
        note = "" if state is RunState.NEW else "its points are kept: sweep again to go on"
        return Outcome(case, status, failure or note)
    summary = _read(case.folder / "summary.json")
    complete = summary["complete"]
    return Outcome(
        case,
        "complete" if complete else "incomplete",
        "" if complete else summary["reason"],
        summary["linear_frequencies_Hz"][case.study.mode.number - 1],
        _rows(case.folder / "backbone.csv"),
    )


def _read(path: Path) -> dict[str, Any]:
    try:
        return dict(json.loads(path.read_bytes()))
    except (OSError, ValueError) as error:
        raise OutputError(f"{path}: cannot be read: {error}") from error


def _rows(path: Path) -> tuple[TableRow, ...]:
    try:
        with path.open(newline="") as file:
            return tuple(_row(row) for row in csv.DictReader(file))
    except (OSError, KeyError, ValueError) as error:
        raise OutputError(f"{path}: cannot be read: {error}") from error


def _row(row: Mapping[str, str]) -> TableRow:
    return TableRow(
        gamma_ratio=float(row["gamma_ratio"]),
        frequency=float(row["frequency_Hz"]),
        energy=float(row["energy_J"]),
        status=row["status"],
        stability=row["stability"],
    )
