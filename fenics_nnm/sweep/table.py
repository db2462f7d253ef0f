"""sweep.csv: one row for each study of a sweep."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterator, Sequence

from fenics_nnm.backbone.point import STATUSES
from fenics_nnm.results.durable import replacing
from fenics_nnm.study.toml_text import toml_value
from fenics_nnm.sweep.outcome import Outcome
from fenics_nnm.sweep.plan import Plan

#: Columns before and after the keys that are set.
FIRST = ("study",)
SECOND = ("status", "linear_frequency_Hz")
LAST = (
    "points",
    *(f"points_{status.replace(' ', '_')}" for status in STATUSES),
    "largest_gamma_ratio",
)
NAMES = ("folder", "message")

#: Columns of each gamma ratio, with the ratio behind.
AT_RATIO = ("frequency_Hz_at", "energy_J_at")


def write_table(plan: Plan, outcomes: Sequence[Outcome]) -> None:
    """Write sweep.csv in the folder of a sweep; an older one is replaced at one instant.

    Raises:
        OSError: if it cannot be written.
    """
    at = [f"{name}_{ratio:g}" for ratio in plan.ratios for name in AT_RATIO]
    with (
        replacing(plan.folder / "sweep.csv") as part,
        part.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*FIRST, *plan.keys, *SECOND, *at, *LAST, *NAMES])
        for outcome in outcomes:
            writer.writerow(list(_cells(plan, outcome)))


def _cells(plan: Plan, outcome: Outcome) -> Iterator[str]:
    case, rows = outcome.case, outcome.rows
    yield str(case.number)
    for value in case.values:
        yield value if isinstance(value, str) else toml_value(value)
    yield outcome.status
    yield _printed(outcome.linear_frequency)
    for ratio in plan.ratios:
        row = outcome.at(ratio)
        yield _printed(row.frequency if row else None)
        yield _printed(row.energy if row else None)
    counts = Counter(row.status for row in rows)
    yield str(len(rows)) if outcome.linear_frequency is not None else ""
    for status in STATUSES:
        yield str(counts[status]) if outcome.linear_frequency is not None else ""
    yield _printed(max((row.gamma_ratio for row in rows), default=None))
    yield str(case.folder.name)
    yield outcome.message


def _printed(value: float | None) -> str:
    return "" if value is None else f"{value:.10g}"
