"""Lengths of steps: rungs of a ladder, so that what belongs to a length is made once."""

from __future__ import annotations

import math

import numpy as np

#: Rungs to half the step.
_TO_HALF = 2

#: Rung of the first step: the first of a motion has no good guess, and to refuse it is dear.
_BEGINNING = 2

#: After a step was refused, so many steps are taken before longer ones are tried.
_PATIENCE = 3

#: Part of a rung that is left as a margin, and most rungs that steps become longer or shorter by.
_MARGIN, _MOST = 0.25, 4


class Rungs:
    """The length of the next step: the longest one over a power of the root of two.

    The highest coefficient of a smooth remainder, that of degree s - 1, grows by the step to the
    power s.
    """

    def __init__(self, longest: float, nodes: int) -> None:
        """Begin with half of the longest step.

        Args:
            longest: Its length in s.
            nodes: Gauss points s of a step.
        """
        self._longest, self._rung, self._patience = longest, _BEGINNING, 0
        self._growth = nodes * np.log(2) / _TO_HALF

    @property
    def step(self) -> float:
        """Length in s."""
        return float(self._longest * 2.0 ** (-self._rung / _TO_HALF))

    def reach(self, longest: float) -> None:
        """Take no longer steps than this."""
        self._rung = max(self._rung, math.ceil(_TO_HALF * math.log2(self._longest / longest)))

    def accepted(self, error: float) -> None:
        """A step had an error, as a part of what is allowed: longer ones may do."""
        self._patience -= 1
        room = -math.log(max(error, 1e-30)) / self._growth - _MARGIN
        if self._patience < 0 and room >= 1:
            self._rung = max(self._rung - min(int(room), _MOST), 0)

    def refused(self, error: float) -> None:
        """A step had too large an error, infinite if it was not solved: shorter ones may do."""
        over = np.log(error) / self._growth if np.isfinite(error) else _TO_HALF
        self._rung += int(np.clip(np.ceil(over), 1, _MOST))
        self._patience = _PATIENCE
