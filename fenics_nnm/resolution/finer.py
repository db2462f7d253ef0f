"""Which number to raise next, and by how much."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.resolution.accuracy import Accuracy
from fenics_nnm.study import Study
from fenics_nnm.study.resolution import Resolution

#: Numbers to begin with, and the largest ones tried.
_LEAST = Resolution(harmonics=5, samples=64, modes=10)
MOST = Resolution(harmonics=80, samples=16384, modes=160)

#: Coefficients of a motion, (N + 1) J or twice that, at most: a Newton step takes a second then.
_MOST_UNKNOWNS = 2400

#: A number grows by the second factor where it is too small by more than the first one.
_GROWTH = ((4.0, 2.0), (2.5, 1.4), (0.0, 1.2))

#: Fewest samples a harmonic.
_SAMPLES_A_HARMONIC = 8

#: Harmonics that grow by the first factor must lower the error by the second one.
_STAGNANT = (3.9, 0.8)

#: Orders that errors are taken to fall with, to tell what a tolerance would need.
_ORDERS = {"harmonics": 1, "samples": 2, "modes": 2}


def least(study: Study) -> Resolution:
    """Numbers to begin with: the least ones, and those that are given."""
    given = {"harmonics": study.mode.harmonics, "samples": study.mode.samples}
    given["modes"] = study.reduction.modes
    kept = {name: value for name, value in given.items() if value != "auto"}
    fewest = {"modes": max(_LEAST.modes, study.mode.number)}
    begin = replace(_LEAST, **{**fewest, **kept})
    if "harmonics" in study.automatic:
        most = (begin.samples - 1) // study.samples_a_harmonic
        begin = replace(begin, harmonics=min(begin.harmonics, most))
    return with_samples(study, begin)


@dataclass(slots=True)
class Finer:
    """Run state of a search for numbers.

    Attributes:
        study: Study with "auto" in it.
        free: Sources of error whose numbers may still be raised.
        limits: Why the others may not, by the source.
    """

    study: Study
    free: list[str] = field(default_factory=list)
    limits: dict[str, str] = field(default_factory=dict)
    _best: tuple[int, float] = (0, np.inf)

    def __post_init__(self) -> None:
        self.free = list(self.study.automatic)

    def raised(self, at: Resolution, found: Accuracy) -> Resolution | None:
        """The numbers to try next; None where nothing is left to raise, or to be gained.

        Args:
            at: Numbers tried.
            found: Errors with them.
        """
        while self.free and not found.only(self.free).meets(self.study.tolerance):
            source = max(self.free, key=found.of)
            excess = 2 * found.of(source) / (found.allowance * self.study.tolerance)
            number = self._next(source, at, excess)
            limit = self._limit(source, at, found.harmonics)
            if not limit:
                return with_samples(self.study, replace(at, **{source: number}))
            self.limits[source] = limit
            self.free.remove(source)
        return None

    def has_all_modes(self, count: int) -> None:
        """Take note that there are no more modes than `count`."""
        if "modes" in self.free:
            self.free.remove("modes")
            self.limits["modes"] = f"the structure has {count}"

    def _next(self, source: str, at: Resolution, excess: float) -> int:
        """A larger number; `excess` is the error over what it should be."""
        factor = excess ** (1 / _ORDERS[source])
        if source == "samples":
            return at.samples * 2 ** int(np.clip(np.ceil(np.log2(factor)), 1, 3))
        now = at.harmonics if source == "harmonics" else at.modes
        growth = next(growth for least, growth in _GROWTH if factor >= least)
        return int(np.ceil(now * growth))

    def _limit(self, source: str, at: Resolution, harmonics_error: float) -> str:
        """Why a number is not raised, or nothing."""
        rows = 2 if self.study.mode.series == "general" else 1
        unknowns = rows * (at.harmonics + 1) * at.modes
        now, most = getattr(at, source), getattr(MOST, source)
        if source == "harmonics":
            if "samples" not in self.study.automatic:
                most = min(most, (at.samples - 1) // self.study.samples_a_harmonic)
            if self._stagnates(at.harmonics, harmonics_error):
                return "more of them do not lower the error: internal resonances"
        if 1.2 * now > most:
            return f"the largest number tried is {most}"
        if source != "samples" and 1.2 * unknowns > _MOST_UNKNOWNS:
            return f"a motion has {unknowns} coefficients, and at most {_MOST_UNKNOWNS} are tried"
        return ""

    def _stagnates(self, harmonics: int, error: float) -> bool:
        best, lowest = self._best
        if error < _STAGNANT[1] * lowest:
            self._best = (harmonics, error)
            return False
        return harmonics >= _STAGNANT[0] * best


def needed(source: str, now: int, error: float, tolerance: float) -> int:
    """About the number that a source of error needs to stay below a tolerance."""
    return int(np.ceil(now * (error / tolerance) ** (1 / _ORDERS[source])))


def with_samples(study: Study, at: Resolution) -> Resolution:
    """The numbers with as many samples as the harmonics need at least, where they are not given."""
    if "samples" not in study.automatic:
        return at
    few = _SAMPLES_A_HARMONIC * at.harmonics
    return replace(at, samples=max(at.samples, 2 ** int(np.ceil(np.log2(few)))))
