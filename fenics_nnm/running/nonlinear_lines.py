"""Nonlinear lines of a Campbell diagram: motions of given energy or amplitude at each speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from mpi4py import MPI

from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.point import FAILED, BranchPoint
from fenics_nnm.backbone.target_continuation import TargetContinuation
from fenics_nnm.errors import ConvergenceError, ModelError, StudyError
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.mechanics.held_mode import held_mode
from fenics_nnm.mechanics.motion import Motion
from fenics_nnm.reduction.displacement_basis import DisplacementBasis
from fenics_nnm.resolution.auto import choice
from fenics_nnm.resolution.finer import least
from fenics_nnm.running.campbell_journal import CampbellJournal, Done, key_of
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import Analyse
from fenics_nnm.structure.motions import assert_without_coriolis
from fenics_nnm.structure.motions_at_speed import (
    MotionAtSpeed,
    Quantity,
    ReachedByTargets,
    Target,
)
from fenics_nnm.structure.prepared import Prepared
from fenics_nnm.structure.structure import Linear
from fenics_nnm.study import Study
from fenics_nnm.study.error_keys import one_line
from fenics_nnm.study.resolution import Resolution


def assert_has_lines(study: Study, modes: int) -> None:
    """Refuse a study without nonlinear lines.

    Args:
        study: Study.
        modes: Number of linear modes that are followed over the speed.

    Raises:
        StudyError: if it has none.
    """
    assert_without_coriolis(study)
    if study.full_order:
        raise StudyError(
            'reduction.method = "none": nonlinear lines are those of a reduced model: must be '
            '"massless" or "craig-bampton"'
        )
    if study.mode.number > modes:
        raise StudyError(
            f"--modes {modes}: must be at least mode.number = {study.mode.number}, the mode of "
            "the nonlinear lines"
        )


@dataclass(slots=True)
class NonlinearLines:
    """Finds the motions of the followed mode of a study at its speed; called on all ranks.

    Attributes:
        targets: Energies and amplitudes.
        comm: Communicator of the mesh.
        journal: Keeps the speeds that are done.
    """

    targets: tuple[Target, ...]
    comm: MPI.Comm
    journal: CampbellJournal
    _resolution: Resolution | None = field(default=None)

    def __call__(self, study: Study, analyse: Analyse) -> tuple[MotionAtSpeed, ...]:
        """Motions at the speed of a study, one a target; those without one say why.

        Numbers for "auto" are those of the first speed that has motions.
        """
        if not self.targets:
            return ()
        found = self._resolution if study.automatic else None
        key = on_root(self.comm, key_of, study, self.targets, found)
        done = on_root(self.comm, self.journal.known.get, key)
        if done is None:
            try:
                done = motions_of(study, analyse, self.targets, self.comm, self._resolution)
            except (ConvergenceError, ModelError) as error:
                return failed_motions(self.targets, error)
            on_root(self.comm, self.journal.add, key, done)
        self._resolution = done.resolution
        return done.motions


def motions_of(
    study: Study,
    analyse: Analyse,
    targets: Sequence[Target],
    comm: MPI.Comm,
    found: Resolution | None,
) -> Done:
    """Motions of the followed mode of a study at its speed, one a target; called on all ranks.

    Args:
        study: Study at its speed, with the number of its mode there without contact.
        analyse: Finds what is linear of it.
        targets: Energies and amplitudes.
        comm: Communicator of the mesh.
        found: Numbers for "auto", if some were found before.

    Raises:
        ConvergenceError, ModelError: if its structure has no motions, or the mode is none at rest.
    """
    once = _Once(partial(analyse, reached=ReachedByTargets(tuple(targets))))
    held = _at_rest(study, once, comm, found)
    chosen = choice(held, comm, found=found, analyse=once)
    basis = chosen.linear.displacement_basis()
    moving: list[MotionAtSpeed] = []
    for quantity in Quantity:
        wanted = [each for each in targets if each.quantity is quantity]
        if wanted:
            moving += on_root(comm, _motions, chosen.prepared, basis, wanted)
    return Done(tuple(moving), chosen.study.resolution)


@dataclass(slots=True)
class _Once:
    """Finds what is linear of a study, and does not do so again for the same one.

    Attributes:
        analyse: What finds it.
    """

    analyse: Analyse
    _kept: tuple[tuple[Study, Linear], ...] = ()

    def __call__(
        self,
        study: Study,
        comm: MPI.Comm,
        stages: Stages | None = None,
        *,
        at_most: int | None = None,
    ) -> Linear:
        if at_most is not None:
            return self.analyse(study, comm, stages, at_most=at_most)
        for known, linear in self._kept:
            if known == study:
                return linear
        found = self.analyse(study, comm, stages)
        self._kept = ((study, found),)
        return found


def _at_rest(study: Study, analyse: Analyse, comm: MPI.Comm, found: Resolution | None) -> Study:
    """The study with the number that its mode has with the points held that are closed at rest.

    Raises:
        ModelError: if none of these modes has its shape.
    """
    given = study.with_resolution(found or least(study)) if study.automatic else study
    number = held_mode(analyse(given, comm).model.at_rest(), study.mode.number - 1) + 1
    return study.model_copy(update={"mode": study.mode.model_copy(update={"number": number})})


def failed_motions(targets: Sequence[Target], error: Exception) -> tuple[MotionAtSpeed, ...]:
    """What stands for the motions at a speed that has none, with the reason."""
    return tuple(MotionAtSpeed(each, FAILED, one_line(error)) for each in targets)


def _motions(
    prepared: Prepared, basis: DisplacementBasis, targets: Sequence[Target]
) -> list[MotionAtSpeed]:
    """Motions at several values of one quantity."""
    model, series = prepared.model_in_contact, prepared.balance.series

    def amplitude(motion: Motion) -> float:
        return basis.largest(model, series, motion)

    quantity = targets[0].quantity
    measure = amplitude if quantity is Quantity.AMPLITUDE else _energy
    values = tuple(sorted(each.value for each in targets))
    wanted = TargetContinuation(values, measure, quantity.value)
    branch = replace(prepared, wanted=wanted).followed(stages=Stages())
    points = {point.position: point for point in branch.points}
    return [
        _of_point(each, points[each.value], amplitude(points[each.value].motion))
        if each.value in points
        else MotionAtSpeed(each, FAILED, _missing(branch, each.value))
        for each in targets
    ]


def _energy(motion: Motion) -> float:
    return motion.energy


def _of_point(target: Target, point: BranchPoint, amplitude: float) -> MotionAtSpeed:
    """The motion of a point, whose position is the value that was asked for."""
    reason = point.reason if point.status == FAILED else ""
    numbers = {
        Quantity.ENERGY: point.motion.energy,
        Quantity.AMPLITUDE: amplitude,
        target.quantity: target.value,
    }
    return MotionAtSpeed(
        target,
        point.status,
        reason,
        energy=numbers[Quantity.ENERGY],
        amplitude=numbers[Quantity.AMPLITUDE],
        frequency=point.motion.frequency,
    )


def _missing(branch: Branch, value: float) -> str:
    return dict(branch.failures).get(value, branch.reason)
