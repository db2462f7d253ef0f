"""Contact pressure along a line, and how far it oscillates from point to point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel


@dataclass(frozen=True, slots=True)
class ContactLine:
    """Contact points in the order of their place y along a line x = constant.

    Attributes:
        order: Indices of the contact points, ascending in y, shape (n_c,).
        y: Places in m, shape (n_c,).
        areas: Tributary areas in m^2, shape (n_c,).
    """

    order: Indices
    y: Array
    areas: Array

    @classmethod
    def of(cls, interface: ContactInterface) -> ContactLine:
        """The line that the contact points of a plane body lie on."""
        order = np.argsort(interface.points[:, 1])
        return cls(order, interface.points[order, 1], interface.areas[order])

    def at_samples(self, point: BranchPoint) -> Array:
        """Force over tributary area at the time samples in Pa, shape (s, n_c)."""
        return point.motion.force[:, self.order] / self.areas

    def acting(self, point: BranchPoint, series: Series, phase: Array) -> Array:
        """Pressure of the harmonics 0 to N, all that acts on the motion, (len(phase), n_c).

        Forces at the samples hold higher harmonics too. Where the contact points carry mass (R = 0)
        these are not determined by the equations; the harmonics up to N are.
        """
        return series.basis_at(phase) @ series.analysis @ self.at_samples(point)

    def mean(self, point: BranchPoint, series: Series) -> Array:
        """Mean over the period in Pa, shape (n_c,)."""
        return np.asarray(series.weight @ self.at_samples(point))

    def pressed(self, model: ReducedModel) -> Array:
        """Static pressure that moves all points of the line by the same 1 m, in Pa.

        All of the model's flexibility is in it, so it is that of the mesh, not of the modes.
        """
        modal = model.Phi / model.omega
        flexibility = model.R + modal @ modal.T
        force = np.linalg.solve(flexibility, np.ones(model.points))
        return np.asarray(force[self.order] / self.areas)


def zigzag(y: Array, pressure: Array) -> float:
    """Amplitude in Pa of the oscillation from point to point.

    With d_i the distance of p_i from the straight line through its two neighbours, the largest
    min(|d_i|, |d_i+1|) / 2 of adjacent points on opposite sides. A constant plus a (-1)^i gives a;
    straight lines, curves of one sign of curvature and single kinks give 0, on any spacing. Only
    points in contact whose neighbours are in contact count: the edge of a contact zone is a kink.

    Args:
        y: Places, ascending, shape (n_c,).
        pressure: Pressure, shape (n_c,).
    """
    part = (y[1:-1] - y[:-2]) / (y[2:] - y[:-2])
    distance = pressure[1:-1] - (1 - part) * pressure[:-2] - part * pressure[2:]
    touching = pressure != 0
    distance = np.where(touching[:-2] & touching[1:-1] & touching[2:], distance, 0.0)
    smaller = np.minimum(np.abs(distance[1:]), np.abs(distance[:-1]))
    opposite = distance[1:] * distance[:-1] < 0
    return float(np.where(opposite, smaller, 0.0).max() / 2)


def corner_jump(y: Array, pressure: Array) -> float:
    """Distance in Pa of the end pressures from the lines through the next two points."""
    jumps = []
    for end in (slice(None, 3), slice(None, -4, -1)):
        (y0, y1, y2), (p0, p1, p2) = y[end], pressure[end]
        jumps.append(abs(p0 - p1 - (p2 - p1) * (y0 - y1) / (y2 - y1)))
    return float(max(jumps))
