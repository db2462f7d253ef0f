"""A converged point of a branch, in parts: what is known of it, each in physical units.

A part that is not known is None. The continuation makes a point with its motion and what harmonic
balance itself says of it; judging it (see `backbone.verdict`) makes a new point of that, with what
integration in time says.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fenics_nnm.arrays import Complex
from fenics_nnm.backbone.extremes import UNKNOWN, Extremes
from fenics_nnm.mechanics.light_damping import Sustained
from fenics_nnm.mechanics.motion import Motion
from fenics_nnm.nonlinear.reduction_error import ReductionError
from fenics_nnm.nonlinear.series_error import SeriesError

#: Names of the parameters of a branch.
GAMMA_RATIO, FREQUENCY_RATIO = "gamma_ratio", "frequency_ratio"

#: Status of a point, from the best to the worst.
VERIFIED = "verified"
CONVERGED = "converged"
RESONANT = "inside resonance"
FAILED = "failed"
STATUSES = (VERIFIED, CONVERGED, RESONANT, FAILED)

#: Number of the family of motions that is the main branch, and of points whose family is not known.
MAIN_BRANCH, NO_FAMILY = 1, 0

#: A motion up to this part above grazing, and with the frequency of the linear mode within
#: it, is the linear mode.
_LINEAR = 1e-9


@dataclass(frozen=True, slots=True)
class Balance:
    """How well a motion solves the discrete equations, and keeps to what they stand for.

    Attributes:
        residual: Relative residual of the harmonic equations.
        penetration: Largest penetration between the samples in m, the contact forces
            taken linear between them.
        tension: The contrary, force across an open gap, in m: the largest of the smaller of open
            gap and static deflection S_cc lambda_c, at all contact points c and on the same grid.
            With the penetration it is how far min(gap - w, S_cc lambda) is from zero, which it is
            where Signorini's conditions hold; S is the static flexibility.
        complementarity: Largest |lambda (w - gap)| at the samples over max lambda times the unit
            of length: the smallest gap if that is positive, else the motion at gamma ratio 1.
        virial_error: Relative error of omega^2 m^ = k^ + virial, see `nonlinear.energies`.
        energy_variation: Largest less smallest total energy at the samples, over its mean; the
            energy of a motion in time is constant.
    """

    residual: float
    penetration: float
    tension: float
    complementarity: float
    virial_error: float
    energy_variation: float


@dataclass(frozen=True, slots=True)
class ExpectedErrors:
    """Errors of the frequency that are expected of the discretisation.

    Attributes:
        reduction: Of the reduction; 0 at full order, None where nothing is known of what the
            model leaves out.
        series: Of the series in time; None where contact points carry mass, and where the finer
            equations are too large or singular.
    """

    reduction: ReductionError | None
    series: SeriesError | None


@dataclass(frozen=True, slots=True)
class ContinuationNotes:
    """What the continuation noted when it found a point.

    Attributes:
        iterations: Newton steps at the finest level.
        slope_ratio: d omega / d gamma over that of the followed mode alone; below 0.1 the
            frequency stands still while energy flows into other modes. nan below grazing, and
            where it is not defined.
        skipped: Mode and harmonic of an internal resonance that hid the main branch here, and was
            left; or nothing.
        event: What the branch does here, found by its length: "fold in gamma", "fold in omega",
            "branch point", or nothing.
        slope: d ln omega / d ln gamma of the family at this point; nan where it is not known.
        asked: Which value was asked for, such as "stress 3e+08 Pa", or nothing.
    """

    iterations: int
    slope_ratio: float
    skipped: str = ""
    event: str = ""
    slope: float = float("nan")
    asked: str = ""


@dataclass(frozen=True, slots=True)
class Return:
    """How a motion, integrated in time, comes back to where it started.

    Distances are relative in the energy norm: 1 is as far away as the amplitude.

    Attributes:
        after_one: Distance of the state after one period from its start.
        after_ten: The same after ten periods; nan if they were not followed to their end, or not
            needed: with second-order kinematics where an exact motion is known nearby. On an
            unstable motion it grows by the multipliers.
        energy_drift: Largest relative change of the energy in these periods: what the integration
            itself does wrong; nan if they were not followed to their end.
    """

    after_one: float
    after_ten: float
    energy_drift: float


@dataclass(frozen=True, slots=True)
class Orbit:
    """The periodic motion of the same energy that shooting finds near a point, exact in time.

    Attributes:
        frequency: Its frequency in Hz.
        distance: Distance of its state from that of the point, relative in the energy norm.
        return_error: Its own return error after one period.
    """

    frequency: float
    distance: float
    return_error: float


@dataclass(frozen=True, slots=True)
class FloquetStability:
    """Stability of the motion that shooting finds.

    Attributes:
        kind: "stable", or the kind of instability of the largest multiplier, see
            `time_domain.stability`.
        largest_multiplier: Largest modulus of the multipliers: 1 if it is stable.
        multipliers: Floquet multipliers besides the two that are 1, by falling modulus, shape
            (2 J - 2,).
    """

    kind: str
    largest_multiplier: float
    multipliers: Complex


@dataclass(frozen=True, slots=True)
class Verdict:
    """What may be believed of a point; see `backbone.verdict`.

    Attributes:
        status: One of `STATUSES`.
        reason: Why the point is not verified; empty if it is.
        resonance: Mode and harmonic of an internal resonance, or nothing. The point is inside it
            if its status says so; else it is on the main branch, with energy in that mode.
        confirmed: Whether integration in time confirms the motion and its frequency, of whatever
            family it is.
        family: Number of its family, see `backbone.families`: `MAIN_BRANCH`, or 2, 3 ..
    """

    status: str
    reason: str = ""
    resonance: str = ""
    confirmed: bool = False
    family: int = NO_FAMILY


#: What is said of a point that nobody judged yet. All points solve the discrete equations.
NOT_JUDGED = Verdict(CONVERGED, "the run was stopped before the motion was checked in time")


@dataclass(frozen=True, slots=True)
class BranchPoint:
    """A periodic motion of a branch, with all that is known of it.

    Attributes:
        position: Place along the branch, by which points are ordered: what is stepped, so the
            gamma ratio, the frequency ratio, or the length of the arc from the first point.
        at: Parameters of the branch by their name: `GAMMA_RATIO`, the modal energy coordinate over
            its value where the linear motion about the state of rest ends, at grazing or where a
            closed point lifts off; `FREQUENCY_RATIO`, the frequency over that of the linear mode,
            times the harmonic that it began in.
        motion: The motion itself.
        balance: How well it solves the discrete equations.
        expected: Errors that are expected of the discretisation.
        notes: What the continuation noted.
        returned: How it comes back in time; None before it is judged, where contact points carry
            mass, and where its integration gives up within the first period.
        orbit: The exact motion nearby; None if none was found, or looked for.
        stability: Stability of that motion; None if it is not known.
        verdict: What may be believed; None before the point is judged.
        sustained: What the damping of the study takes; None without damping.
        extremes: Largest displacement, stress and contact force; unknown before they are measured.
    """

    position: float
    at: Mapping[str, float]
    motion: Motion
    balance: Balance
    expected: ExpectedErrors
    notes: ContinuationNotes
    returned: Return | None = None
    orbit: Orbit | None = None
    stability: FloquetStability | None = None
    verdict: Verdict | None = None
    sustained: Sustained | None = None
    extremes: Extremes = UNKNOWN

    @property
    def gamma_ratio(self) -> float:
        """Modal energy coordinate over its value where the linear motion ends."""
        return self.at[GAMMA_RATIO]

    @property
    def frequency_ratio(self) -> float:
        """Frequency over that of the linear mode, times the harmonic that it began in."""
        return self.at[FREQUENCY_RATIO]

    @property
    def is_linear(self) -> bool:
        """Whether it is the linear mode, before its motion meets anything.

        A damped motion without contact is one of the linear structure under the force, whatever its
        frequency: damping that couples modes changes it.
        """
        damped = self.sustained is not None and self.sustained.exact
        if damped and self.motion.contact_fraction == 0:
            return True
        ends = self.gamma_ratio <= 1 + _LINEAR
        return ends and abs(self.frequency_ratio - 1) <= _LINEAR

    @property
    def family(self) -> int:
        """Number of its family of motions; 0 before there is a verdict."""
        return (self.verdict or NOT_JUDGED).family

    @property
    def rise(self) -> float:
        """`notes.slope_ratio`, and 0 where the frequency is the linear one beyond linear motions.

        There the Jacobian may be singular: motions of two linear modes that do not even touch.
        """
        still = not self.is_linear and abs(self.frequency_ratio - 1) <= _LINEAR
        return 0.0 if still else self.notes.slope_ratio

    @property
    def confirmed(self) -> bool:
        """Whether integration in time confirms the motion and its frequency."""
        return (self.verdict or NOT_JUDGED).confirmed

    @property
    def status(self) -> str:
        """Status of the verdict; "converged" before there is one."""
        return (self.verdict or NOT_JUDGED).status

    @property
    def reason(self) -> str:
        """Why the point is not verified; empty if it is."""
        return (self.verdict or NOT_JUDGED).reason

    @property
    def resonance(self) -> str:
        """Internal resonance that the motion is inside, or nothing."""
        return (self.verdict or NOT_JUDGED).resonance


def believable(points: Sequence[BranchPoint]) -> tuple[BranchPoint, ...]:
    """Points that may be shown and named alone: all but the failed ones."""
    return tuple(point for point in points if point.status != FAILED)
