"""The bridge between versions of dolfinx, 0.9 to 0.11: no other module knows that they differ.

What differs shows in the names that are there, not by the version: each name is looked for as
the newest dolfinx has it, then as older ones had it.
"""

from __future__ import annotations

from dolfinx.fem import CoordinateElement
from dolfinx.io import distribute_entity_data
from dolfinx.mesh import Geometry, Mesh

from fenics_nnm.arrays import Indices
from fenics_nnm.fem import jit

try:
    from dolfinx.io import gmsh as _gmsh
except ImportError:  # 0.9
    from dolfinx.io import gmshio as _gmsh

__all__ = [
    "cell_nodes",
    "cell_permutation",
    "coordinate_element",
    "distribute_entity_data",
    "ufl_mesh",
]

jit.make_safe()  # this module is imported before any form is made

cell_permutation = _gmsh.cell_perm_array
ufl_mesh = _gmsh.ufl_mesh

#: Whether a mesh has a list of coordinate elements, one for each type of cell (0.11).
_LISTED = hasattr(Geometry, "cmaps")


def coordinate_element(mesh: Mesh) -> CoordinateElement:
    """The element that maps the cells of a mesh of one cell type."""
    return mesh.geometry.cmaps[0] if _LISTED else mesh.geometry.cmap


def cell_nodes(mesh: Mesh) -> Indices:
    """Local nodes of the local cells of a mesh of one cell type, shape (cells, nodes a cell)."""
    return mesh.geometry.dofmaps[0] if _LISTED else mesh.geometry.dofmap
