"""The studies of a sweep, what is known of them, and what is found of each.

A study is given to a kind of results, which finds and reads them: the backbone of a mode, or the
response to forces.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any, Protocol

from fenics_nnm.backbone.quantities import Sought
from fenics_nnm.response.levels import Response
from fenics_nnm.stages import Stages
from fenics_nnm.structure.shared_analysis import SharedAnalysis
from fenics_nnm.study import Study
from fenics_nnm.study.settings import Setting, shown_settings
from fenics_nnm.study.units import in_its_unit
from fenics_nnm.sweep.asked import Asked

Settings = tuple[Setting, ...]

#: Two gamma ratios nearer than this are the same.
SAME_RATIO = 1e-6

_NOTHING = Response(())


class RunState(Enum):
    """How far a study is."""

    NEW = "not run"
    #: A run was stopped, or ended for other energies or files: its points are taken over.
    BEGUN = "stopped"
    ENDED = "ended"


#: Columns of backbone.csv that sweep.csv has, too, where they are known.
EXTREMES = (
    "displacement_m",
    "von_mises_Pa",
    "contact_force_N",
    "contact_impulse_Ns",
    "yield_margin",
    "goodman_margin",
)


@dataclass(frozen=True, slots=True)
class TableRow:
    """A point of a backbone, as backbone.csv has it; frequency in Hz, energy in J.

    Attributes:
        extremes: Those of its columns in `EXTREMES` that have a number.
        asked: Values of the study that the point has, as column `asked_for`.
    """

    gamma_ratio: float
    frequency: float
    energy: float
    status: str
    stability: str
    extremes: Mapping[str, float] = field(default_factory=dict)
    asked: str = ""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What is known of a study.

    Attributes:
        case: The study.
        status: "complete", "incomplete" (ended, but something that it asks for is not there),
            "stopped", "failed" or "not run".
        message: Why it is not complete; empty if it is.
        linear_frequency: Frequency of its linear mode in Hz; None without results, or of a
            response.
        rows: Points of its backbone in the order of the branch.
        response: Its response; without motions of a backbone.
    """

    case: Case
    status: str
    message: str = ""
    linear_frequency: float | None = None
    rows: tuple[TableRow, ...] = ()
    response: Response = _NOTHING

    @property
    def complete(self) -> bool:
        """Whether all that was asked for is there."""
        return self.status == "complete"

    @property
    def points(self) -> int:
        """Number of points of its backbone, or of its response."""
        return len(self.rows) + len(self.response.points)

    def asked(self, sought: Sought) -> TableRow | None:
        """The first point that has a value that the study asks for, none if there is none."""
        found = (
            each
            for each in self.rows
            if any(text.startswith(str(sought)) for text in each.asked.split("; "))
        )
        return next(found, None)

    def at(self, ratio: float) -> TableRow | None:
        """The first point at a gamma ratio, none if there is none."""
        found = (each for each in self.rows if abs(each.gamma_ratio - ratio) <= SAME_RATIO)
        return next(found, None)


@dataclass(frozen=True, slots=True)
class Case:
    """One study of a sweep.

    Attributes:
        number: Its number, from 1.
        settings: Keys that differ from the study file.
        study: The study.
        text: Text of its own study file.
        folder: Folder of its results.
        kind: What is found of it.
    """

    number: int
    settings: Settings
    study: Study
    text: str
    folder: Path
    kind: Kind

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
        ratios: Gamma ratios that the table gives the frequency at, ascending; none of responses.
        common: Keys that all studies have besides their own: points that the sweep asks for.
    """

    file: Path
    folder: Path
    keys: tuple[str, ...]
    cases: tuple[Case, ...]
    ratios: tuple[float, ...]
    common: Settings = ()

    @property
    def kind(self) -> Kind:
        """What is found of each study."""
        return self.cases[0].kind


class Kind(Protocol):
    """How results of one kind are found, looked at, put in a table, and drawn."""

    @property
    def command(self) -> str:
        """The command that finds them of one study."""

    def assert_possible(self, study: Study) -> None:
        """Refuse a study without such results.

        Raises:
            StudyError: with the reason.
        """

    def ratios(self, cases: Sequence[Case], asked: Asked) -> tuple[float, ...]:
        """Gamma ratios for the table, ascending.

        Raises:
            StudyError: if an asked one, or an amount, cannot be had.
        """

    def state(self, case: Case) -> RunState:
        """How far a study is.

        Raises:
            StudyError: if its folder has results of another study, or a file that it names has
                changed.
            OutputError: if the results cannot be read.
        """

    def run(self, case: Case, *, go_on: bool, stages: Stages, shared: SharedAnalysis) -> None:
        """Find the results of a study on this process alone.

        Args:
            case: Study.
            go_on: Whether to go on from what an earlier run has found.
            stages: Timings and progress.
            shared: Linear analyses that studies share.
        """

    def ended(self, case: Case) -> Outcome:
        """What the folder of a study that ended holds.

        Raises:
            OutputError: if the results cannot be read.
        """

    def columns(self, plan: Plan) -> list[str]:
        """Names of its columns of sweep.csv, between the status and the folder."""

    def cells(self, plan: Plan, outcome: Outcome) -> Iterator[str]:
        """Its cells of the row of a study."""

    def draw(self, plan: Plan, outcomes: Sequence[Outcome], title: str) -> list[str]:
        """Draw the pictures of a sweep; names of the files in its folder.

        Raises:
            OSError: if they cannot be written.
        """
