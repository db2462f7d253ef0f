"""Numbers of a point that belong to parts it may lack: nan without them."""

from __future__ import annotations

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.time_domain.stability import STABLE
from fenics_nnm.time_domain.stability import damping_needed as damping_of

_NAN = float("nan")


def return_error(point: BranchPoint) -> float:
    """Distance of the state after one period from its start."""
    return point.returned.after_one if point.returned else _NAN


def return_error_10(point: BranchPoint) -> float:
    """Distance of the state after ten periods from its start."""
    return point.returned.after_ten if point.returned else _NAN


def energy_drift(point: BranchPoint) -> float:
    """Largest relative change of the energy in ten periods."""
    return point.returned.energy_drift if point.returned else _NAN


def shot_frequency(point: BranchPoint) -> float:
    """Frequency in Hz of the exact motion nearby."""
    return point.orbit.frequency if point.orbit else _NAN


def shot_distance(point: BranchPoint) -> float:
    """Distance of the state of the exact motion from that of the point."""
    return point.orbit.distance if point.orbit else _NAN


def shot_return_error(point: BranchPoint) -> float:
    """Return error of the exact motion."""
    return point.orbit.return_error if point.orbit else _NAN


def shot_change(point: BranchPoint) -> float:
    """Frequency of the exact motion over that of the point, less 1."""
    return shot_frequency(point) / point.motion.frequency - 1


def largest_multiplier(point: BranchPoint) -> float:
    """Largest modulus of the Floquet multipliers."""
    return point.stability.largest_multiplier if point.stability else _NAN


def stability_kind(point: BranchPoint) -> str:
    """Stable, or the kind of instability; empty if not known."""
    return point.stability.kind if point.stability else ""


def damping_needed(point: BranchPoint) -> float:
    """Damping ratio that would hold the motion, see `time_domain.stability.damping_needed`.

    None is needed where multipliers are off the unit circle by no more than round-off.
    """
    if stability_kind(point) == STABLE:
        return 0.0
    return damping_of(largest_multiplier(point))


def damping_ratio(point: BranchPoint) -> float:
    """Damping ratio of the motion with the damping of the study."""
    return point.sustained.ratio if point.sustained else _NAN


def is_damped(point: BranchPoint) -> bool:
    """Whether the motion itself has the damping of the study."""
    return point.sustained is not None and point.sustained.exact


def resonance_force(point: BranchPoint) -> float:
    """Force in N, 0-peak, that keeps the motion up in phase resonance."""
    return point.sustained.force if point.sustained else _NAN


def reduction_residual(point: BranchPoint) -> float:
    """Residual of the motion in the full-order equations."""
    return point.expected.reduction.residual if point.expected.reduction else _NAN


def reduction_error(point: BranchPoint) -> float:
    """Relative error of the frequency that is expected of the reduction."""
    return point.expected.reduction.frequency if point.expected.reduction else _NAN


def harmonics_error(point: BranchPoint) -> float:
    """Relative error of the frequency that is expected of N harmonics."""
    return point.expected.series.harmonics if point.expected.series else _NAN


def samples_error(point: BranchPoint) -> float:
    """Relative error of the frequency that is expected of m samples."""
    return point.expected.series.samples if point.expected.series else _NAN


def error_remainder(point: BranchPoint) -> float:
    """Part of the defect that the step behind the errors of the series leaves."""
    return point.expected.series.remainder if point.expected.series else _NAN
