"""Harmonics, samples and modes of a response that meet a tolerance: `"auto"` in a driven study.

What is asked for is the frequency of the phase resonances at the levels of the forces: the largest
motions, which need the most. They are solved again with twice as many harmonics, and with twice as
many modes, at the same level; the source of the larger change is raised until the changes add up to
less than the tolerance. Without contact the motions of a structure that is linear but for contact
are exact: their frequencies are compared as they are. Those of one with second-order kinematics, or
with springs that are not linear, are solved again like motions with contact, as their frequencies
depend on the level.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError, StudyError
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.nonlinear.newton import Newton, solve
from fenics_nnm.nonlinear.resonant import FixedLevel, ResonantEquations
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.resolution.accuracy import Accuracy
from fenics_nnm.resolution.finer import MOST, Finer, least
from fenics_nnm.response.judge import Unjudged
from fenics_nnm.response.levels import Response
from fenics_nnm.response.phase_resonance import damped_backbone
from fenics_nnm.response.point import ResponsePoint
from fenics_nnm.response.structure import DrivenStructure
from fenics_nnm.stages import Stages
from fenics_nnm.structure.driven import driven_linear, structure_from
from fenics_nnm.structure.driven_frequencies import drive_harmonics, response_frequencies
from fenics_nnm.structure.driven_linear import DrivenLinear
from fenics_nnm.study import Study
from fenics_nnm.study.resolution import Resolution

logger = logging.getLogger(__name__)

#: Resonances that are looked at: of so many levels, spread over those that are not linear.
_PROBES = 3

#: A resonance that is not found again counts as so large a change.
_LOST = 1.0

#: Where there are not so many modes, this part of them is tried.
_FEWER = 0.75

_NEAR = Newton(tolerance=1e-12, round_off=1e-10, iterations=40)


@dataclass(frozen=True, slots=True)
class DrivenChoice:
    """A driven study with all its numbers.

    Attributes:
        study: The study with all its numbers.
        linear: All that is linear of it.
        structure: The driven structure.
        tolerance: Relative error of the resonances that was asked for.
        expected: Their expected errors; None if no number was looked for.
        probes: Number of resonances, with contact or else not linear, that these are of.
        touching: Whether these have contact.
        limits: Why numbers were not raised any more, by the source of the error.
    """

    study: Study
    linear: DrivenLinear
    structure: DrivenStructure
    tolerance: float = float("nan")
    expected: Accuracy | None = None
    probes: int = 0
    touching: bool = False
    limits: Mapping[str, str] = field(default_factory=dict)

    def line(self, found: Response) -> str:
        """The numbers, and whether the tolerance is met by a response; nothing if all were given.

        It is not where a motion has failed or a curve ends, whatever is expected.
        """
        if self.expected is None:
            return ""
        error = self.expected
        numbers = f"{self.study.resolution}: expected error of the resonances {error.total:.1e}"
        modes = f"{error.modes:.1e}" if error.modes else "all that there are, or given"
        parts = f"harmonics {error.harmonics:.1e}, modes {modes}"
        return f"{numbers} ({parts}): the {self._verdict(found)}"

    def _verdict(self, found: Response) -> str:
        assert self.expected is not None
        asked = f"tolerance {self.tolerance:g}"
        lost = len(found.missing) + len(found.refuted)
        if lost or found.reasons:
            what = f"{lost} of {len(found.points)} motions failed" if lost else "a curve ends"
            return f"{asked} is not met: {what}"
        if self.expected.meets(self.tolerance):
            return f"{asked} is met at {self._where}"
        limits = "; ".join(f"{name}: {reason}" for name, reason in self.limits.items())
        return f"{asked} is not met: {limits or 'finer numbers were not found'}"

    @property
    def _where(self) -> str:
        if not self.probes:
            return "the linear resonances: none at these levels has contact"
        if not self.touching:
            return f"{self.probes} of the resonances: none at these levels has contact"
        return f"{self.probes} of the resonances with contact"


def driven_choice(
    study: Study, comm: MPI.Comm, stages: Stages, *, found: Resolution | None = None
) -> DrivenChoice:
    """Find the numbers of a driven study that are "auto"; to be called on all ranks.

    Args:
        study: Study, with or without numbers to be found.
        comm: Communicator of the mesh.
        stages: Timings and progress.
        found: Numbers that an earlier response of the study found.

    Raises:
        StudyError: if it has no phase resonances to look at.
        NonlinearModeError: as `driven_linear`.
    """
    if not study.automatic or found:
        given = study.with_resolution(found) if found else study
        linear = driven_linear(given, comm, stages)
        return DrivenChoice(given, linear, structure_from(given, linear.basis))
    models, finer = _Models(study, comm, stages), Finer(study)
    tried: list[DrivenChoice] = []
    wanted: Resolution | None = _first(study)
    while wanted is not None:
        tried.append(_tried(models, finer, wanted))
        last = tried[-1]
        assert last.expected is not None  # it was looked for
        logger.info("%s: expected error %.1e", last.study.resolution, last.expected.total)
        wanted = finer.raised(last.study.resolution, last.expected)
    return tried[-1] if _total(tried[-1]) <= study.tolerance else min(tried, key=_total)


def _first(study: Study) -> Resolution:
    """Numbers to begin with, which have all harmonics of the forces."""
    at, highest = least(study), max(drive_harmonics(study), default=0)
    if "harmonics" not in study.automatic or highest <= at.harmonics:
        return at
    return replace(at, harmonics=highest, samples=max(at.samples, 8 * highest))


def _total(choice: DrivenChoice) -> float:
    assert choice.expected is not None  # it was looked for
    return choice.expected.total


def _tried(models: _Models, finer: Finer, at: Resolution) -> DrivenChoice:
    """Numbers with the errors that are expected of them."""
    at = replace(at, modes=models.most(at.modes))
    study = models.study.with_resolution(at)
    linear, structure = models.of(at.modes)
    wanted = models.study.reduction.modes == "auto"  # those that cannot be raised have an error too
    more = models.more(at.modes) if wanted else None
    if wanted and more is None:
        finer.has_all_modes(at.modes)
        finer.limits["modes"] = f"no more than {at.modes} leave contact points that can move"
    with models.stages.stage("accuracy"):
        looked_at, expected = on_root(models.comm, _expected, study, structure, more, at)
    return DrivenChoice(
        study, linear, structure, study.tolerance, expected, *looked_at, finer.limits
    )


@dataclass(slots=True)
class _Models:
    """Driven structures with different numbers of modes.

    Attributes:
        study: Study.
        comm: Communicator of the mesh.
        stages: Timings and progress.
    """

    study: Study
    comm: MPI.Comm
    stages: Stages
    _kept: dict[int, tuple[DrivenLinear, DrivenStructure]] = field(default_factory=dict)

    def of(self, modes: int) -> tuple[DrivenLinear, DrivenStructure]:
        """That with so many modes."""
        if modes not in self._kept:
            study = self.study.with_resolution(Resolution(MOST.harmonics, MOST.samples, modes))
            linear = driven_linear(study, self.comm, self.stages)
            self._kept[modes] = linear, structure_from(study, linear.basis)
        return self._kept[modes]

    def most(self, modes: int) -> int:
        """So many modes, or fewer that are there and leave the contact points flexibility."""
        while modes > 1 and self.study.reduction.modes == "auto" and not self._has(modes):
            modes = max(1, int(_FEWER * modes))
        return modes

    def more(self, modes: int) -> DrivenStructure | None:
        """That with up to twice as many; None where there are no more."""
        found = self.most(2 * modes)
        return self.of(found)[1] if found > modes else None

    def _has(self, modes: int) -> bool:
        try:
            return not self.of(modes)[1].objection
        except (ModelError, StudyError):  # fewer than that are there
            return False


@dataclass(frozen=True, slots=True)
class _Probe:
    """A phase resonance.

    Attributes:
        level: Level of the forces.
        omega: Circular frequency in rad/s.
        q: Coefficients, shape (c, J).
    """

    level: float
    omega: float
    q: Array


def _expected(
    study: Study, structure: DrivenStructure, more: DrivenStructure | None, at: Resolution
) -> tuple[tuple[int, bool], Accuracy]:
    """Which resonances were looked at, see `DrivenChoice`, and changes of their frequencies.

    Raises:
        StudyError: if there are no phase resonances.
    """
    series = FourierSeries(at.harmonics, at.samples)
    points = _resonances(study, structure, series)
    touching = [p for p in points if p.displacements.contact.max(initial=0.0) > 0]
    opened = np.unique([p.frequency for p in points if not p.displacements.contact.any()])
    probes = _spread(points if structure.forces and not touching else touching)
    twice = FourierSeries(2 * at.harmonics, max(at.samples, 16 * at.harmonics))
    by_harmonics = [_change(study, structure, twice, probe, probe.q) for probe in probes]
    by_modes = [0.0]
    if more is not None:
        by_modes = [
            _change(study, more, series, probe, _in_more(structure, more, probe.q))
            for probe in probes
        ]
        if not structure.forces:
            by_modes += _linear_changes(study, more, series, opened)
    errors: dict[str, Any] = {"harmonics": max(by_harmonics, default=0.0), "modes": max(by_modes)}
    accuracy = Accuracy(samples=0.0, at=float("nan"), **errors)
    return (len(probes), bool(touching)), accuracy


def _resonances(
    study: Study, structure: DrivenStructure, series: FourierSeries
) -> list[ResponsePoint]:
    """Resonances at the wanted levels.

    Raises:
        StudyError: if there are no phase resonances.
    """
    assert study.response is not None  # refused before
    levels = study.response.levels
    found = damped_backbone(
        structure, series, response_frequencies(study), levels, judge=Unjudged()
    )
    if not found.points:
        raise StudyError(
            f'numbers that are "auto" are found at phase resonances: {found.reasons[0]}: give '
            "mode.harmonics, mode.samples and reduction.modes"
        )
    return [each.point for each in found.points if each.point.level in levels]


def _spread(points: Sequence[ResponsePoint]) -> list[_Probe]:
    """A few of the points, from the first to the last."""
    places = np.unique(np.linspace(0, len(points) - 1, min(_PROBES, len(points))).astype(int))
    chosen = [points[place] for place in places] if points else []
    return [_Probe(p.level, p.omega, p.q) for p in chosen]


def _change(
    study: Study, structure: DrivenStructure, series: FourierSeries, probe: _Probe, q: Array
) -> float:
    """Relative change of a resonance's frequency at its level with finer numbers.

    Args:
        study: Study.
        structure: Structure with the finer numbers.
        series: Series with the finer numbers.
        probe: Resonance.
        q: Its coefficients in the modes of this structure.
    """
    equations = ResonantEquations.of(structure.mechanics, series)
    near, push = series.fitted(q), equations.push
    near -= push * np.sum(push * near) / np.sum(push * push)
    guess = Unknowns.of(near, probe.omega, probe.level)
    found = solve(equations, FixedLevel(probe.level), guess, options=_NEAR)
    if found.converged:
        return abs(found.omega / probe.omega - 1)
    again = damped_backbone(
        structure, series, response_frequencies(study), (probe.level,), judge=Unjudged()
    )
    at_level = [each.point.omega for each in again.points if each.point.level == probe.level]
    return min((abs(omega / probe.omega - 1) for omega in at_level), default=_LOST)


def _in_more(structure: DrivenStructure, more: DrivenStructure, q: Array) -> Array:
    """Coefficients in the modes of a structure with more of them, shape (c, J').

    Shapes that were added for forces at points lie above the free modes in both; of their part in
    the motion the guess knows nothing.
    """
    wide = np.zeros((len(q), len(more.model.omega)))
    known = min(q.shape[1], wide.shape[1])
    close = np.isclose(structure.model.omega[:known], more.model.omega[:known], rtol=1e-6)
    same = int(np.argmin(close)) if not close.all() else known
    before = np.vstack([structure.model.Phi, structure.watched.shapes])[:, :same]
    now = np.vstack([more.model.Phi, more.watched.shapes])[:, :same]
    signs = np.where(np.einsum("ij,ij->j", before, now) < 0, -1.0, 1.0)
    wide[:, :same] = signs * q[:, :same]
    return wide


def _linear_changes(
    study: Study, more: DrivenStructure, series: FourierSeries, frequencies: Sequence[float] | Array
) -> list[float]:
    """Relative changes of the resonances without contact with more modes."""
    if not len(frequencies):
        return []
    again = damped_backbone(
        more, series, response_frequencies(study), (1e-9,), judge=Unjudged()
    ).points
    near = np.array([each.point.frequency for each in again])
    if not near.size:
        return [_LOST]
    return [float(np.abs(near / frequency - 1).min()) for frequency in frequencies]
