"""A branch of damped motions, with a verdict on each point.

Its motions are exact in time and belong to the reduced model and its damping alone: the numbers of
harmonics and samples say how finely they are written down for pictures and files, and nothing of
the frequency. A point is verified if the motion as it is written, followed in time under its force,
comes back within 5 % after a period; else it is converged: its frequency, force and stability are
those of the exact motion all the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.damped_joins import damped_joins
from fenics_nnm.backbone.damped_model import DampedModel
from fenics_nnm.backbone.damped_motions import damped_motions
from fenics_nnm.backbone.families import families
from fenics_nnm.backbone.periodicity import followed
from fenics_nnm.backbone.point import (
    CONVERGED,
    FAILED,
    FREQUENCY_RATIO,
    GAMMA_RATIO,
    MAIN_BRANCH,
    VERIFIED,
    BranchPoint,
    FloquetStability,
    Orbit,
    Verdict,
)
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.verdict import VERIFIED_RETURN_ERROR, doubted
from fenics_nnm.backbone.wanted import SILENT, Progress
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.light_damping import Sustained
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import Scales
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.solution import evaluated
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.time_domain.damped_flow import DampedFlow
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.driven_motion import instability_of
from fenics_nnm.time_domain.resonant_motion import ResonantMotion, driven_by_push
from fenics_nnm.time_domain.stability import STABLE
from fenics_nnm.time_domain.virial import virial_error

#: No exact motion has a larger error of the virial identity.
_LARGEST_VIRIAL_ERROR = 1e-6

#: Positions that differ by less than this part are the same.
_SAME = 1e-9

#: Motions are in SI units already.
_SI = Scales(omega=1.0, amplitude=1.0, length=1.0)


@dataclass(frozen=True, slots=True)
class DampedMaker:
    """Turns exact damped motions into points.

    Attributes:
        damped: Model with its damping and force.
        size: Size of the force of level 1 in N, nan where it is modal.
        series: General series that motions are written in.
    """

    damped: DampedModel
    size: float
    series: FourierSeries
    flow: DampedFlow = field(init=False, repr=False, compare=False)
    maker: PointMaker = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        model = self.damped.model
        law = Complementarity(model.R, model.gap)
        equations = HarmonicEquations(Mechanics.of(model), self.series, law)
        maker = PointMaker(equations, _SI, lambda found: None, lambda found: None)
        flow = driven_by_push(model, self.damped.rate, self.damped.push)
        object.__setattr__(self, "maker", maker)
        object.__setattr__(self, "flow", flow)

    def point(self, ratio: float, motion: ResonantMotion) -> BranchPoint:
        """The point of a motion at a gamma ratio, with its verdict."""
        flow = self._under(motion)
        written, error = self._written(flow, ratio, motion)
        found = followed(flow, self.series, written.motion)
        distance = self._distance(written, motion)
        point = replace(
            written,
            returned=found.returned,
            orbit=Orbit(written.motion.frequency, distance, motion.return_error),
            stability=_stability(motion),
            sustained=Sustained(motion.damping_ratio, self.size * motion.level, exact=True),
        )
        return replace(point, verdict=self._verdict(point, error))

    def _under(self, motion: ResonantMotion) -> DampedFlow:
        """The flow under the force that keeps a motion up."""
        drive = self.flow.drive
        amplitude = motion.level * drive.amplitude
        return self.flow.driven_by(Drive(motion.omega, drive.order, amplitude))

    def _written(
        self, flow: DampedFlow, ratio: float, motion: ResonantMotion
    ) -> tuple[BranchPoint, float]:
        """The motion as a point without a verdict, and its error of the virial identity."""
        period = 2 * np.pi / motion.omega
        course = flow.run(motion.q, motion.velocity, period, times=self.series.phase / motion.omega)
        q = np.asarray(self.series.analysis @ course.q_at)
        unknowns = Unknowns.of(q, motion.omega, 0.0)
        solution = replace(
            evaluated(self.maker.equations, unknowns),
            residual=motion.return_error,
            iterations=motion.iterations,
        )
        point = self.maker.point(ratio, ratio, solution)
        error = virial_error(flow, motion.q, motion.velocity)
        own = float(self.damped.model.omega[self.damped.mode])
        return replace(
            point,
            at={GAMMA_RATIO: ratio, FREQUENCY_RATIO: motion.omega / own},
            motion=replace(point.motion, contact_fraction=motion.contact_fraction),
            balance=replace(point.balance, virial_error=error),
            notes=replace(point.notes, slope=motion.slope),
        ), error

    def _distance(self, point: BranchPoint, motion: ResonantMotion) -> float:
        """Distance of the state as it is written from the exact one, relative in its norm."""
        at, omega = np.zeros(1), self.damped.model.omega
        exact = np.concatenate([omega * motion.q, motion.velocity])
        q = self.series.basis_at(at)[0] @ point.motion.q
        velocity = motion.omega * self.series.rate_at(at)[0] @ point.motion.q
        missed = np.concatenate([omega * q, velocity]) - exact
        return float(np.linalg.norm(missed) / np.linalg.norm(exact))

    def _verdict(self, point: BranchPoint, error: float) -> Verdict:
        """What may be believed of a point."""
        if not error <= _LARGEST_VIRIAL_ERROR:
            return Verdict(FAILED, f"the virial identity is off by {error:.1e}", family=MAIN_BRANCH)
        missed = point.returned.after_one if point.returned else float("inf")
        if not missed <= VERIFIED_RETURN_ERROR:
            reason = (
                f"its {self.series.harmonics} harmonics leave out part of the exact damped motion, "
                f"whose frequency and force these are: written in them it misses its start by "
                f"{missed:.1%} after a period; more harmonics cost little here"
            )
            return Verdict(CONVERGED, reason, confirmed=True, family=MAIN_BRANCH)
        return Verdict(VERIFIED, confirmed=True, family=MAIN_BRANCH)


def damped_branch(
    maker: DampedMaker,
    ratios: tuple[float, ...],
    *,
    doubt: str = "",
    progress: Progress = SILENT,
) -> Branch:
    """The branch of damped motions at gamma ratios.

    Args:
        maker: Makes its points.
        ratios: Gamma ratios, ascending.
        doubt: Why no motion can be verified, or nothing.
        progress: Points found before, and what hears of new ones.
    """
    points, failures = list(progress.known), []
    left = tuple(ratio for ratio in ratios if not _known(points, ratio))
    for found in damped_motions(maker.damped, left) if left else ():
        if found.motion.failure:
            failures.append((found.gamma_ratio, found.motion.failure))
        else:
            (point,) = doubted((maker.point(found.gamma_ratio, found.motion),), doubt)
            points.append(point)
            progress.on_point(point)
        progress.on_position(found.gamma_ratio)
    points.sort(key=lambda point: point.position)
    return _ended(points, tuple(failures), ratios[-1], maker)


def _known(points: list[BranchPoint], ratio: float) -> bool:
    return any(abs(point.position / ratio - 1) < _SAME for point in points)


def _ended(
    points: list[BranchPoint],
    failures: tuple[tuple[float, str], ...],
    last: float,
    maker: DampedMaker,
) -> Branch:
    """The branch with the families of its points, the jumps between them, and why it ended."""
    reason = f"reached gamma_ratio = {last:g}: damped motions"
    if failures:
        ratio, why = failures[0]
        reason = (
            f"{len(failures)} of {len(failures) + len(points)} damped motions were not found, the "
            f"first at gamma ratio {ratio:g}: {why}"
        )
    of = families(points, maker.series)
    joined: frozenset[int] = frozenset()
    while more := damped_joins(maker.damped, maker.series, points, of.numbers) - joined:
        joined |= more
        of = families(points, maker.series, joined=joined)
    numbered = zip(points, of.numbers, strict=True)
    return Branch(
        tuple(_of_family(point, number) for point, number in numbered),
        failures,
        reason,
        jumps=of.jumps,
    )


def _of_family(point: BranchPoint, number: int) -> BranchPoint:
    assert point.verdict is not None
    return replace(point, verdict=replace(point.verdict, family=number))


def _stability(motion: ResonantMotion) -> FloquetStability:
    """Stability under the force, with the damping of the study."""
    multipliers = motion.multipliers
    kind = instability_of(multipliers) or STABLE
    largest: Array = np.abs(multipliers[:1])
    return FloquetStability(kind, float(largest[0]), multipliers)
