"""Kinematics of a reduced model: linear, or of second order with quadratic closing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.mechanics.closing import LINEAR_CLOSING, Closing
from fenics_nnm.mechanics.force import MasterForce
from fenics_nnm.mechanics.inertia import CONSTANT, Inertia


class ModalShapes(Protocol):
    """Frequencies and contact displacements of modes; see `mechanics.model.ReducedModel`."""

    @property
    def omega(self) -> Array:
        """Natural circular frequencies, shape (J,)."""

    @property
    def Phi(self) -> Array:
        """Displacement of the contact points per modal coordinate, shape (n_c, J)."""


class Kinematics(Protocol):
    """What large deflection adds to a reduced model."""

    @property
    def masters(self) -> Indices:
        """Places of the modes that are part of every truncation of the model."""

    @property
    def closing(self) -> Closing:
        """How contact points close beyond Phi q."""

    @property
    def forces(self) -> tuple[MasterForce, ...]:
        """Forces on the coordinates."""

    @property
    def inertia(self) -> Inertia:
        """Inertia of the coordinates."""

    @property
    def tensors(self) -> Mapping[str, Array]:
        """What defines it besides its masters, by name; nothing for linear kinematics."""

    def curvature(self, model: ModalShapes) -> Array:
        """Second derivatives of the closing along each mode, others following, shape (n_c, J)."""

    def following(self, model: ModalShapes) -> Array:
        """Second derivatives of all coordinates (rows) along each mode, statically, (J, J)."""

    def assert_fits(self, model: ModalShapes) -> None:
        """Refuse a model of other sizes.

        Raises:
            ModelError: if there is a reason.
        """

    def without_modes(self, chosen: Indices, model: ModalShapes) -> Kinematics:
        """The kinematics of a part of the modes of a model; the others follow statically.

        Raises:
            ModelError: if a master is left out.
        """

    def among_more(self, omega: Array, Phi: Array, shared: Array) -> Kinematics:
        """The kinematics with further coordinates, see `SecondOrder.among_more`."""

    def scaled(self, *, omega: float, amplitude: float, length: float) -> Kinematics:
        """The same in units of a frequency (rad/s), a coordinate (kg^1/2 m) and a length (m)."""


class LinearKinematics:
    """Small deflections: nothing is added."""

    __slots__ = ()

    @property
    def masters(self) -> Indices:
        """None."""
        return np.empty(0, dtype=np.int64)

    @property
    def closing(self) -> Closing:
        """Phi q alone."""
        return LINEAR_CLOSING

    @property
    def forces(self) -> tuple[MasterForce, ...]:
        """None."""
        return ()

    @property
    def inertia(self) -> Inertia:
        """Modes are mass-normalised."""
        return CONSTANT

    @property
    def tensors(self) -> Mapping[str, Array]:
        """None."""
        return {}

    def curvature(self, model: ModalShapes) -> Array:
        """None."""
        return np.zeros_like(model.Phi)

    def following(self, model: ModalShapes) -> Array:
        """None."""
        return np.zeros((len(model.omega), len(model.omega)))

    def assert_fits(self, model: ModalShapes) -> None:
        """It fits every model."""

    def without_modes(self, chosen: Indices, model: ModalShapes) -> Kinematics:
        """It stays linear."""
        return self

    def among_more(self, omega: Array, Phi: Array, shared: Array) -> Kinematics:
        """It stays linear."""
        return self

    def scaled(self, *, omega: float, amplitude: float, length: float) -> Kinematics:
        """It stays linear."""
        return self


LINEAR = LinearKinematics()
