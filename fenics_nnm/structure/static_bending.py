"""A body bent statically by the inertia forces of a mode: geometrically exact, and by a model.

The load is mu M phi: its size follows from that of the displacement in the mode. The exact states
are what kinematics of a reduced model are compared with.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ConvergenceError, ModelError
from fenics_nnm.fem.block import product, solved
from fenics_nnm.fem.factorisation import factorise, use_mumps
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.loaded_residual import LoadedResidual
from fenics_nnm.fem.loads import Loads
from fenics_nnm.fem.solid import Solid
from fenics_nnm.mechanics.model import ReducedModel

#: Newton's method has converged when a step is this part of the displacement; it fails after so
#: many steps.
_ACCURACY, _MOST_STEPS = 1e-9, 30


@dataclass(frozen=True, slots=True)
class Bent:
    """A geometrically exact static state.

    Attributes:
        displacement: Displacement from the state under the steady loads in m, at the owned degrees
            of freedom, shape (n_owned,).
        coordinate: Its coordinate phi . M u in the mode, kg^1/2 m.
        load: Size mu of the load mu M phi, kg^1/2 m/s^2.
    """

    displacement: Array
    coordinate: float
    load: float


def statically_bent(linear: LinearAnalysis, mode: int, wanted: Sequence[float]) -> Iterator[Bent]:
    """Exact states under ever larger inertia forces of a mode; called on all ranks.

    Args:
        linear: Body about its static state, if it has one, with its reduced model.
        mode: Index of the mode, from 0.
        wanted: Coordinates in the mode that linear statics would give, kg^1/2 m, from small to
            large: each state begins at the one before.

    Raises:
        ConvergenceError: if Newton's method does not converge.
    """
    solid, omega = linear.solid, linear.model.omega[mode]
    phi = linear.reduction.shapes[:, mode]
    inertia = product(solid.mass, phi[:, None])[:, 0]
    rest = _at_rest(solid)
    with closing(_Newton(solid, rest)) as newton:
        for each in wanted:
            load = float(omega) ** 2 * each
            moved = newton.under(load * inertia) - rest
            coordinate = float(solid.tagged.mesh.comm.allreduce(inertia @ moved, MPI.SUM))
            yield Bent(moved, coordinate, load)


def radial_closing(linear: LinearAnalysis, displacement: Array) -> Array:
    """How far contact points come away from the x axis, exactly, in m, shape (n_c,).

    Args:
        linear: Body about its static state, if it has one.
        displacement: Displacement from that state at the owned degrees of freedom, m.
    """
    rest = _at_rest(linear.solid)
    before, after = (_radius(linear, each) for each in (rest, rest + displacement))
    return np.asarray(after - before)


@dataclass(frozen=True, slots=True)
class BentModel:
    """A reduced model bent in its only master, all other modes following statically.

    Attributes:
        model: Model with second-order kinematics of one master.

    Raises:
        ModelError: if it has more or fewer masters.
    """

    model: ReducedModel

    def __post_init__(self) -> None:
        if len(self.model.kinematics.masters) != 1:
            raise ModelError(
                f"model with {len(self.model.kinematics.masters)} masters: must have one"
            )

    def linear_closing(self, coordinate: float) -> Array:
        """Closing of each contact point with linear kinematics, m, shape (n_c,)."""
        return np.asarray(self.model.Phi[:, self._master] * coordinate)

    def closing(self, coordinate: float) -> Array:
        """Closing of each contact point with second-order kinematics, m, shape (n_c,)."""
        bend = self.model.kinematics.curvature(self.model)[:, self._master]
        return self.linear_closing(coordinate) + bend * coordinate**2 / 2

    def load(self, coordinate: float) -> float:
        """Force on the master that holds it there, kg^1/2 m/s^2."""
        model, j, q = self.model, self._master, coordinate
        tensors = model.kinematics.tensors
        others = self._coordinates(q)
        others[j] = 0.0
        alpha, beta = tensors["alpha"][:, 0, 0], tensors["beta"][0, 0, 0, 0]
        own = model.omega[j] ** 2 * q + alpha[j] * q**2 + beta * q**3
        return float(own + 2 * q * alpha @ others)

    @property
    def _master(self) -> int:
        return int(self.model.kinematics.masters[0])

    def _coordinates(self, coordinate: float) -> Array:
        """All modal coordinates: the quadratic force moves those of the other modes."""
        alpha = self.model.kinematics.tensors["alpha"][:, 0, 0]
        q = np.asarray(-alpha * coordinate**2 / self.model.omega**2)
        q[self._master] = coordinate
        return q


def _at_rest(solid: Solid) -> Array:
    """Displacement under the steady loads from the unloaded body, m, shape (n_owned,)."""
    return solid.state.owned(solid.owned) if solid.state else np.zeros(solid.owned)


def _radius(linear: LinearAnalysis, displacement: Array) -> Array:
    """Distance of contact points from the x axis, m, at a displacement from the unloaded body."""
    moved = linear.interface.displacements(displacement[:, None])[:, :, 0]
    places = linear.interface.points + moved
    return np.asarray(np.hypot(places[:, 1], places[:, 2]))


class _Newton:
    """Newton's method for a body under its steady loads and a dead force besides."""

    def __init__(self, solid: Solid, start: Array) -> None:
        """Begin at a displacement in m from the unloaded body, shape (n_owned,)."""
        bare, loads = solid, Loads()
        if solid.state:
            bare = replace(solid, stiffness=solid.state.unloaded, state=None)
            loads = solid.state.loads
        self._residual = LoadedResidual(bare, loads)
        self._residual.apply(1.0)
        self._residual.move(start)
        self._ksp = PETSc.KSP().create(solid.stiffness.comm)
        self._ksp.setOptionsPrefix("nnm_static_")
        use_mumps(self._ksp)

    def close(self) -> None:
        """Free the factorisation."""
        self._ksp.destroy()

    def under(self, force: Array) -> Array:
        """Displacement in m under a force in N, both at the owned degrees of freedom.

        Raises:
            ConvergenceError: if it is not found.
        """
        residual = self._residual
        for _ in range(_MOST_STEPS):
            self._ksp.setOperators(residual.assemble())
            factorise(self._ksp)
            change = solved(self._ksp, (force - residual.value())[:, None])[:, 0]
            residual.move(residual.owned + change)
            if residual.norm(change) < _ACCURACY * residual.norm(residual.owned):
                return residual.owned.copy()
        raise ConvergenceError(
            f"static bending: Newton's method has not converged after {_MOST_STEPS} steps: the "
            "force must be less"
        )
