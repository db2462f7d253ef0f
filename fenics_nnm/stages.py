"""Stages of a run: how long each took and how far the present one is."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

logger = logging.getLogger(__name__)

#: Called with the name of a stage and the part of it that is done, from 0 to 1.
Listener = Callable[[str, float], None]

#: Most of a stage that is done before its end: checks of what was found may take long.
NEARLY = 0.99


@dataclass(slots=True)
class Stages:
    """Times the stages of a run and reports to a listener.

    Attributes:
        listener: Called at the beginning, at each report and at the end of a stage.
        timings: Seconds each stage took, in the order of the stages.
        tell: Writes a line for the user, such as how long a run is going to take.
    """

    listener: Listener = lambda name, done: None
    timings: dict[str, float] = field(default_factory=dict)
    tell: Callable[[str], None] = logger.info
    _current: str = ""

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what happens inside; a stage entered again goes on counting."""
        self._current = name
        start = time.perf_counter()
        self.listener(name, 0.0)
        try:
            yield
        finally:
            spent = time.perf_counter() - start
            self.timings[name] = self.timings.get(name, 0.0) + spent
        self.listener(name, 1.0)
        logger.info("%s: %.2f s", name, spent)

    def report(self, done: float) -> None:
        """Report to the listener which part of the present stage is done; all of it at its end."""
        self.listener(self._current, min(done, NEARLY))


def duration(seconds: float) -> str:
    """Seconds, half minutes up to ten, or minutes, in words."""
    if seconds < 90:
        return f"{max(1.0, seconds):.0f} s"
    if seconds < 600:
        return f"{round(seconds / 30) / 2:g} min"
    return f"{seconds / 60:.0f} min"
