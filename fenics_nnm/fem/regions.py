"""Parts of a body, each with its material."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.compat import cell_nodes
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.fem.stress import Expr, assert_off_axis
from fenics_nnm.materials.material import Material


@dataclass(frozen=True, slots=True)
class Region:
    """A material and the groups of cells that are of it.

    Attributes:
        material: Material.
        groups: Names of groups of cells; empty for all cells of the mesh.
    """

    material: Material
    groups: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Regions:
    """Regions on a mesh, one for each cell.

    Attributes:
        mesh: Mesh.
        parts: Material and local cells, ghosts included, of each region.
    """

    mesh: dmesh.Mesh
    parts: tuple[tuple[Material, Indices], ...]

    def integral(
        self, integrand: Callable[[Material], Expr], degree: int, quadrature: int | None = None
    ) -> Expr:
        """Sum of integrals over the regions of what a function gives for their materials.

        Args:
            integrand: From a material to the integrand.
            degree: Polynomial degree of the displacement.
            quadrature: Degree of polynomials that are integrated exactly; by default what UFL
                finds, which is too much for products of many factors in hexahedra.
        """
        dx = ufl.Measure("dx", domain=self.mesh)
        if len(self.parts) > 1:
            dx = ufl.Measure("dx", domain=self.mesh, subdomain_data=self._tags())
        terms = []
        for number, (material, _) in enumerate(self.parts):
            part = dx(number) if len(self.parts) > 1 else dx
            if quadrature is not None:
                part = part(degree=quadrature)
            elif material.turns:
                # turned axes are no polynomials: UFL's own guess of their degree is far too high
                part = part(degree=2 * degree + 2)
            terms.append(integrand(material) * part)
        return sum(terms[1:], terms[0])

    def piecewise(self, value: Callable[[Material], Expr]) -> Expr:
        """What a function gives for the material of each cell, as one expression."""
        if len(self.parts) == 1:
            return value(self.parts[0][0])
        space = fem.functionspace(self.mesh, ("DG", 0))
        terms = []
        for material, cells in self.parts:
            inside = fem.Function(space)
            inside.x.array[space.dofmap.list[cells, 0]] = 1.0
            terms.append(inside * value(material))
        return sum(terms[1:], terms[0])

    def _tags(self) -> dmesh.MeshTags:
        cells = np.concatenate([cells for _, cells in self.parts])
        numbers = np.repeat(np.arange(len(self.parts)), [len(cells) for _, cells in self.parts])
        order = np.argsort(cells)
        return dmesh.meshtags(
            self.mesh, self.mesh.topology.dim, cells[order], numbers[order].astype(np.int32)
        )


def regions_on(tagged: TaggedMesh, regions: tuple[Region, ...]) -> Regions:
    """Find the cells of each region.

    Raises:
        MeshError: if a group is unknown, or a cell has no material or more than one.
        ModelError: if cylindrical material axes are not defined somewhere.
    """
    index_map = tagged.mesh.topology.index_map(tagged.dim)
    owned = index_map.size_local
    cells = [_cells(tagged, region, owned + index_map.num_ghosts) for region in regions]
    times = np.bincount(np.concatenate(cells), minlength=owned)[:owned]
    without, several = (
        int(tagged.mesh.comm.allreduce(int(np.count_nonzero(wrong))))
        for wrong in (times == 0, times > 1)
    )
    if without or several:
        raise MeshError(
            f"cells of materials: {without} cells have no material and {several} have more than "
            f"one: every cell must have exactly one; groups of cells: {_known(tagged)}",
            code=Code.CELLS_OF_MATERIALS,
        )
    corners = cell_nodes(tagged.mesh)
    for region, own in zip(regions, cells, strict=True):
        assert_off_axis(region.material, tagged.mesh.geometry.x[np.unique(corners[own])])
    parts = zip((region.material for region in regions), cells, strict=True)
    return Regions(tagged.mesh, tuple(parts))


def _cells(tagged: TaggedMesh, region: Region, count: int) -> Indices:
    for name in region.groups:
        if name not in tagged.cells:
            raise MeshError(
                f'cells of materials = "{name}": the mesh has no such group of cells; it has '
                f"{_known(tagged)}",
                code=Code.CELLS_OF_MATERIALS,
            )
    if not region.groups:
        return np.arange(count, dtype=np.int32)
    return np.unique(np.concatenate([tagged.cells[name] for name in region.groups]))


def _known(tagged: TaggedMesh) -> str:
    return ", ".join(f'"{name}"' for name in sorted(tagged.cells)) or "none"
