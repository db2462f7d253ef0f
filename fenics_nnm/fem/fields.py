"""From reduced coordinates back to fields on the mesh, written for ParaView."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from dolfinx import fem
from dolfinx.io import VTKFile
from dolfinx.plot import vtk_mesh
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.errors import OutputError
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.vertices import at_vertices
from fenics_nnm.nonlinear.forces import contact_forces
from fenics_nnm.nonlinear.fourier import Series
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.reduction.model import ReducedModel

#: Modes written to linear_modes.pvd.
_MODES_WRITTEN = 12


def write_linear_modes(path: Path, analysis: LinearAnalysis) -> None:
    """Write the lowest mode shapes, one array a mode with its frequency in the name.

    Each shape is scaled to a largest displacement component of 1.
    """
    functions = []
    for number in range(min(_MODES_WRITTEN, analysis.modes.shapes.shape[1])):
        hertz = analysis.modes.frequencies[number]
        function = _function(analysis.solid, f"mode {number + 1} ({hertz:.6g} Hz)")
        shape = analysis.modes.shapes[:, number]
        largest = analysis.solid.tagged.mesh.comm.allreduce(
            np.abs(shape).max(initial=0.0), op=MPI.MAX
        )
        _fill(function, shape / largest)
        functions.append(function)
    with _vtk_file(analysis.solid, path) as file:
        file.write_function(functions, 0.0)


def write_motion(
    path: Path,
    analysis: LinearAnalysis,
    point: BranchPoint,
    *,
    model: ReducedModel,
    series: Series,
    frames: int,
    added: Array | None = None,
    on_frame: Callable[[float], None] = lambda done: None,
) -> None:
    """Write one period of a motion; the time of a frame is its part of the period.

    Args:
        path: .pvd file to write.
        analysis: Linear analysis that the motion belongs to.
        point: Point of a branch of its model.
        model: Model that the motion obeys.
        series: Series in time that the point is written in.
        added: Harmonics of a displacement in m that the model does not have, (N + 1, n_owned): the
            inertia of the residual shapes, at full order.
        frames: Number of frames, the last of them one step before the period ends.
        on_frame: Called with the part done.
    """
    solid = analysis.solid
    displacement = _function(solid, "displacement (m)")
    pressure = _Pressure(solid, analysis.interface)
    phase = 2 * np.pi * np.arange(frames) / frames
    basis = series.basis_at(phase)
    coordinates = basis @ point.q
    forces = contact_forces(model, series, point, phase)
    with _vtk_file(solid, path) as file:
        for frame in range(frames):
            field = analysis.reduction.displacement(coordinates[frame], forces[frame])
            _fill(displacement, field if added is None else field + basis[frame] @ added)
            pressure.fill(forces[frame])
            file.write_function([displacement, pressure.function], frame / frames)
            on_frame((frame + 1) / frames)


def gathered_basis(analysis: LinearAnalysis) -> dict[str, Array]:
    """Nodes, cells, shapes and residual shapes on rank 0, as stored in branch.h5; else empty."""
    solid = analysis.solid
    comm, space = solid.tagged.mesh.comm, solid.space
    dim = solid.tagged.dim
    cells, types, points = vtk_mesh(space)
    index_map = space.dofmap.index_map
    width = int(cells[0]) + 1 if len(cells) else 1
    local = cells.reshape(-1, width)[:, 1:].astype(np.int64) if len(cells) else np.empty((0, 1))
    numbered = index_map.local_to_global(local.ravel().astype(np.int32)).reshape(local.shape)
    owned = index_map.size_local
    parts = {
        "mesh/points": points[:owned],
        "mesh/cells": numbered,
        "basis/shapes": analysis.reduction.shapes.reshape(owned, dim, -1),
        "basis/residual_shapes": analysis.reduction.residual_shapes.reshape(owned, dim, -1),
    }
    gathered = {}
    for name, part in parts.items():
        everywhere = comm.gather(part, root=0)
        if comm.rank == 0:
            whole = np.concatenate([piece for piece in everywhere if len(piece)])
            gathered[name] = np.moveaxis(whole, -1, 0) if name.startswith("basis") else whole
    if comm.rank == 0:
        gathered["mesh/cell_type"] = np.array(int(types[0]))
    return gathered


@contextmanager
def _vtk_file(solid: Solid, path: Path) -> Iterator[VTKFile]:
    """Frames in a folder named like the .pvd file, which lists them by their relative paths."""
    comm = solid.tagged.mesh.comm
    frames = path.with_suffix("")
    on_root(comm, frames.mkdir)
    try:
        with VTKFile(comm, frames / "frame.pvd", "w") as file:
            yield file
    except RuntimeError as error:
        raise OutputError(f"{frames}: cannot be written: {error}") from error
    on_root(comm, lambda: _list_frames(path, frames))


def _list_frames(path: Path, frames: Path) -> None:
    for file in frames.iterdir():
        if not file.read_bytes().rstrip().endswith(b"</VTKFile>"):  # dolfinx does not tell
            raise OutputError(f"{file}: cannot be written in full: is the disk full?")
    listing = (frames / "frame.pvd").read_text()
    path.write_text(listing.replace('file="', f'file="{frames.name}/'))


def _function(solid: Solid, name: str) -> fem.Function:
    return fem.Function(solid.space, name=name)


def _fill(function: fem.Function, owned: Array) -> None:
    function.x.array[: len(owned)] = owned
    function.x.scatter_forward()


class _Pressure:
    """Contact pressure: force over tributary area at the vertices of the patches."""

    def __init__(self, solid: Solid, interface: ContactInterface) -> None:
        mesh = solid.tagged.mesh
        space = fem.functionspace(mesh, ("Lagrange", solid.body.degree))
        self._linear = fem.Function(fem.functionspace(mesh, ("Lagrange", 1)))
        self._blocks = at_vertices(mesh, self._linear.function_space.dofmap.list)
        self._interface = interface
        self.function = fem.Function(space, name="contact pressure (Pa)")

    def fill(self, force: Array) -> None:
        """Set the pressure of contact forces of shape (n_c,); linear between the vertices."""
        values = self._interface.pressures @ force
        self._linear.x.array[self._blocks[: len(values)]] = values
        self._linear.x.scatter_forward()
        self.function.interpolate(self._linear)
