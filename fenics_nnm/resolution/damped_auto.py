"""Harmonics, samples and modes of damped motions that meet a tolerance: `"auto"` with damping.

Damped motions are exact in time, so the number of modes alone decides on their frequency. It is
raised by a half until that changes little. With an error that falls as J^-2 the change from J modes
to 3/2 J is 5/4 of what is left. Harmonics are as many as a motion that is written in them needs to
come back within 5 % after a period: to be verified.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from mpi4py import MPI

from fenics_nnm.backbone.damped_branch import DampedMaker
from fenics_nnm.backbone.damped_motions import Found, damped_motions
from fenics_nnm.backbone.point import VERIFIED
from fenics_nnm.errors import StudyError
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.resolution.accuracy import Accuracy
from fenics_nnm.resolution.finer import MOST, with_samples
from fenics_nnm.study import Study
from fenics_nnm.study.resolution import Resolution

#: Numbers of modes and harmonics grow by this factor.
_GROWTH = 1.5

#: What is left of the error over the last change.
_LEFT = 1 / (_GROWTH**2 - 1)

#: Largest number of modes tried: the transition over a period takes its cube.
_MOST_MODES = 80

#: Motions that are looked at, spread over those that are asked for.
_PROBES = 3


@dataclass(frozen=True, slots=True)
class DampedNumbers:
    """Numbers found.

    Attributes:
        resolution: The numbers.
        expected: Errors that are left.
        energies: Gamma ratios of the motions that were looked at.
        limits: Why numbers were not raised any more, by the source of the error.
    """

    resolution: Resolution
    expected: Accuracy
    energies: tuple[float, ...]
    limits: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Tried:
    """Damped motions with a number of modes.

    Attributes:
        modes: That number.
        maker: Makes their points.
        motions: Motions at the gamma ratios that are looked at.
    """

    modes: int
    maker: DampedMaker
    motions: tuple[Found, ...]

    @classmethod
    def of(cls, comm: MPI.Comm, modes: int, maker: DampedMaker, ratios: Sequence[float]) -> Tried:
        """Find them; to be called on all ranks."""
        return cls(modes, maker, on_root(comm, _motions, maker, ratios))

    @property
    def failure(self) -> str:
        """Why none was found, or nothing."""
        failures = [each.motion.failure for each in self.motions]
        return failures[0] if all(failures) else ""


def probed_ratios(ratios: Sequence[float]) -> tuple[float, ...]:
    """Gamma ratios that are looked at: the first, a middle one and the last."""
    places = np.unique(np.linspace(0, len(ratios) - 1, min(_PROBES, len(ratios))).astype(int))
    return tuple(ratios[place] for place in places)


def damped_numbers(
    study: Study, begin: Resolution, comm: MPI.Comm, tried: Callable[[int], Tried]
) -> DampedNumbers:
    """The numbers that are "auto", found with damped motions; to be called on all ranks.

    Args:
        study: Study with "auto" in it.
        begin: Numbers to begin with, and those that are given.
        comm: Communicator of the mesh.
        tried: Motions with a number of modes, or with as many as there are.

    Raises:
        StudyError: if no damped motion is found.
    """
    limits: dict[str, str] = {}
    at, change, where = tried(begin.modes), 0.0, float("nan")
    if "modes" in study.automatic:
        at, change, where = _with_modes(study, at, tried, limits)
    if at.failure:
        raise StudyError(
            f'numbers that are "auto" are found with damped motions: {at.failure}: give '
            "mode.harmonics, mode.samples and reduction.modes, or continuation.damped = false"
        )
    numbers = replace(begin, modes=at.modes)
    if "harmonics" in study.automatic:
        harmonics = on_root(comm, _harmonics, study, numbers, at)
        if harmonics > (most := _most_harmonics(study, numbers)):
            harmonics, limits["harmonics"] = most, f"the largest number tried is {most}"
        numbers = replace(numbers, harmonics=harmonics)
    expected = Accuracy(harmonics=0.0, samples=0.0, modes=change, at=where)
    energies = tuple(each.gamma_ratio for each in at.motions)
    return DampedNumbers(with_samples(study, numbers), expected, energies, limits)


def _motions(maker: DampedMaker, ratios: Sequence[float]) -> tuple[Found, ...]:
    return tuple(damped_motions(maker.damped, ratios))


def _with_modes(
    study: Study, at: Tried, tried: Callable[[int], Tried], limits: dict[str, str]
) -> tuple[Tried, float, float]:
    """Motions with enough modes, the error that is left, and where it is largest."""
    left, where = float("inf"), float("nan")
    while left > study.tolerance and "modes" not in limits:
        more = int(np.ceil(_GROWTH * at.modes))
        if more > _MOST_MODES:
            limits["modes"] = f"the largest number tried is {at.modes}"
        else:
            finer = tried(more)
            left, where = _left(at, finer)
            if finer.modes < more:
                limits["modes"] = f"the structure has {finer.modes}"
            at = finer
    return at, left, where


def _left(at: Tried, finer: Tried) -> tuple[float, float]:
    """Largest error that is left with the finer numbers, and its gamma ratio.

    Infinite where no motion is known with both.
    """
    changes = [
        (abs(one.motion.omega / other.motion.omega - 1), other.gamma_ratio)
        for one, other in zip(at.motions, finer.motions, strict=True)
        if not (one.motion.failure or other.motion.failure)
    ]
    largest, where = max(changes, default=(float("inf"), float("nan")))
    return (0.0 if at.modes == finer.modes else _LEFT * largest), where


def _most_harmonics(study: Study, numbers: Resolution) -> int:
    """Largest number of harmonics that may be tried: samples that are given bound it."""
    if "samples" in study.automatic:
        return MOST.harmonics
    return min(MOST.harmonics, (numbers.samples - 1) // study.samples_a_harmonic)


def _harmonics(study: Study, numbers: Resolution, at: Tried) -> int:
    """The fewest harmonics that all motions are verified with; more than the most if none are."""
    harmonics, most = numbers.harmonics, _most_harmonics(study, numbers)
    while harmonics <= most and not _written(study, replace(numbers, harmonics=harmonics), at):
        harmonics = int(np.ceil(_GROWTH * harmonics))
    return harmonics


def _written(study: Study, numbers: Resolution, at: Tried) -> bool:
    """Whether all motions are verified with these numbers."""
    numbers = with_samples(study, numbers)
    maker = replace(at.maker, series=FourierSeries(numbers.harmonics, numbers.samples))
    return all(
        maker.point(each.gamma_ratio, each.motion).status == VERIFIED
        for each in at.motions
        if not each.motion.failure
    )
