"""What may be believed of each point of a branch.

The independent witness is integration in time of the reduced model. It verifies a point, unless
the reduction is expected to put its frequency off by more than 1e-3, in one of three ways:

* below grazing, or lift-off, the motion is the linear mode, in closed form;
* the motion starts with its energy within 1 % and comes back within 5 % after a period, and the
  exact motion of the same energy that shooting finds is near it (10 %) and has its frequency
  (1e-3);
* where no such motion is found, it starts with its energy within 2e-3 and comes back within 2 %
  after ten periods.

The last is a bound, if a safe one only as far as errors do not cancel: a relative error d of the
frequency shifts the phase by 20 pi d in ten periods, which moves the state by as much of its
amplitude or more; so d <= 0.02 / 20 pi = 3e-4. The energy of the state that is followed is within
2e-3 of that of the point, for d ln omega / d ln E < 0.3 another 6e-4. Of 87 motions of random
models that came back within 2 %, the worst was 1.2e-4 from the exact frequency.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.certificate import certified, of_linear_mode
from fenics_nnm.backbone.periodicity import UNKNOWN_RETURN, Return, returned
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.resonance import UNNAMED, stands_still, strongest_resonance
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.bifurcations import Bifurcations, Witness, bifurcations
from fenics_nnm.time_domain.flow import Flow

#: Status of a point, from the best to the worst.
VERIFIED = "verified"
CONVERGED = "converged"
RESONANT = "inside resonance"
FAILED = "failed"
STATUSES = (VERIFIED, CONVERGED, RESONANT, FAILED)

#: A motion that misses its start by more than this part of its amplitude is no motion.
_LARGEST_RETURN_ERROR = 1 / 3

#: So is one whose exact motion of the same energy has another frequency by more than this part.
_LARGEST_SHOT_CHANGE = 0.01

#: Nor does one solve its equations whose virial identity, or complementarity, is off by more.
_LARGEST_EQUATION_ERROR = 1e-6

#: Verified: return error after a period, error of the energy of the initial state, and what the
#: exact motion, and the motion without reduction if that is known, may differ by from the point.
VERIFIED_RETURN_ERROR = 0.05
_VERIFIED_START_ENERGY = 0.01
VERIFIED_CHANGE = 1e-3
_VERIFIED_DISTANCE = 0.1
_VERIFIED_SHOT_RETURN_ERROR = 1e-10

#: Verified without an exact motion: return error after ten periods, and the same of the energy.
_VERIFIED_RETURN_ERROR_10 = 0.02
_VERIFIED_START_ENERGY_ALONE = 2e-3

#: A motion up to this part above grazing, and with the frequency of the linear mode within
#: it, is the linear mode.
_LINEAR = 1e-9

#: A point that was judged before, in another run, is judged anew.
_UNJUDGED: dict[str, Any] = {
    "reason": "",
    "shot_frequency": float("nan"),
    "shot_distance": float("nan"),
    "shot_return_error": float("nan"),
    "largest_multiplier": float("nan"),
    "stability": "",
    "multipliers": np.empty(0, dtype=complex),
}

#: Why points of models without an integration in time are not verified.
WITH_MASS = "contact points carry mass: there is no motion in time to compare with"


@dataclass(frozen=True, slots=True)
class Judgement:
    """What integration in time says of a branch.

    Attributes:
        points: Points with their verdicts.
        bifurcations: Bifurcations of its exact motions.
    """

    points: tuple[BranchPoint, ...]
    bifurcations: Bifurcations


def judged(
    model: ReducedModel,
    series: Series,
    points: Sequence[BranchPoint],
    *,
    mode: int,
    harmonic: int = 1,
    shooting: bool,
) -> Judgement:
    """The points with return errors, shot motions, internal resonances and statuses.

    Beyond grazing, points of a model whose contact points carry mass are "converged" at best: their
    motion after an impact depends on an impact law that harmonic balance does not have.

    Args:
        model: Reduced model in SI units.
        series: Series that the points are written in.
        points: Points of a branch of this model.
        mode: Index of the followed mode.
        harmonic: Harmonic that it is written in.
        shooting: Whether to shoot for the true motion near each point.
    """
    flow = Flow(model) if model.massless else None
    resonances = [internal_resonance(model, series, point, mode, harmonic) for point in points]
    others = np.delete(model.at_rest().omega, mode)
    pairs = [
        _judged(flow, series, replace(point, resonance=resonance, **_UNJUDGED), others, shooting)
        for point, resonance in zip(points, resonances, strict=True)
    ]
    found = Bifurcations()
    if flow and shooting:
        witnesses = [witness for _, witness in pairs]
        found = bifurcations(flow, witnesses, reversible=not series.free_phase)
    return Judgement(tuple(point for point, _ in pairs), found)


def internal_resonance(
    model: ReducedModel, series: Series, point: BranchPoint, mode: int, harmonic: int = 1
) -> str:
    """The mode and harmonic that draw energy from the motion in resonance, or nothing."""
    omega = 2 * np.pi * point.frequency
    found = strongest_resonance(model, series, point.q, omega, mode=mode, harmonic=harmonic)
    if found.entered:
        return str(found)
    by_mode = point.q @ model.at_rest().shapes
    still = stands_still(series, by_mode, point.slope_ratio, mode=mode, harmonic=harmonic)
    return UNNAMED if still else ""


def _judged(
    flow: Flow | None, series: Series, point: BranchPoint, others: Array, shooting: bool
) -> tuple[BranchPoint, Witness | None]:
    """A point with its verdict, and its exact motion if there is one.

    `others` are the circular frequencies of the linear modes besides the followed one.
    """
    witness = None
    found = returned(flow, series, point) if flow else UNKNOWN_RETURN
    point = replace(
        point,
        return_error=found.after_one,
        return_error_10=found.after_ten,
        energy_drift=found.energy_drift,
    )
    if flow and shooting and not np.isnan(found.after_one):
        point, witness = certified(flow, series, point)
    if _is_linear(point):
        point = of_linear_mode(point, others)
    return _verdict(point, found, massless=flow is not None), witness


def _is_linear(point: BranchPoint) -> bool:
    return point.gamma_ratio <= 1 + _LINEAR and abs(point.frequency_ratio - 1) <= _LINEAR


def _verdict(point: BranchPoint, found: Return, *, massless: bool) -> BranchPoint:
    """The point with its status, and the reason for any but the best."""
    failure = _failure(point, found)
    if failure:
        return replace(point, status=FAILED, reason=failure)
    if point.resonance:
        reason = f"{point.resonance} draws energy from the motion"
        return replace(point, status=RESONANT, reason=reason)
    doubt = "" if _is_linear(point) else _doubt(point, found) if massless else WITH_MASS
    return replace(point, status=CONVERGED if doubt else VERIFIED, reason=doubt)


def _failure(point: BranchPoint, found: Return) -> str:
    """What shows that the point is no motion of the model, or nothing."""
    if point.virial_error > _LARGEST_EQUATION_ERROR:
        return f"the virial identity is off by {point.virial_error:.1e}"
    if point.complementarity > _LARGEST_EQUATION_ERROR:
        return f"force times gap is {point.complementarity:.1e} and not zero at a sample"
    if found.failure and np.isnan(found.after_one):
        return f"integration in time gave up: {found.failure}"
    if point.return_error > _LARGEST_RETURN_ERROR:
        return f"after one period the motion misses its start by {point.return_error:.0%}"
    if abs(_shot_change(point)) > _LARGEST_SHOT_CHANGE:
        return f"the exact motion of its energy is {_shot_change(point):+.1%} away in frequency"
    return ""


def _doubt(point: BranchPoint, found: Return) -> str:
    """Why integration in time does not confirm the point, or nothing."""
    if abs(point.reduction_error) > VERIFIED_CHANGE:
        return f"the reduction is expected to put its frequency off by {point.reduction_error:+.2%}"
    if np.isnan(point.shot_frequency):
        return _doubt_without_exact_motion(point, found)
    if abs(found.start_energy) > _VERIFIED_START_ENERGY:
        return _energy_off(found)
    if point.return_error > VERIFIED_RETURN_ERROR:
        return f"after one period the motion misses its start by {point.return_error:.1%}"
    if abs(_shot_change(point)) > VERIFIED_CHANGE:
        return f"the exact motion of its energy is {_shot_change(point):+.2%} away in frequency"
    if point.shot_distance > _VERIFIED_DISTANCE:
        return f"the exact motion of its energy is {point.shot_distance:.0%} of the amplitude away"
    if point.shot_return_error > _VERIFIED_SHOT_RETURN_ERROR:
        return f"the shot motion misses its start by {point.shot_return_error:.1e}"
    return ""


def _doubt_without_exact_motion(point: BranchPoint, found: Return) -> str:
    if found.failure:
        missed = f"integration in time gave up: {found.failure}"
    elif found.after_ten > _VERIFIED_RETURN_ERROR_10:
        missed = f"after ten periods the motion misses its start by {found.after_ten:.1%}"
    elif abs(found.start_energy) > _VERIFIED_START_ENERGY_ALONE:
        missed = _energy_off(found)
    else:
        return ""
    return f"{missed}; {point.reason}" if point.reason else missed


def _energy_off(found: Return) -> str:
    return f"the energy of its initial state is {found.start_energy:+.2%} off"


def _shot_change(point: BranchPoint) -> float:
    """Frequency of the exact motion over that of the point, less 1; nan without one."""
    return point.shot_frequency / point.frequency - 1
