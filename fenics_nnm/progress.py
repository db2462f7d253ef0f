"""Progress of a run: bars on a terminal, and a line now and then of a long stage elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Event, Thread

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from fenics_nnm.stages import NEARLY, Stages, duration

#: Seconds between two lines about a stage, and between two looks at the clock.
_PATIENCE, _PAUSE = 30.0, 1.0

#: What is done in a stage that may take long.
WHAT = {
    "mesh": "the geometry or mesh is read and meshed",
    "assembly": "stiffness and mass",
    "static state": "equilibrium under rotation, temperature and loads",
    "factors": "factors of the stiffness",
    "modes": "linear modes, and a count that none is missed",
    "attachments": "displacements under a unit force at each contact point",
    "second order": "how far the body shortens as it bends",
    "accuracy": "what more harmonics and samples would change",
    "backbone": "points of the nonlinear mode, and their check in time",
    "damped backbone": "resonances over the level of the force",
    "response": "driven motions over the frequency",
    "other pieces": "pieces of the response that are not connected to its ends",
    "in time": "driven motions are followed in time",
    "simulation": "the motion is followed in time",
    "speeds": "the structure at each speed",
    "output": "tables, pictures and ParaView files",
}


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
        lines = Lines(tell)
        with _ticking(lines):
            yield Stages(lines.hear, tell=tell)
        return
    words = TextColumn("{task.fields[what]}")
    columns = (TextColumn("{task.description:12}"), BarColumn(), TimeElapsedColumn(), words)
    with Progress(*columns, console=console) as bars:
        tasks: dict[str, TaskID] = {}

        def show(name: str, done: float) -> None:
            if name not in tasks:
                tasks[name] = bars.add_task(name, total=1.0, what=WHAT.get(name, ""))
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
    _done: float = 0.0

    def hear(self, name: str, done: float) -> None:
        """Take note of which part of a stage is done, from 0 to 1."""
        if name != self._stage or not done:
            self._stage, self._begun = name, self.clock()
            self._told = self._begun
        self._done = done
        self.tick()

    def tick(self) -> None:
        """Tell of the present stage, if nothing was told of it for long."""
        now = self.clock()
        if not self._stage or self._done >= 1 or now - self._told < _PATIENCE:
            return
        self._told, spent = now, now - self._begun
        what = f" ({WHAT[self._stage]})" if self._stage in WHAT else ""
        self.tell(f"{self._stage}{what}: {_far(self._done, spent)}")


def _far(done: float, spent: float) -> str:
    """How far a stage is after some seconds; of some stages no part is known."""
    if not done:
        return f"not done after {duration(spent)}"
    if done >= NEARLY:
        return f"found after {duration(spent)}, and checked now"
    return f"{done:.0%} after {duration(spent)}, about {duration(spent * (1 - done) / done)} left"


@contextmanager
def _ticking(lines: Lines) -> Iterator[None]:
    """Have lines told of stages that report nothing, too, from a thread of their own."""
    ended = Event()

    def tick() -> None:
        while not ended.wait(_PAUSE):
            lines.tick()

    thread = Thread(target=tick, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
