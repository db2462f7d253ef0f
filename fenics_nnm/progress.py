"""Progress of a run: bars on a terminal, and a line now and then of a long stage elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from fenics_nnm.stages import Stages

#: Seconds between two lines about a stage.
_PATIENCE = 30.0


def _on_stderr(line: str) -> None:
    sys.stderr.write(f"{line}\n")
    sys.stderr.flush()


@contextmanager
def progress(console: Console, tell: Callable[[str], None] = _on_stderr) -> Iterator[Stages]:
    """Stages that show a bar each while the context is open, or tell lines of long stages.

    Args:
        console: Console; without a terminal there are no bars, and if it is quiet no lines either.
        tell: Writes a line.
    """
    if console.quiet:
        yield Stages()
        return
    if not console.is_terminal:
        yield Stages(Lines(tell).hear, tell=tell)
        return
    columns = (TextColumn("{task.description:12}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console) as bars:
        tasks: dict[str, TaskID] = {}

        def show(name: str, done: float) -> None:
            if name not in tasks:
                tasks[name] = bars.add_task(name, total=1.0)
            bars.update(tasks[name], completed=done)

        yield Stages(show, tell=tell)


@dataclass(slots=True)
class Lines:
    """Tells of a stage that takes long how far it is, now and then.

    Attributes:
        tell: Writes a line.
        clock: Seconds.
    """

    tell: Callable[[str], None]
    clock: Callable[[], float] = time.monotonic
    _stage: str = ""
    _begun: float = 0.0
    _told: float = 0.0

    def hear(self, name: str, done: float) -> None:
        """Take note of which part of a stage is done, from 0 to 1."""
        now = self.clock()
        if name != self._stage or not done:
            self._stage, self._begun, self._told = name, now, now
            return
        if done >= 1 or now - self._told < _PATIENCE:
            return
        self._told, spent = now, now - self._begun
        left = spent * (1 - done) / done
        self.tell(f"{name}: {done:.0%} after {duration(spent)}, about {duration(left)} left")


def duration(seconds: float) -> str:
    """Seconds or minutes, in words and round numbers."""
    if seconds < 90:
        return f"{max(1.0, seconds):.0f} s"
    return f"{seconds / 60:.0f} min"
