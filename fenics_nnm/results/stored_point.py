"""A point of a branch as named numbers and arrays, as branch.h5 and the journal have it.

The names are those of the file format: they stay as they are when the program names things anew.
What is not known is stored as nan, as an empty text, or as an empty array.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.backbone import point_numbers as numbers
from fenics_nnm.backbone.extremes import packed, unpacked
from fenics_nnm.backbone.point import (
    FREQUENCY_RATIO,
    GAMMA_RATIO,
    NO_FAMILY,
    NOT_JUDGED,
    VERIFIED,
    Balance,
    BranchPoint,
    ContinuationNotes,
    ExpectedErrors,
    FloquetStability,
    Orbit,
    Return,
    Verdict,
)
from fenics_nnm.mechanics.light_damping import Sustained
from fenics_nnm.mechanics.motion import Motion
from fenics_nnm.nonlinear.reduction_error import ReductionError
from fenics_nnm.nonlinear.series_error import SeriesError

_NO_MULTIPLIERS: Complex = np.empty(0, dtype=complex)

#: Numbers and texts of a point by their stored name, in the order that they are stored in.
SCALARS: dict[str, Callable[[BranchPoint], float | int | str]] = {
    "position": lambda point: point.position,
    "gamma_ratio": lambda point: point.gamma_ratio,
    "frequency": lambda point: point.motion.frequency,
    "frequency_ratio": lambda point: point.frequency_ratio,
    "rayleigh_frequency": lambda point: point.motion.rayleigh_frequency,
    "energy": lambda point: point.motion.energy,
    "residual": lambda point: point.balance.residual,
    "penetration": lambda point: point.balance.penetration,
    "tension": lambda point: point.balance.tension,
    "complementarity": lambda point: point.balance.complementarity,
    "reduction_residual": numbers.reduction_residual,
    "reduction_error": numbers.reduction_error,
    "virial_error": lambda point: point.balance.virial_error,
    "energy_variation": lambda point: point.balance.energy_variation,
    "contact_fraction": lambda point: point.motion.contact_fraction,
    "iterations": lambda point: point.notes.iterations,
    "status": lambda point: point.status,
    "reason": lambda point: point.reason,
    "resonance": lambda point: point.resonance,
    "skipped": lambda point: point.notes.skipped,
    "event": lambda point: point.notes.event,
    "slope_ratio": lambda point: point.notes.slope_ratio,
    "return_error": numbers.return_error,
    "return_error_10": numbers.return_error_10,
    "energy_drift": numbers.energy_drift,
    "shot_frequency": numbers.shot_frequency,
    "shot_distance": numbers.shot_distance,
    "shot_return_error": numbers.shot_return_error,
    "largest_multiplier": numbers.largest_multiplier,
    "stability": numbers.stability_kind,
    "harmonics_error": numbers.harmonics_error,
    "samples_error": numbers.samples_error,
    "error_remainder": numbers.error_remainder,
    "slope": lambda point: point.notes.slope,
    "family": lambda point: point.family,
    "confirmed": lambda point: point.confirmed,
    "damping_ratio": numbers.damping_ratio,
    "resonance_force": numbers.resonance_force,
    "damped": numbers.is_damped,
    "asked": lambda point: point.notes.asked,
}

#: Those that files of earlier versions lack, and what is known of their points.
ADDED: dict[str, float | int | str] = {
    "slope": float("nan"),
    "family": NO_FAMILY,
    "damping_ratio": float("nan"),
    "resonance_force": float("nan"),
    "damped": False,
    "asked": "",
}

#: Arrays of a point by their stored name.
ARRAYS: dict[str, Callable[[BranchPoint], Array | Complex]] = {
    "q": lambda point: point.motion.q,
    "force": lambda point: point.motion.force,
    "free": lambda point: point.motion.free,
    "multipliers": lambda point: (
        point.stability.multipliers if point.stability else _NO_MULTIPLIERS
    ),
    "extremes": lambda point: packed(point.extremes)["extremes"],
    "extreme_numbers": lambda point: packed(point.extremes)["extreme_numbers"],
    "extreme_patches": lambda point: packed(point.extremes)["extreme_patches"],
}

#: Arrays that files of earlier versions lack, of points that were not measured.
ADDED_ARRAYS: dict[str, Array] = {
    "extremes": np.empty((0, 5)),
    "extreme_numbers": np.empty(0),
    "extreme_patches": np.empty((0, 3)),
}


def scalars_of(point: BranchPoint) -> dict[str, float | int | str]:
    """Numbers and texts of a point by their stored name."""
    return {name: value(point) for name, value in SCALARS.items()}


def arrays_of(point: BranchPoint) -> dict[str, Array | Complex]:
    """Arrays of a point by their stored name."""
    return {name: value(point) for name, value in ARRAYS.items()}


def point_from(scalars: Mapping[str, Any], arrays: Mapping[str, Any]) -> BranchPoint:
    """The point of stored numbers and arrays; a part that nothing is known of is None.

    Raises:
        KeyError: if one of them is missing that all versions have.
    """
    verified = scalars["status"] == VERIFIED
    scalars = {**ADDED, "confirmed": verified, **scalars}
    arrays = {**ADDED_ARRAYS, **arrays}
    return BranchPoint(
        position=scalars["position"],
        at={name: scalars[name] for name in (GAMMA_RATIO, FREQUENCY_RATIO)},
        motion=_motion(scalars, arrays),
        balance=_balance(scalars),
        expected=ExpectedErrors(_reduction(scalars), _series(scalars)),
        notes=_notes(scalars),
        returned=_returned(scalars),
        orbit=_orbit(scalars),
        stability=_stability(scalars, arrays),
        verdict=_verdict(scalars),
        sustained=_sustained(scalars),
        extremes=unpacked(*(arrays[name] for name in ADDED_ARRAYS)),
    )


def _motion(stored: Mapping[str, Any], arrays: Mapping[str, Any]) -> Motion:
    return Motion(
        q=arrays["q"],
        force=arrays["force"],
        free=arrays["free"],
        frequency=stored["frequency"],
        rayleigh_frequency=stored["rayleigh_frequency"],
        energy=stored["energy"],
        contact_fraction=stored["contact_fraction"],
    )


def _balance(stored: Mapping[str, Any]) -> Balance:
    return Balance(
        residual=stored["residual"],
        penetration=stored["penetration"],
        tension=stored["tension"],
        complementarity=stored["complementarity"],
        virial_error=stored["virial_error"],
        energy_variation=stored["energy_variation"],
    )


def _reduction(stored: Mapping[str, Any]) -> ReductionError | None:
    residual = stored["reduction_residual"]
    return None if np.isnan(residual) else ReductionError(residual, stored["reduction_error"])


def _series(stored: Mapping[str, Any]) -> SeriesError | None:
    harmonics, samples = stored["harmonics_error"], stored["samples_error"]
    if np.isnan(harmonics):
        return None
    return SeriesError(harmonics, samples, stored["error_remainder"])


def _notes(stored: Mapping[str, Any]) -> ContinuationNotes:
    return ContinuationNotes(
        iterations=stored["iterations"],
        slope_ratio=stored["slope_ratio"],
        skipped=stored["skipped"],
        event=stored["event"],
        slope=stored["slope"],
        asked=stored["asked"],
    )


def _returned(stored: Mapping[str, Any]) -> Return | None:
    after_one = stored["return_error"]
    if np.isnan(after_one):
        return None
    return Return(after_one, stored["return_error_10"], stored["energy_drift"])


def _orbit(stored: Mapping[str, Any]) -> Orbit | None:
    frequency = stored["shot_frequency"]
    if np.isnan(frequency):
        return None
    return Orbit(frequency, stored["shot_distance"], stored["shot_return_error"])


def _stability(stored: Mapping[str, Any], arrays: Mapping[str, Any]) -> FloquetStability | None:
    kind = stored["stability"]
    if not kind:
        return None
    return FloquetStability(kind, stored["largest_multiplier"], arrays["multipliers"])


def _verdict(stored: Mapping[str, Any]) -> Verdict | None:
    found = Verdict(
        status=stored["status"],
        reason=stored["reason"],
        resonance=stored["resonance"],
        confirmed=bool(stored["confirmed"]),
        family=int(stored["family"]),
    )
    return None if found == NOT_JUDGED else found


def _sustained(stored: Mapping[str, Any]) -> Sustained | None:
    ratio, force = stored["damping_ratio"], stored["resonance_force"]
    return None if np.isnan(ratio) else Sustained(ratio, force, bool(stored["damped"]))
