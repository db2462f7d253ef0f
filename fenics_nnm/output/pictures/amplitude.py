"""How far a structure moves, at the node that moves most or at its contact points; its stress."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.style import Unit, unit_for

#: Instants of a period at which the largest displacement is looked for.
_INSTANTS = 48

#: Coordinates of a place below this part of the largest are zero.
_ROUND_OFF = 1e-9


@dataclass(frozen=True, slots=True)
class Amplitude:
    """Largest distance from rest, or largest stress, over a period at each point of a branch.

    Attributes:
        values: In the unit, shape (points,).
        label: Label of an axis.
        words: What it is, in words.
        unit: The unit.
    """

    values: Array
    label: str
    words: str
    unit: Unit


def _amplitude(values: list[float], name: str, words: str, of: str = "m") -> Amplitude:
    unit = unit_for(np.array(values), of)
    label, words = f"{name}  ({unit.name})", words.format(unit=unit.name)
    return Amplitude(unit.factor * np.array(values), label, words, unit)


def amplitude_of(results: Results) -> Amplitude:
    """The largest displacement of a body, or of the contact points of matrices."""
    phase = 2 * np.pi * np.arange(_INSTANTS) / _INSTANTS
    if results.body is None:
        values = [
            np.abs(results.contact_displacement(point, phase)).max() for point in results.points
        ]
        words = "the largest displacement of a contact point from rest over the period, in {unit}"
        return _amplitude(values, "largest displacement at contact", words)
    body, tip = results.body, np.array([results.tip])
    values = [
        np.linalg.norm(body.displacement(point, phase, tip), axis=2).max()
        for point in results.points
    ]
    words = (
        "the largest displacement from rest over the period, in {unit}, of the node that moves "
        f"most, at {place_of(body.nodes[tip[0]])}"
    )
    return _amplitude(values, "largest displacement", words)


def stress_of(results: Results) -> Amplitude | None:
    """The largest von Mises stress away from singular places; none where it is not known."""
    values = [point.extremes.von_mises.away.value for point in results.points]
    if not np.isfinite(values).all():
        return None
    words = (
        "the largest von Mises stress over the period, in {unit}, with that of the state of rest, "
        "away from contact points, the edge of the clamp and sharp corners"
    )
    return _amplitude(values, "von Mises stress", words, "Pa")


def place_of(at: Array) -> str:
    """A place (x, y, z) in m in words; round-off is zero."""
    rounded = np.where(np.abs(at) > _ROUND_OFF * np.abs(at).max(), at, 0.0)
    return "({:.4g}, {:.4g}, {:.4g}) mm".format(*(1e3 * rounded))
