"""Run studies of a sweep one after the other; the failure of one does not stop the others."""

from __future__ import annotations

import logging
import traceback
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field

from fenics_nnm.stages import Stages
from fenics_nnm.structure.shared_analysis import SharedAnalysis
from fenics_nnm.study.error_keys import one_line
from fenics_nnm.sweep.case import Case, RunState


@dataclass(frozen=True, slots=True)
class Ran:
    """That a study was run.

    Attributes:
        number: Its number.
        failure: Why it could not be run, in a line; empty if it ended by itself.
    """

    number: int
    failure: str = ""


@dataclass(slots=True)
class Runner:
    """Runs studies on this process alone, and keeps what the next one can share.

    Attributes:
        stages: Makes timings and progress for a study.
        verbose: Whether to show where errors come from.
        shared: Linear analyses that are shared.
    """

    stages: Callable[[], AbstractContextManager[Stages]]
    verbose: bool = False
    shared: SharedAnalysis = field(default_factory=SharedAnalysis)

    def run(self, case: Case, state: RunState) -> Ran:
        """Run a study, or go on with one that was begun.

        Raises:
            KeyboardInterrupt: as it comes; the points found are kept.
        """
        try:
            with _named(str(case)), self.stages() as stages:
                case.kind.run(
                    case, go_on=state is RunState.BEGUN, stages=stages, shared=self.shared
                )
        except Exception as error:
            if self.verbose:
                traceback.print_exception(error)
            return Ran(case.number, one_line(error))
        return Ran(case.number)


@contextmanager
def _named(name: str) -> Iterator[None]:
    """Put a name in front of all that is logged meanwhile."""

    def put(record: logging.LogRecord) -> bool:
        record.msg, record.args = f"{name}: {record.getMessage()}", ()
        return True

    handlers = logging.getLogger().handlers
    for handler in handlers:
        handler.addFilter(put)
    try:
        yield
    finally:
        for handler in handlers:
            handler.removeFilter(put)
