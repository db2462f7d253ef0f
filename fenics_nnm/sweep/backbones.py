"""The backbones of a sweep: run, looked at in their folders, and put in a table."""

from __future__ import annotations

import csv
import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpi4py import MPI

from fenics_nnm.backbone.point import STATUSES
from fenics_nnm.backbone.quantities import Sought
from fenics_nnm.errors import OutputError, StudyError
from fenics_nnm.results import branch_file
from fenics_nnm.results.folder import assert_replaceable
from fenics_nnm.results.resume import assert_nobody_runs, stored_run
from fenics_nnm.results.staging import running_folders, stopped_runs
from fenics_nnm.run import run_study
from fenics_nnm.stages import Stages
from fenics_nnm.structure.motions import wanted_motions
from fenics_nnm.structure.shared_analysis import SharedAnalysis
from fenics_nnm.study import Study
from fenics_nnm.sweep.asked import Asked
from fenics_nnm.sweep.case import EXTREMES, SAME_RATIO, Case, Outcome, Plan, RunState, TableRow
from fenics_nnm.sweep.cells import printed
from fenics_nnm.sweep.outcome import state_of_ended

#: Columns of each gamma ratio, with the ratio behind.
_AT_RATIO = ("frequency_Hz_at", "energy_J_at", *(f"{name}_at" for name in EXTREMES))

#: Columns of each value that the studies ask for, with the value behind.
_AT_VALUE = ("gamma_ratio_at", *_AT_RATIO)


@dataclass(frozen=True, slots=True)
class Backbones:
    """Nonlinear modes over energy, as `fenics-nnm run` follows them."""

    command: str = "run"

    def assert_possible(self, study: Study) -> None:
        """Every study has a mode."""

    def ratios(self, cases: Sequence[Case], asked: Asked) -> tuple[float, ...]:
        """Gamma ratios for the table, each of which the studies have a point at."""
        reported = {ratio for case in cases for ratio in case.study.continuation.report_at}
        for ratio in asked.ratios:
            if not math.isfinite(ratio) or ratio <= 0:
                raise StudyError(f"--gamma {ratio:g}: must be a positive number")
            for case in cases:
                _assert_has_point(case, ratio)
        return tuple(sorted(set(asked.ratios) or reported))

    def state(self, case: Case) -> RunState:
        """How far a study is."""
        folder = case.folder
        assert_replaceable(folder, [])
        branch, summary = folder / "branch.h5", folder / "summary.json"
        if branch.exists() and summary.exists():
            digests = _read(summary).get("inputs_sha256", {})
            return state_of_ended(case, branch_file.study_text(branch), digests)
        if branch.exists() or running_folders(folder):
            stored = stored_run(folder, stopped_runs(folder), case.text)
            return RunState.BEGUN if stored else RunState.NEW
        return RunState.NEW

    def run(self, case: Case, *, go_on: bool, stages: Stages, shared: SharedAnalysis) -> None:
        """Follow the mode of a study on this process alone."""
        assert_nobody_runs(case.folder)
        run_study(
            case.study,
            case.text,
            case.folder,
            resume=go_on,
            comm=MPI.COMM_SELF,
            stages=stages,
            analyse=shared,
        )

    def ended(self, case: Case) -> Outcome:
        """What the folder of a study that ended holds."""
        summary = _read(case.folder / "summary.json")
        complete = summary["complete"]
        return Outcome(
            case,
            "complete" if complete else "incomplete",
            "" if complete else summary["reason"],
            summary["linear_frequencies_Hz"][case.study.mode.number - 1],
            _rows(case.folder / "backbone.csv"),
        )

    def columns(self, plan: Plan) -> list[str]:
        """Names of its columns of sweep.csv."""
        return [
            "linear_frequency_Hz",
            *(f"{name}_{ratio:g}" for ratio in plan.ratios for name in _AT_RATIO),
            *(f"{name}_{_named(value)}" for value in _sought(plan) for name in _AT_VALUE),
            "points",
            *(f"points_{status.replace(' ', '_')}" for status in STATUSES),
            "largest_gamma_ratio",
        ]

    def cells(self, plan: Plan, outcome: Outcome) -> Iterator[str]:
        """Its cells of the row of a study."""
        yield printed(outcome.linear_frequency)
        for ratio in plan.ratios:
            yield from _numbers(outcome.at(ratio))
        for value in _sought(plan):
            row = outcome.asked(value)
            yield printed(row.gamma_ratio if row else None)
            yield from _numbers(row)
        counts, known = Counter(row.status for row in outcome.rows), bool(outcome.linear_frequency)
        yield str(len(outcome.rows)) if known else ""
        for status in STATUSES:
            yield str(counts[status]) if known else ""
        yield printed(max((row.gamma_ratio for row in outcome.rows), default=None))

    def draw(self, plan: Plan, outcomes: Sequence[Outcome], title: str) -> list[str]:
        """Draw the backbones, and the frequency over the key if one number is swept."""
        from fenics_nnm.sweep.pictures import draw_sweep

        return draw_sweep(plan, outcomes, title)


def _numbers(row: TableRow | None) -> Iterator[str]:
    """Cells of `_AT_RATIO` of a point, or empty ones."""
    yield printed(row.frequency if row else None)
    yield printed(row.energy if row else None)
    for name in EXTREMES:
        yield printed(row.extremes.get(name) if row else None)


def _sought(plan: Plan) -> list[Sought]:
    """Values of quantities that the studies report points at, each once."""
    listed = [each for case in plan.cases for each in case.study.continuation.sought]
    return list(dict.fromkeys(each for each in listed if each.reported))


def _named(sought: Sought) -> str:
    """A value as a part of the name of a column: "amplitude_0.002_m"."""
    return str(sought).replace(" ", "_")


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
        extremes={name: float(row[name]) for name in EXTREMES if row.get(name)},
        asked=row.get("asked_for", ""),
    )
