"""Motions of a finished run on its mesh, from branch.h5 alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import h5py
import numpy as np

from fenics_nnm.arrays import Array, Indices, in_space
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.errors import NoBodyError, OutputError
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.motion import Motion, force_rates_at, forces_at, free_displacement
from fenics_nnm.mechanics.pairs import Pairs
from fenics_nnm.results import branch_file
from fenics_nnm.results.branch_file import BranchHeader

#: Two gamma ratios nearer than this are the same.
_SAME_RATIO = 1e-6

#: Nodes whose motion over a period is held in memory at once.
_NODES_AT_ONCE = 10_000


class PlacedMotion(Protocol):
    """A motion with its place among others."""

    @property
    def motion(self) -> Motion:
        """The motion."""

    @property
    def position(self) -> float:
        """Its place: no two have the same."""


@dataclass(frozen=True, slots=True)
class StoredState:
    """Static state under steady loads, about which a branch moves.

    Attributes:
        displacement: Displacement of the nodes in m, shape (n, dim).
        stress: Cauchy stress in Pa at the sampling points of the cells in VTK's order, shape
            (cells, s, 6).
        warming: Temperature of the nodes less that without stress in K, shape (n,); empty where it
            is the same everywhere.
    """

    displacement: Array
    stress: Array
    warming: Array = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, slots=True)
class StoredBranch:
    """A branch with the mesh and the shapes that its motions are made of.

    At any time u = shapes q - residual_shapes lambda.

    Attributes:
        header: What holds for all points; the reduced model is in it.
        points: Points by ascending energy.
        nodes: Places of the nodes in m, shape (n, 3).
        cells: Nodes of each cell in VTK's order, shape (cells, nodes a cell).
        cell_type: VTK's number of the cell type.
        shapes: Displacement per modal coordinate in kg^-1/2, shape (J, n, dim).
        residual_shapes: Displacement per contact force in m/N, shape (n_c, n, dim).
        bent_shapes: theta_ij of pairs of masters in 1/(kg m), shape (p, n, dim); none with linear
            kinematics.
        region: Number of the material of each cell, shape (cells,).
        elasticity: Stress in Pa per strain, shape (rows, 6, strains), as in `branch_file`.
        elasticity_row: Row of it at each sampling point of each cell, shape (cells, s).
        contact_points: Places of the contact points in m, shape (n_c, 3).
        contact_directions: Unit vectors towards the obstacle, shape (n_c, dim).
        contact_facets: Nodes of each contact facet in VTK's order, shape (facets, nodes a facet).
        facet_patch: Patch of each facet, shape (facets,).
        facet_side: 0 for facets of the patch, 1 for those opposite to it, shape (facets,).
        contact_patches: Patch of each contact point, shape (n_c,).
        contact_pressures: Node, contact point, and pressure in Pa there per N of the point's force:
            three rows.
        inertia: Harmonics of the displacement in m, shape (N + 1, n, dim), that full order adds at
            points, by their position.
        state: Static state under steady loads; None where there are none.
        driven: Whether its motions are driven by forces.
    """

    header: BranchHeader
    points: tuple[BranchPoint, ...]
    nodes: Array
    cells: Indices
    cell_type: int
    shapes: Array
    residual_shapes: Array
    bent_shapes: Array
    region: Indices
    elasticity: Array
    elasticity_row: Indices
    contact_points: Array
    contact_directions: Array
    contact_facets: Indices
    facet_patch: Indices
    facet_side: Indices
    contact_patches: Indices
    contact_pressures: Array
    inertia: Mapping[float, Array]
    state: StoredState | None = None
    driven: bool = False

    @property
    def series(self) -> Series:
        """Series in time that the points are written in."""
        return self.header.time_series

    @property
    def contact_nodes(self) -> Indices:
        """The node at each contact point, shape (n_c,)."""
        return np.array([self.node_at(place) for place in self.contact_points])

    @property
    def contact_axis(self) -> Array:
        """Unit vector along the mean contact direction; the span of a blade, shape (dim,)."""
        mean = np.mean(self.contact_directions, axis=0, keepdims=True)
        return (mean / np.linalg.norm(mean))[0]

    def node_at(self, place: Array | Sequence[float]) -> int:
        """The node nearest to a place (x, y, z) in m."""
        return int(np.argmin(np.linalg.norm(self.nodes - np.asarray(place), axis=1)))

    def point(self, gamma_ratio: float) -> BranchPoint:
        """The point at a gamma ratio.

        Raises:
            OutputError: if there is none.
        """
        nearest = min(
            self.points, key=lambda point: abs(point.gamma_ratio - gamma_ratio), default=None
        )
        if nearest is None or abs(nearest.gamma_ratio - gamma_ratio) > _SAME_RATIO:
            raise OutputError(
                f"no point at gamma ratio {gamma_ratio:g}: "
                "name it in continuation.report_at to have one"
            )
        return nearest

    def coordinates(self, point: PlacedMotion, phase: Array) -> Array:
        """Modal coordinates in kg^1/2 m at phases omega t, shape (len(phase), J)."""
        return self.series.basis_at(phase) @ point.motion.q

    def displacement(
        self, point: PlacedMotion, phase: Array, nodes: Indices | None = None
    ) -> Array:
        """Displacement in m.

        Args:
            point: Point of this branch.
            phase: Phases omega t.
            nodes: Nodes wanted; all of them if not given.

        Returns:
            Shape (len(phase), number of nodes, dim).
        """
        forces = forces_at(self.header.model, self.series, point.motion, phase)
        coordinates = self.coordinates(point, phase)
        field = self._field(coordinates, forces, nodes)
        field += _bent(self, coordinates, coordinates, nodes)
        return self._with_inertia(field, self.series.basis_at(phase), point, nodes)

    def velocity(self, point: PlacedMotion, phase: Array, nodes: Indices | None = None) -> Array:
        """Velocity in m/s, the time derivative of `displacement`, of the same shape."""
        rates = self.series.rate_at(phase) @ point.motion.q
        force_rates = force_rates_at(self.header.model, self.series, point.motion, phase)
        by_phase = self._field(rates, force_rates, nodes)
        by_phase += 2 * _bent(self, self.coordinates(point, phase), rates, nodes)
        by_phase = self._with_inertia(by_phase, self.series.rate_at(phase), point, nodes)
        return 2 * np.pi * point.motion.frequency * by_phase

    def gap(self, point: PlacedMotion, phase: Array) -> Array:
        """Distance in m of the contact points to their obstacle, shape (len(phase), n_c)."""
        model = self.header.model
        forces = forces_at(model, self.series, point.motion, phase)
        free = free_displacement(model, self.series, point.motion, phase)
        return model.gap - free + forces @ model.R

    def forces(self, point: PlacedMotion, phase: Array) -> Array:
        """Contact forces in N, shape (len(phase), n_c)."""
        return forces_at(self.header.model, self.series, point.motion, phase)

    def largest_displacement(self, point: PlacedMotion, instants: int = 48) -> Array:
        """Largest distance of each node from rest over the period in m, shape (n,)."""
        phase = 2 * np.pi * np.arange(instants) / instants
        parts = np.array_split(np.arange(len(self.nodes)), len(self.nodes) // _NODES_AT_ONCE + 1)
        fields = (self.displacement(point, phase, part) for part in parts)
        return np.concatenate([np.linalg.norm(field, axis=2).max(axis=0) for field in fields])

    def modal_field(self, coordinates: Array) -> Array:
        """Displacement in m of given modal coordinates (J,) without contact, shape (n, dim)."""
        return np.tensordot(coordinates, self.shapes, 1)

    def field(self, coordinates: Array, forces: Array) -> Array:
        """Displacement in m of modal coordinates (J,) and contact forces (n_c,), shape (n, dim)."""
        linear = self._field(coordinates, forces, None)
        return linear + _bent(self, coordinates, coordinates, None)

    def _field(self, coordinates: Array, forces: Array, nodes: Indices | None) -> Array:
        chosen = slice(None) if nodes is None else nodes
        modal = np.tensordot(coordinates, self.shapes[:, chosen], 1)
        return modal - np.tensordot(forces, self.residual_shapes[:, chosen], 1)

    def _with_inertia(
        self, field: Array, basis: Array, point: PlacedMotion, nodes: Indices | None
    ) -> Array:
        """A field with what full order adds to it, where that is stored."""
        inertia = self.inertia.get(point.position)
        if inertia is None:
            return field
        chosen = inertia if nodes is None else inertia[:, nodes]
        return field + np.tensordot(basis, chosen, 1)


def _bent(branch: StoredBranch, one: Array, other: Array, nodes: Indices | None) -> Array | float:
    """1/2 sum theta_ij x_i y_j of coordinates of shape (.., J); nothing without masters."""
    masters = branch.header.model.kinematics.masters
    if not len(masters):
        return 0.0
    factors = Pairs.of(len(masters)).products(one[..., masters], other[..., masters])
    chosen = slice(None) if nodes is None else nodes
    return np.tensordot(factors, branch.bent_shapes[:, chosen], 1)


def read_stored_branch(path: Path) -> StoredBranch:
    """Read a branch with its mesh and shapes.

    Shapes are mapped into memory: what is not used of them is not read, and what was used can be
    read again, so that they take no memory that others need.

    Raises:
        OutputError: if the file cannot be read, is of another kind, or has no mesh.
    """
    header, points = branch_file.read(path)
    return body_in(path, header, points)


def body_in(
    path: Path, header: BranchHeader, points: tuple[BranchPoint, ...] = (), *, driven: bool = False
) -> StoredBranch:
    """The mesh and the shapes in a file of results whose header was read.

    Raises:
        OutputError: if the file cannot be read, or has no mesh.
    """
    with branch_file.reading(path), h5py.File(path, "r") as file:
        if "mesh" not in file:
            raise NoBodyError(f"{path}: has no mesh to draw: it is of a study of [matrices]")
        _assert_rows(file, len(file["mesh/points"]), ("mesh/cells", "contact/facets"))
        _assert_rows(file, len(file["material/elasticity"]), ("material/row",))
        return StoredBranch(
            header=header,
            points=points,
            nodes=in_space(file["mesh/points"][:]),
            cells=file["mesh/cells"][:],
            cell_type=int(file["mesh/cell_type"][()]),
            shapes=_mapped(path, file["basis/shapes"]),
            residual_shapes=_mapped(path, file["basis/residual_shapes"]),
            bent_shapes=_bent_shapes(path, file["basis"]),
            region=file["mesh/region"][:],
            elasticity=file["material/elasticity"][:],
            elasticity_row=file["material/row"][:],
            contact_points=in_space(file["contact/points"][:]),
            contact_directions=file["contact/directions"][:],
            contact_facets=file["contact/facets"][:],
            facet_patch=file["contact/facet_patch"][:],
            facet_side=file["contact/facet_side"][:],
            contact_patches=file["contact/patches"][:],
            contact_pressures=file["contact/pressures"][:],
            inertia={
                float(values.attrs["position"]): _mapped(path, values)
                for values in file.get("inertia", {}).values()
            },
            state=_state(file),
            driven=driven,
        )


def _state(file: h5py.File) -> StoredState | None:
    if "state" not in file:
        return None
    state = file["state"]
    warming = state["warming"][:] if "warming" in state else np.empty(0)
    return StoredState(state["displacement"][:], state["stress"][:], warming)


def _assert_rows(file: h5py.File, count: int, names: Sequence[str]) -> None:
    """Refuse rows that are not there.

    Raises:
        IndexError: if there are some.
    """
    for name in names:
        rows = file[name][:]
        if rows.size and not 0 <= rows.min() <= rows.max() < count:
            raise IndexError(f"{name} has a row outside of 0 to {count - 1}")


def _bent_shapes(path: Path, basis: h5py.Group) -> Array:
    """Second-order shapes; none with linear kinematics."""
    return _mapped(path, basis["bent_shapes"]) if "bent_shapes" in basis else np.zeros((0, 0, 0))


def _mapped(path: Path, values: h5py.Dataset) -> Array:
    """A data set where it is in the file; in memory if it is not in one piece there."""
    offset = values.id.get_offset()
    if offset is None:
        return np.asarray(values[:])
    array = np.memmap(path, values.dtype, mode="r", offset=offset, shape=values.shape)
    return array.view(np.ndarray)
