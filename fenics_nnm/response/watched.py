"""Places of a driven structure whose displacement is watched."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.mechanics.contact_law import ContactForces
from fenics_nnm.mechanics.fourier import FourierSeries, doubled
from fenics_nnm.mechanics.model import ReducedModel


@dataclass(frozen=True, slots=True)
class Place:
    """A place that is watched.

    Attributes:
        shape: psi, displacement per modal coordinate, shape (J,).
        residual: R_w in m/N, shape (n_c,).
        bent: Second derivatives of the displacement by the masters, in 1/(kg m), shape (k, k).
    """

    shape: Array
    residual: Array
    bent: Array


def _no_masters() -> Indices:
    return np.empty(0, dtype=np.int64)


@dataclass(frozen=True, slots=True)
class Watched:
    """Places whose displacement is watched, x = psi q + 1/2 q^T theta q - R_w lambda.

    Those of the forces come first, then further ones, then the contact points.

    Attributes:
        names: Their names.
        shapes: psi, shape (w, J).
        residual: R_w in m/N, shape (w, n_c).
        masters: Places of the masters of second-order kinematics, shape (k,); none where they are
            linear.
        bent: Second derivatives theta by the masters, in 1/(kg m), shape (w, k, k).
    """

    names: tuple[str, ...]
    shapes: Array
    residual: Array
    masters: Indices = field(default_factory=_no_masters)
    bent: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))

    @classmethod
    def of(cls, model: ReducedModel, others: Mapping[str, Place]) -> Watched:
        """Some places by their names, and the contact points."""
        masters, points = model.kinematics.masters, range(model.points)
        closing = model.kinematics.closing.curvatures(model.points)
        own = {
            f"contact {n + 1}": Place(model.Phi[n, :], model.R[n, :], closing[n]) for n in points
        }
        every = {**others, **own}
        parts = [(each.shape, each.residual, each.bent) for each in every.values()]
        shapes, residual, bent = (np.array(each) for each in zip(*parts, strict=True))
        return cls(tuple(every), shapes, residual, masters, bent)

    @property
    def before_contact(self) -> int:
        """Number of places before the contact points."""
        return len(self.names) - self.residual.shape[1]

    @property
    def bends(self) -> bool:
        """Whether places move in second order."""
        return len(self.masters) > 0

    def free(self, basis: Array, q: Array) -> Array:
        """Displacements at phases without contact forces, shape (s, w).

        Args:
            basis: Basis functions there, shape (s, c).
            q: Coefficients of the motion, shape (c, J).
        """
        moved = basis @ (q @ self.shapes.T)
        if self.bends:
            masters = basis @ q[:, self.masters]
            moved += self._by_pairs(masters, masters) / 2
        return np.asarray(moved)

    def at_states(self, q: Array, velocity: Array) -> tuple[Array, Array]:
        """Displacements and speeds without contact forces at states (s, J), each (s, w)."""
        moved, speed = q @ self.shapes.T, velocity @ self.shapes.T
        if self.bends:
            masters, rates = q[:, self.masters], velocity[:, self.masters]
            moved += self._by_pairs(masters, masters) / 2
            speed += self._by_pairs(masters, rates)
        return moved, speed

    def harmonics(self, series: FourierSeries, q: Array, forces: ContactForces) -> Array:
        """Harmonics of the displacements that the series has, shape (c, w)."""
        linear = q @ self.shapes.T - forces.harmonics(series) @ self.residual.T
        if not self.bends:
            return np.asarray(linear)
        finer = doubled(series)
        masters = finer.synthesis @ finer.fitted(q[:, self.masters])
        return linear + series.fitted(finer.analysis @ self._by_pairs(masters, masters)) / 2

    def free_harmonics(self, series: FourierSeries, place: int, q: Array) -> Array:
        """Harmonics of the displacement of a place without contact forces, shape (c,)."""
        return self.slope_harmonics(series, place, q, q) - self._bent_part(series, place, q, q) / 2

    def slope_harmonics(self, series: FourierSeries, place: int, q: Array, change: Array) -> Array:
        """Change of the displacement of a place with the motion, without contact forces, (c,).

        Args:
            series: Series in time.
            place: Number of the place.
            q: Coefficients of the motion, shape (c, J).
            change: Change of these, shape (c, J).
        """
        bent = self._bent_part(series, place, q, change)
        return np.asarray(change @ self.shapes[place] + bent)

    def _bent_part(self, series: FourierSeries, place: int, q: Array, other: Array) -> Array:
        """Harmonics of q^T theta q' of a place, of two motions, shape (c,)."""
        if not self.bends:
            return np.zeros(len(q))
        finer = doubled(series)
        one, two = (finer.synthesis @ finer.fitted(e[:, self.masters]) for e in (q, other))
        bent = np.einsum("sj,jk,sk->s", one, self.bent[place], two)
        return series.fitted((finer.analysis @ bent)[:, None])[:, 0]

    def _by_pairs(self, one: Array, other: Array) -> Array:
        """x^T theta y of vectors (s, k), shape (s, w)."""
        pairs = (one[:, :, None] * other[:, None, :]).reshape(len(one), one.shape[1] ** 2)
        return np.asarray(pairs @ self.bent.reshape(len(self.bent), -1).T)
