"""A whole sweep: run what is not done, and put all studies in one table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field

from mpi4py import MPI

from fenics_nnm.errors import NonlinearModeError, OutputError, StudyError
from fenics_nnm.results.own_files import SWEEP, assert_writable
from fenics_nnm.stages import Stages
from fenics_nnm.study.error_keys import one_line
from fenics_nnm.sweep.case import Case, Outcome, Plan, RunState
from fenics_nnm.sweep.dealing import Hand, LocalCounters, grouped
from fenics_nnm.sweep.outcome import outcome_of
from fenics_nnm.sweep.ranks import run_on_ranks
from fenics_nnm.sweep.running import Ran, Runner
from fenics_nnm.sweep.table import write_table
from fenics_nnm.sweep.workers import run_on_processes


@dataclass(slots=True)
class Sweep:
    """A sweep with what is known of its studies.

    Attributes:
        plan: The studies.
        states: How far each was at the beginning, by its number.
        on_outcome: Called with each study that was run here.
        outcomes: What is known of each, by its number.
    """

    plan: Plan
    states: dict[int, RunState]
    on_outcome: Callable[[Outcome], None] | None = None
    outcomes: dict[int, Outcome] = field(default_factory=dict)

    @property
    def left(self) -> list[Case]:
        """Studies that are not done."""
        return [c for c in self.plan.cases if self.states[c.number] is not RunState.ENDED]

    @property
    def in_order(self) -> list[Outcome]:
        """What is known of all studies, in their order."""
        return [self.outcomes[case.number] for case in self.plan.cases]

    def make_folder(self) -> None:
        """Make the folder of the sweep, so that no study takes it for its own.

        Raises:
            StudyError: if it cannot be made, or has files of somebody else by names of ours.
        """
        folder = self.plan.folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StudyError(f"--output {folder}: cannot be written: {error.strerror}") from error
        assert_writable(folder, SWEEP)

    def run(self, stages: Callable[[], AbstractContextManager[Stages]], *, verbose: bool) -> None:
        """Run what is left on this process; the table is up to date after each study."""
        runner = Runner(stages, verbose=verbose)
        groups = grouped(self.left)
        hand = Hand(groups, LocalCounters([0] * len(groups)), 0)
        while (case := hand.take()) is not None:
            self._note(runner.run(case, self.states[case.number]))
            self.write_table()

    def run_on_processes(self, jobs: int, *, verbose: bool) -> None:
        """Run what is left on processes of this machine."""

        def note(ran: Ran) -> None:
            self._note(ran)
            self.write_table()

        groups = grouped(self.left)
        run_on_processes(groups, self.states, jobs, note, verbose=verbose)

    def run_on_ranks(
        self,
        stages: Callable[[], AbstractContextManager[Stages]],
        comm: MPI.Intracomm,
        *,
        verbose: bool,
    ) -> None:
        """Run what is left on the ranks; all of them know of all studies in the end."""
        runner, groups = Runner(stages, verbose=verbose), grouped(self.left)
        if not groups:
            return

        def run(case: Case) -> Ran:
            ran = runner.run(case, self.states[case.number])
            self._note(ran)
            return ran

        for ran in run_on_ranks(groups, run, comm):
            if ran.number not in self.outcomes:
                self._note(ran, report=False)

    def look(self) -> None:
        """Look again at the folders of studies that were not reported."""
        for case in self.plan.cases:
            if case.number not in self.outcomes:
                self._note(Ran(case.number), report=False)

    def write_table(self) -> None:
        """Write sweep.csv.

        Raises:
            OutputError: if it cannot be written.
        """
        known = Sweep(self.plan, self.states, outcomes=dict(self.outcomes))
        known.look()
        try:
            write_table(self.plan, known.in_order)
        except OSError as error:
            reason = error.strerror or error
            raise OutputError(f"{self.plan.folder}: cannot be written: {reason}") from error

    def _note(self, ran: Ran, *, report: bool = True) -> None:
        case = self.plan.cases[ran.number - 1]
        self.outcomes[ran.number] = outcome = _outcome(case, ran.failure)
        if report and self.on_outcome:
            self.on_outcome(outcome)


def begun(plan: Plan) -> Sweep:
    """A sweep that has looked at the folders of its studies.

    Raises:
        StudyError: if one of them has results of another study.
        OutputError: if results cannot be read.
    """
    sweep = Sweep(plan, {case.number: case.kind.state(case) for case in plan.cases})
    for case in plan.cases:
        if sweep.states[case.number] is RunState.ENDED:
            sweep.outcomes[case.number] = outcome_of(case, RunState.ENDED)
    return sweep


def _outcome(case: Case, failure: str) -> Outcome:
    """What is known of a study that was run, or may have been."""
    if failure:
        return outcome_of(case, RunState.NEW, failure)
    try:
        return outcome_of(case, case.kind.state(case))
    except NonlinearModeError as error:
        return Outcome(case, "failed", one_line(error))


def failures(outcomes: Sequence[Outcome]) -> list[str]:
    """Studies that are not complete, each in a line with the reason."""
    return [
        f"{each.case}: {each.status}{f': {each.message}' if each.message else ''}"
        for each in outcomes
        if not each.complete
    ]
