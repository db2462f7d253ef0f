"""The dolfinx version bridge: the only place that knows that names have moved."""

from __future__ import annotations

try:
    from dolfinx.io import gmshio
except ImportError:  # renamed in dolfinx 0.10
    from dolfinx.io import gmsh as gmshio
from dolfinx.io import distribute_entity_data

cell_permutation = gmshio.cell_perm_array
ufl_mesh = gmshio.ufl_mesh

__all__ = ["cell_permutation", "distribute_entity_data", "ufl_mesh"]
