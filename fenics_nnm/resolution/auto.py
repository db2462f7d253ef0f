"""Harmonics, samples and modes that meet a tolerance: `"auto"` in a study.

A few energies spread over the range are solved, and the source of the largest expected error is
raised, until the expected errors add up to less than the tolerance. When the branch is there its
points are asked again, and it is followed once more with finer numbers where they disagree.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from mpi4py import MPI

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.errors import TooManyModesError
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.nonlinear.series_error import MORE_HARMONICS
from fenics_nnm.resolution.accuracy import SOURCES, Accuracy, accuracy
from fenics_nnm.resolution.damped_auto import Tried, damped_numbers, probed_ratios
from fenics_nnm.resolution.finer import MOST, Finer, least
from fenics_nnm.resolution.probes import probed, probes
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import Analyse, Linear, linear_analysis
from fenics_nnm.structure.damped_choice import damped_run
from fenics_nnm.structure.damped_run import UNDAMPED, DampedRun
from fenics_nnm.structure.prepared import Prepared, prepared
from fenics_nnm.study import Study
from fenics_nnm.study.resolution import Resolution

logger = logging.getLogger(__name__)

#: A branch is followed at most so many times.
_ROUNDS = 3

#: Fewest modes computed at once, as a few more cost little.
_MODES_AT_ONCE = 40

#: Where modes leave nothing to the contact points, this part of them is tried.
_FEWER = 0.75

#: The error of the samples at a probe may be larger by this factor beside it.
_BETWEEN = 2.0


@dataclass(frozen=True, slots=True)
class Choice:
    """A study with all its numbers, and what they are expected to achieve.

    Attributes:
        asked: The study as it was given.
        prepared: The study with numbers in the place of "auto", ready to be followed.
        expected: Errors at the energies that were solved to find the numbers; None if none were.
        finer: The search for finer numbers, and why some were not raised; None if none was made.
        energies: Gamma ratios of the probes.
        round: How many branches have been followed with numbers found before.
    """

    asked: Study
    prepared: Prepared
    expected: Accuracy | None = None
    finer: Finer | None = None
    energies: tuple[float, ...] = ()
    round: int = 0

    @property
    def study(self) -> Study:
        """The study with all its numbers."""
        return self.prepared.study

    @property
    def linear(self) -> Linear:
        """All that is linear of it."""
        return self.prepared.linear

    @property
    def automatic(self) -> bool:
        """Whether a number was found."""
        return bool(self.asked.automatic)

    @property
    def limits(self) -> dict[str, str]:
        """Why numbers were not raised any more, by the source of the error."""
        return dict(self.finer.limits) if self.finer else {}

    def achieved(self, points: Sequence[BranchPoint]) -> Accuracy | None:
        """Expected errors of a branch; those of the probes where its points do not give them.

        None where contact points carry mass and the numbers were taken over from another run.
        """
        known = any(point.expected.series for point in points)
        return accuracy(points) if known else self.expected


def choice(
    study: Study,
    comm: MPI.Comm,
    stages: Stages | None = None,
    *,
    found: Resolution | None = None,
    analyse: Analyse | None = None,
) -> Choice:
    """Find the numbers of a study that are "auto", and all that is linear of it.

    Args:
        study: Study, with or without numbers to be found.
        comm: Communicator of the mesh.
        stages: Timings and progress.
        found: Numbers that an earlier run of the study found.
        analyse: Finds what is linear of a study, in place of `linear_analysis`.

    Raises:
        NonlinearModeError: as `linear_analysis`.
    """
    stages, analyse = stages or Stages(), analyse or linear_analysis
    if not study.automatic:
        return Choice(study, prepared(study, analyse(study, comm, stages)))
    if found:
        given = study.with_resolution(found)
        return Choice(study, prepared(given, analyse(given, comm, stages)))
    models = _Models(study, comm, stages, analyse)
    begin = least(study)
    damped = _damped_run(models, begin)
    if damped.follows:
        return _damped_choice(models, begin, probed_ratios(damped.ratios))
    return _search(models, Finer(study), begin, ())


def _damped_run(models: _Models, begin: Resolution) -> DampedRun:
    """What the damping of a study does; with the numbers that a search begins with."""
    study = models.study
    if not study.damped or study.carries_mass or study.full_order:
        return UNDAMPED
    _, linear = models.first(begin)
    return damped_run(models.study.with_resolution(begin), linear)


def _damped_choice(models: _Models, begin: Resolution, ratios: Sequence[float]) -> Choice:
    """Numbers of damped motions, which give no errors of undamped ones."""

    def tried(modes: int) -> Tried:
        at, linear = models.first(replace(begin, modes=modes))
        run = damped_run(models.study.with_resolution(at), linear)
        assert run.maker is not None  # more modes make no objection
        with models.stages.stage("accuracy"):
            found = Tried.of(models.comm, at.modes, run.maker, ratios)
        frequencies = ", ".join(each.told for each in found.motions)
        logger.info("modes = %d: damped motions of %s", at.modes, frequencies)
        return found

    found = damped_numbers(models.study, begin, models.comm, tried)
    _, linear = models.first(found.resolution)
    ready = prepared(models.study.with_resolution(found.resolution), linear)
    finer = Finer(models.study, free=[], limits=found.limits)
    return Choice(models.study, ready, found.expected, finer, found.energies)


def provisional(
    study: Study,
    comm: MPI.Comm,
    stages: Stages | None = None,
    analyse: Analyse | None = None,
) -> Choice:
    """A study with the numbers that a search begins with, to look at before they are found.

    Arguments and errors are those of `choice`.
    """
    stages, analyse = stages or Stages(), analyse or linear_analysis
    if not study.automatic:
        return choice(study, comm, stages, analyse=analyse)
    at, linear = _Models(study, comm, stages, analyse).of(least(study))
    return Choice(study, prepared(study.with_resolution(at), linear))


def improved(
    chosen: Choice,
    points: Sequence[BranchPoint],
    comm: MPI.Comm,
    stages: Stages,
    *,
    analyse: Analyse | None = None,
) -> Choice | None:
    """Finer numbers where a branch is less accurate than was expected; None where it is as wanted.

    Args:
        chosen: Numbers that the branch was followed with.
        points: Its points, the same on all ranks.
        comm: Communicator of the mesh.
        stages: Timings and progress.
        analyse: Finds what is linear of a study, in place of `linear_analysis`.
    """
    if not chosen.automatic or not points or chosen.round + 1 >= _ROUNDS:
        return None
    finer = chosen.finer or Finer(chosen.asked)
    if chosen.study.carries_mass:
        return None  # points with mass do not give their errors
    worst = accuracy(points, finer.free)
    if worst.only(finer.free).meets(chosen.study.tolerance):
        return None
    models = _Models(chosen.asked, comm, stages, analyse or linear_analysis)
    raised = finer.raised(chosen.study.resolution, worst)
    if raised is None:
        return None
    logger.info("expected error %.1e: once more with %s", worst.total, raised)
    energies = chosen.energies if np.isnan(worst.at) else (*chosen.energies, worst.at)
    found = _search(models, finer, raised, energies)
    if found.study.resolution == chosen.study.resolution:
        return None
    return replace(found, round=chosen.round + 1)


def _search(
    models: _Models, finer: Finer, begin: Resolution, energies: tuple[float, ...]
) -> Choice:
    """Raise numbers until the errors at the probes meet the tolerance, or take the best ones."""
    tried: list[Choice] = []
    at: Resolution | None = begin
    while at is not None:
        asked = at.modes
        at, linear = models.of(at)
        if at.modes < asked:
            finer.has_all_modes(at.modes)
        ready = prepared(models.study.with_resolution(at), linear)
        tried.append(_tried(models, finer, ready, energies))
        at = finer.raised(at, _expected(tried[-1]))
    if _expected(tried[-1]).only(finer.free).meets(models.study.tolerance):
        return tried[-1]
    return min(tried, key=lambda one: _expected(one).total / _expected(one).allowance)


def _tried(models: _Models, finer: Finer, ready: Prepared, energies: tuple[float, ...]) -> Choice:
    """Numbers with their errors at the probes."""
    wanted = tuple(sorted({*probes(ready), *energies}))
    with models.stages.stage("accuracy"):
        points = on_root(models.comm, probed, ready, wanted)
    found = accuracy(points, finer.free, samples_factor=_BETWEEN)
    errors = ", ".join(f"{name} {found.of(name):.1e}" for name in SOURCES)
    logger.info("%s: expected errors %s", ready.study.resolution, errors)
    return Choice(models.study, ready, found, finer, wanted)


def _expected(choice: Choice) -> Accuracy:
    assert choice.expected is not None
    return choice.expected


@dataclass(slots=True)
class _Models:
    """Linear analyses with different numbers of modes; the largest one is kept.

    A massless-boundary model of fewer modes is part of one with more.
    """

    study: Study
    comm: MPI.Comm
    stages: Stages
    analyse: Analyse
    _kept: Linear | None = None
    _all: bool = False

    def of(self, at: Resolution) -> tuple[Resolution, Linear]:
        """Numbers with the modes that they need and there are, and the analysis with these.

        Modes that a harmonic can meet are no part of a static flexibility, so the model holds all
        below harmonic 2 N of the linear mode, the last one that the estimates look at, as far as
        the largest number tried allows.
        """
        if self.study.reduction.modes != "auto":
            self._kept = self._kept or self.analyse(self.study, self.comm, self.stages)
            return at, self._kept
        if self.study.reduction.method == "craig-bampton":
            analysis = self._analysis(at.modes)
            return replace(at, modes=len(analysis.modes.omega)), analysis
        largest = self._with(at.modes)
        while (count := self._needed(at, largest)) > len(largest.modes.omega) and not self._all:
            largest = self._with(count)
        count = min(count, len(largest.modes.omega))
        return replace(at, modes=count), _first(largest, count)

    def first(self, at: Resolution) -> tuple[Resolution, Linear]:
        """Numbers with the lowest modes alone, whatever their harmonics, and their analysis."""
        if self.study.reduction.modes != "auto":
            self._kept = self._kept or self.analyse(self.study, self.comm, self.stages)
            return at, self._kept
        largest = self._with(at.modes)
        count = min(at.modes, len(largest.modes.omega))
        return replace(at, modes=count), _first(largest, count)

    def _needed(self, at: Resolution, largest: Linear) -> int:
        omega = largest.modes.omega
        highest = MORE_HARMONICS * at.harmonics * omega[self.study.mode.number - 1]
        below = int(np.searchsorted(omega, highest))
        return max(at.modes, min(below, MOST.modes))

    def _with(self, count: int) -> Linear:
        """An analysis of so many modes or more, or of all there are."""
        if self._kept is None or (len(self._kept.modes.omega) < count and not self._all):
            asked = max(_MODES_AT_ONCE, 2 * count if self._kept else count)
            self._kept = self._analysis(asked)
            self._all = len(self._kept.modes.omega) < asked
        return self._kept

    def _analysis(self, count: int) -> Linear:
        """An analysis of so many modes, or of as many as leave something to the contact points."""
        while True:
            try:
                return self.analyse(self.study, self.comm, self.stages, at_most=count)
            except TooManyModesError:
                if count <= self.study.mode.number:
                    raise
                count = max(self.study.mode.number, int(_FEWER * count))


def _first(linear: Linear, count: int) -> Linear:
    """The analysis with the lowest modes alone."""
    return linear.reduced_to(linear.modes.first(count), linear.reduction.first_modes(count))
