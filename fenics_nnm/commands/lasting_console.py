"""The console that results are printed on."""

from __future__ import annotations

import os
import sys

from rich.console import Console

#: Characters of a line where there is no terminal, whose lines are as wide as they are read.
_WIDTH = 160


class LastingConsole(Console):
    """A console whose reader may go away, as `head` does: the work goes on without it."""

    def __init__(self, *, quiet: bool = False, force_terminal: bool | None = None) -> None:
        """A console on standard output.

        Args:
            quiet: Whether it prints nothing.
            force_terminal: Whether it is a terminal; to be found out if not given.
        """
        super().__init__(quiet=quiet, force_terminal=force_terminal)
        if not self.is_terminal:
            self.width = _WIDTH

    def on_broken_pipe(self) -> None:
        """Print no more."""
        self.quiet = True
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
