"""Terms of a structure of matrices that are not linear: polynomial stiffness, quadratic closing.

    f_i = K_ij u_j + K2_ijk u_j u_k + K3_ijkl u_j u_k u_l,      w_c = B_cj u_j + B2_cjk u_j u_k,

each given as an array of all entries, or as a table with a row for each entry that is not zero: its
places, from 1, and its value.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ModelError

#: Forces may lack a potential by this much of their largest entry, from round-off.
_NO_POTENTIAL = 1e-6


@dataclass(frozen=True, slots=True)
class Entries:
    """Entries of an array of several dimensions that are not zero.

    Attributes:
        place: Their places, from 0, shape (r, dimensions).
        value: Values, shape (r,).
    """

    place: Indices
    value: Array

    @classmethod
    def none(cls, dimensions: int) -> Entries:
        """An array of zeros."""
        return cls(np.zeros((0, dimensions), dtype=np.int64), np.zeros(0))

    @classmethod
    def of(cls, name: str, given: Any, shape: tuple[int, ...]) -> Entries:
        """From a dense array of a shape, or a table of places and values.

        Raises:
            ModelError: if it is neither, or has values that are not finite real numbers.
        """
        array = np.asarray(given.toarray() if hasattr(given, "toarray") else given)
        if array.dtype.kind not in "biuf":
            raise ModelError(f"{name} has entries of type {array.dtype}: must be real numbers")
        if not np.all(np.isfinite(array)):
            raise ModelError(f"{name} has entries that are not finite")
        if array.shape == shape:
            place = np.argwhere(array)
            return cls(place, array[tuple(place.T)].astype(np.float64))
        if array.ndim != 2 or array.shape[1] != len(shape) + 1:
            raise ModelError(
                f"{name} has shape {array.shape}: must be {shape}, or a table with "
                f"{len(shape) + 1} columns: places from 1, and value"
            )
        return cls._of_table(name, array.astype(np.float64), shape)

    @classmethod
    def _of_table(cls, name: str, table: Array, shape: tuple[int, ...]) -> Entries:
        place = table[:, :-1]
        wrong = (place != np.round(place)) | (place < 1) | (place > np.array(shape))
        if wrong.any():
            row, column = np.argwhere(wrong)[0]
            raise ModelError(
                f"{name} has the place {place[row, column]:g} in row {row + 1}, column "
                f"{column + 1}: must be a whole number from 1 to {shape[column]}"
            )
        return cls(place.astype(np.int64) - 1, table[:, -1])

    def assert_potential(self, name: str, size: int) -> None:
        """Refuse forces without potential, whose energy is not kept.

        With the potential c u_a u_b .. of a product of displacements, the force on the unknown a is
        c times the number of times that a stands in it, times the product without one u_a.

        Args:
            name: Name of the array.
            size: Number of unknowns n.

        Raises:
            ModelError: if forces on several unknowns belong to no potential.
        """
        products, which = self._products(size)
        forces = np.zeros(products.shape)
        for column in range(products.shape[1]):
            own = products[which, column] == self.place[:, 0]
            np.add.at(forces[:, column], which[own], self.value[own])
        times = (products[:, :, None] == products[:, None, :]).sum(axis=2)
        spread = np.ptp(forces / times, axis=1)
        if np.any(spread > _NO_POTENTIAL * np.abs(forces).max(initial=0.0)):
            unknowns = (products[spread.argmax()] + 1).tolist()
            raise ModelError(
                f"{name}: has no potential: its entries with the places {unknowns}, in any order, "
                "must be forces of one potential, as in K_ijk = K_jik = K_kji"
            )

    def _products(self, size: int) -> tuple[Indices, Indices]:
        """Products of displacements of the potential, (p, dimensions), and that of each entry."""
        ordered = np.sort(self.place, axis=1)
        which = np.zeros(len(ordered), dtype=np.int64)
        for column in ordered.T:
            _, first, which = np.unique(
                which * size + column, return_index=True, return_inverse=True
            )
        return ordered[first], which


@dataclass(frozen=True, slots=True)
class MatrixTerms:
    """What bending far adds to matrices.

    Attributes:
        size: Number of unknowns n.
        points: Number of contact rows n_c.
        K2: Quadratic stiffness in N/m^2, of shape (n, n, n).
        K3: Cubic stiffness in N/m^3, of shape (n, n, n, n).
        B2: Quadratic part of the contact rows in 1/m, of shape (n_c, n, n).
    """

    size: int
    points: int
    K2: Entries
    K3: Entries
    B2: Entries

    def second(self, a: Array, b: Array) -> Array:
        """f''[a, b] at rest, shape (n,)."""
        return self._force(self.K2, (a, b))

    def third(self, a: Array, b: Array, c: Array) -> Array:
        """Third derivative of the force, shape (n,)."""
        return self._force(self.K3, (a, b, c))

    def curvature(self, shapes: Array) -> Array:
        """Second derivatives of the contact rows along k shapes (n, k), shape (n_c, k, k)."""
        point, first, second = self.B2.place.T
        whole = np.zeros((self.points, shapes.shape[1], shapes.shape[1]))
        each = self.B2.value[:, None, None] * (
            shapes[first][:, :, None] * shapes[second][:, None, :]
        )
        np.add.at(whole, point, each)
        return np.asarray(whole + whole.swapaxes(1, 2))

    def _force(self, entries: Entries, moved: tuple[Array, ...]) -> Array:
        """Sum over all orders of the displacements."""
        force = np.zeros(self.size)
        for term in _terms(entries, moved):
            np.add.at(force, entries.place[:, 0], term)
        return force


def _terms(entries: Entries, moved: tuple[Array, ...]) -> Iterator[Array]:
    for order in permutations(moved):
        term = entries.value
        for column, u in enumerate(order, start=1):
            term = term * u[entries.place[:, column]]
        yield term
