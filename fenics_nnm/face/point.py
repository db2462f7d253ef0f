"""A point of a branch in Python: one periodic motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.face.arguments import number
from fenics_nnm.face.histories import (
    ContactHistory,
    MotionHistory,
    Place,
    UnknownsHistory,
    contact_history,
    motion_history,
    unknowns_history,
)
from fenics_nnm.face.loaded import Loaded
from fenics_nnm.results.tables import COLUMNS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Instants of a period where none are given.
_INSTANTS = 128


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Point:
    """A periodic motion of a branch.

    Displacements are those from the state of rest, under steady loads if there are any.
    """

    _loaded: Loaded
    _point: BranchPoint

    def __repr__(self) -> str:
        return f"Point({self.frequency_Hz:.6g} Hz, {self.energy_J:.6g} J, {self.status})"

    @property
    def frequency_Hz(self) -> float:
        """Frequency in Hz."""
        return float(self._point.motion.frequency)

    @property
    def period_s(self) -> float:
        """Period in s."""
        return 1 / self.frequency_Hz

    @property
    def energy_J(self) -> float:
        """Total energy in J, from the state of rest."""
        return float(self._point.motion.energy)

    @property
    def gamma_ratio(self) -> float:
        """Modal energy coordinate over its value at first contact."""
        return float(self._point.gamma_ratio)

    @property
    def status(self) -> str:
        """What may be believed: "verified", "converged", "inside resonance" or "failed"."""
        return self._point.status

    @property
    def reason(self) -> str:
        """Why the point is not verified; empty if it is."""
        return self._point.reason

    @property
    def row(self) -> dict[str, Any]:
        """Numbers and texts of its row of backbone.csv by column, in full digits."""
        return {name: column.of(self._point) for name, column in COLUMNS.items()}

    @property
    def largest_displacement_m(self) -> float:
        """Largest displacement of a node from rest over the period in m, of matrices of an unknown.

        Results of earlier versions and of full order have no such number: it is computed then, at
        48 instants of the mesh, and of matrices at the contact points.
        """
        stored = float(COLUMNS["displacement_m"].of(self._point))
        if np.isfinite(stored):
            return stored
        body = self._loaded.results.body
        if body is None:
            return float(np.abs(self.contact(48).displacement_m).max())
        return float(body.largest_displacement(self._point).max())

    def contact(self, instants: int = _INSTANTS) -> ContactHistory:
        """Forces, displacements and distances of the contact points over one period.

        Args:
            instants: Number of instants at equal steps.

        Raises:
            ValueError: if there is not one at least.
        """
        return contact_history(self._loaded, self._point, instants)

    def motion(self, at: Sequence[Place] | None = None, instants: int = _INSTANTS) -> MotionHistory:
        """Displacement and velocity of nodes over one period.

        Args:
            at: Places (x, y, z) in m, of which the nearest nodes are taken; the node that moves
                most at the last point of the branch if not given.
            instants: Number of instants at equal steps.

        Raises:
            OutputError: if the results are of matrices, or a place is not on the body.
            ValueError: if a place is none, or there is not one instant at least.
        """
        return motion_history(self._loaded, self._point, at, instants)

    def unknowns(self, instants: int = _INSTANTS) -> UnknownsHistory:
        """Displacement of all unknowns of matrices over one period.

        Args:
            instants: Number of instants at equal steps.

        Raises:
            OutputError: if the results are of a mesh.
            ValueError: if there is not one instant at least.
        """
        return unknowns_history(self._loaded, self._point, instants)

    def grid(self, phase: float = 0.0, *, stress: bool = True) -> Any:
        """The body at one instant as a grid of pyvista, for `grid.plot()`, `warp_by_vector` ...

        Names of its arrays are those of the ParaView files.

        Args:
            phase: The instant as a part of the period, from 0 to 1.
            stress: Whether to add the von Mises stress, steady loads included.

        Returns:
            A `pyvista.UnstructuredGrid` with "displacement (m)", "velocity (m/s)" and "von Mises
            stress (Pa)" at its nodes.

        Raises:
            OutputError: if the results are of matrices, or there is no pyvista.
            ValueError: if the phase is no number.
        """
        from fenics_nnm.face.grids import grid_of

        part = number("phase", phase)
        return grid_of(self._loaded.body("grid"), self._point, part, stress=stress)

    def plot_force(self, axes: Axes | None = None) -> Axes:
        """Draw the sum of the contact forces over one period.

        Args:
            axes: Where to draw; new ones of a new figure of pyplot if not given.

        Returns:
            The axes.
        """
        from fenics_nnm.face.plots import plot_force

        return plot_force(self.contact(4 * _INSTANTS), axes, repr(self))

    def plot_motion(self, axes: Axes | None = None, *, at: Place | None = None) -> Axes:
        """Draw the displacement of a node over one period, along x, y and z.

        Args:
            axes: Where to draw; new ones of a new figure of pyplot if not given.
            at: Place of the node, as for `motion`.

        Returns:
            The axes.

        Raises:
            OutputError, ValueError: as `motion`.
        """
        from fenics_nnm.face.plots import plot_motion

        return plot_motion(self.motion(None if at is None else [at], 4 * _INSTANTS), axes)
