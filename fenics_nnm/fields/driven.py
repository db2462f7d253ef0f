"""Motions of a driven structure as those that files are wanted of."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fields.named import NamedMotion
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.motion import Motion
from fenics_nnm.mechanics.moving_gap import STILL, GapMotion
from fenics_nnm.response.point import ResponsePoint
from fenics_nnm.results.header import BranchHeader


@dataclass(frozen=True, slots=True)
class DrivenMotion:
    """A motion of a response.

    Attributes:
        position: Its number, from 0.
        motion: The motion; Rayleigh quotient and energy are those of free motions: nan.
    """

    position: float
    motion: Motion


def of_response(
    header: BranchHeader,
    points: Sequence[ResponsePoint],
    numbers: Sequence[int],
    gap_motion: GapMotion = STILL,
) -> list[NamedMotion]:
    """Motions of a response by level and frequency; later passings of both get a number.

    Args:
        header: What the file of the response says of all its motions.
        points: Motions of the response.
        numbers: Those that files are wanted of.
        gap_motion: How gaps move at level 1.
    """
    passed: Counter[tuple[str, str]] = Counter()
    named = []
    for number in numbers:
        point = points[number]
        level, frequency = f"{point.level:g}", f"{point.frequency:.6g}"
        passed[level, frequency] += 1
        again = passed[level, frequency]
        passing = f" passing{again}" if again > 1 else ""
        words = f"level {level}, {frequency} Hz"
        moved = gap_motion.scaled(point.level)
        motion = _motion(header.model, header.time_series, point, moved)
        named.append(
            NamedMotion(
                name=f"level{level}_{frequency}Hz{passing.replace(' ', '_')}",
                short=f"{words}{passing}",
                words=words,
                weight=float(point.amplitude[0]),
                point=DrivenMotion(float(number), motion),
            )
        )
    return named


def _motion(
    model: ReducedModel, series: Series, point: ResponsePoint, gap_motion: GapMotion
) -> Motion:
    """A motion; its contact points are displaced against gaps that move with -(g - g0)."""
    free, basis = point.q @ model.Phi.T - gap_motion.coefficients(series), series.synthesis
    moved = model.kinematics.closing.displaced(basis @ free, basis, point.q)
    return Motion(
        q=point.q,
        force=_forces(model, moved),
        free=free,
        frequency=point.frequency,
        rayleigh_frequency=float("nan"),
        energy=float("nan"),
        contact_fraction=float(point.displacements.contact.max()),
    )


def _forces(model: ReducedModel, moved: Array) -> Array:
    """Contact forces in N at displacements (s, n_c); none where points move with the modes."""
    if not model.massless:
        return np.zeros_like(moved)
    return Complementarity(model.R, model.gap)(moved).force
