"""How far a structure moves: at the node that moves most, or at its contact points."""

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
    """Largest distance from rest over a period at each point of a branch.

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


def _amplitude(values: list[float], name: str, words: str) -> Amplitude:
    unit = unit_for(np.array(values), "m")
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


def place_of(at: Array) -> str:
    """A place (x, y, z) in m in words; round-off is zero."""
    rounded = np.where(np.abs(at) > _ROUND_OFF * np.abs(at).max(), at, 0.0)
    return "({:.4g}, {:.4g}, {:.4g}) mm".format(*(1e3 * rounded))
