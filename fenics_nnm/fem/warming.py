"""Temperature of a body, less that at which it is free of stress."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from dolfinx import fem
from dolfinx import mesh as dmesh
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.fem.stress import Expr


class Warming(Protocol):
    """Temperature less that at which the body is free of stress, in K."""

    @property
    def any(self) -> bool:
        """Whether it is not zero everywhere."""

    @property
    def span(self) -> tuple[float, float]:
        """Its smallest and its largest value."""

    @property
    def words(self) -> str:
        """It in words."""

    def expression(self, mesh: dmesh.Mesh, factor: float = 1.0) -> Expr:
        """A factor times it, in UFL."""

    def at_nodes(self, space: fem.FunctionSpace) -> Array:
        """Its values at the owned nodes of a space of displacements, shape (n,)."""


@dataclass(frozen=True, slots=True)
class UniformWarming:
    """The same everywhere.

    Attributes:
        value: In K.
    """

    value: float = 0.0

    @property
    def any(self) -> bool:
        """As `Warming`."""
        return bool(self.value)

    @property
    def span(self) -> tuple[float, float]:
        """As `Warming`."""
        return self.value, self.value

    @property
    def words(self) -> str:
        """As `Warming`."""
        return f"{self.value:+.6g} K from the state free of stress"

    def expression(self, mesh: dmesh.Mesh, factor: float = 1.0) -> Expr:
        """As `Warming`."""
        return fem.Constant(mesh, float(factor * self.value))

    def at_nodes(self, space: fem.FunctionSpace) -> Array:
        """As `Warming`."""
        return np.full(space.dofmap.index_map.size_local, self.value)


@dataclass(frozen=True, slots=True)
class WarmingField:
    """From place to place.

    Attributes:
        field: In K, by its values at the nodes of the displacement.
        span: Smallest and largest value in K.
        origin: What it is given by, in words.
    """

    field: fem.Function
    span: tuple[float, float]
    origin: str

    @property
    def any(self) -> bool:
        """As `Warming`."""
        return any(self.span)

    @property
    def words(self) -> str:
        """As `Warming`."""
        low, high = self.span
        return f"{low:+.6g} to {high:+.6g} K from the state free of stress, {self.origin}"

    def expression(self, mesh: dmesh.Mesh, factor: float = 1.0) -> Expr:
        """As `Warming`."""
        return fem.Constant(mesh, float(factor)) * self.field

    def at_nodes(self, space: fem.FunctionSpace) -> Array:
        """As `Warming`."""
        own, values = self.field.function_space.dofmap.list, self.field.x.array
        nodes = np.empty(len(values))
        nodes[space.dofmap.list.ravel()] = values[own.ravel()]
        return nodes[: space.dofmap.index_map.size_local]


def scalar_field(
    mesh: dmesh.Mesh, degree: int, values: Callable[[Array], Array]
) -> tuple[fem.Function, tuple[float, float]]:
    """A field by its values at the nodes, with its range over all ranks; to be called on all.

    Args:
        mesh: Mesh.
        degree: Degree of the field.
        values: Values at the nodes of this rank, from their places (m, 3) in m.
    """
    space = fem.functionspace(mesh, ("Lagrange", degree))
    field = fem.Function(space)
    owned = space.dofmap.index_map.size_local
    found = values(space.tabulate_dof_coordinates()[:owned])
    field.x.array[:owned] = found
    field.x.scatter_forward()
    low = float(mesh.comm.allreduce(np.min(found, initial=np.inf), op=MPI.MIN))
    high = float(mesh.comm.allreduce(np.max(found, initial=-np.inf), op=MPI.MAX))
    return field, (low, high)
