"""The body of a branch at one instant, as a grid of pyvista.

pyvista draws the pictures of bodies, too. Its grids are VTK's own, which meshio's are not: they are
cut, warped and drawn as they are.
"""

from __future__ import annotations

from typing import Any

from fenics_nnm.errors import OutputError
from fenics_nnm.fields.instant import instant
from fenics_nnm.results.stored_branch import PlacedMotion, StoredBranch


def grid_of(body: StoredBranch, point: PlacedMotion, phase: float, *, stress: bool) -> Any:
    """The body at one instant as a `pyvista.UnstructuredGrid`.

    Args:
        body: Branch on its mesh.
        point: Point of it.
        phase: The instant as a part of the period.
        stress: Whether to add the von Mises stress.

    Raises:
        OutputError: if there is no pyvista.
    """
    try:
        import pyvista
    except ImportError as error:
        raise OutputError(f"grid: needs pyvista, which cannot be imported: {error}") from error
    shown = instant(body, point, phase, stress=stress)
    grid = pyvista.UnstructuredGrid({shown.mesh.cell.written: shown.mesh.cells}, shown.mesh.nodes)
    for name, values in shown.fields.items():
        grid.point_data[name] = values
    return grid
