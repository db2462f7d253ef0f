"""sweep.csv: one row for each study of a sweep."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence

from fenics_nnm.results.durable import replacing
from fenics_nnm.study.toml_text import toml_value
from fenics_nnm.sweep.case import Outcome, Plan


def write_table(plan: Plan, outcomes: Sequence[Outcome]) -> None:
    """Write sweep.csv in the folder of a sweep; an older one is replaced at one instant.

    Raises:
        OSError: if it cannot be written.
    """
    columns = ["study", *plan.keys, "status", *plan.kind.columns(plan), "folder", "message"]
    with (
        replacing(plan.folder / "sweep.csv") as part,
        part.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        for outcome in outcomes:
            writer.writerow(list(_cells(plan, outcome)))


def _cells(plan: Plan, outcome: Outcome) -> Iterator[str]:
    case = outcome.case
    yield str(case.number)
    for value in case.values:
        yield value if isinstance(value, str) else toml_value(value)
    yield outcome.status
    yield from plan.kind.cells(plan, outcome)
    yield str(case.folder.name)
    yield outcome.message
