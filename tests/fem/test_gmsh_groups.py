"""Files of gmsh without groups, with groups that overlap, and with cells of several kinds."""

from __future__ import annotations

from pathlib import Path

import gmsh
import numpy as np
import pytest
from mpi4py import MPI
from small_meshes import saved_model

from fenics_nnm.fem.compat import cell_nodes
from fenics_nnm.fem.mesh import TaggedMesh, read_mesh


def counts(tagged: TaggedMesh) -> dict[str, int]:
    return {name: len(cells) for name, cells in tagged.cells.items()}


def volume(tagged: TaggedMesh) -> float:
    """Of straight tetrahedra."""
    corners = tagged.mesh.geometry.x[cell_nodes(tagged.mesh)[:, :4]]
    return float(np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 6)


def box(path: Path, *groups: str, version: float = 4.1, order: int = 1) -> None:
    with saved_model(path):
        gmsh.model.occ.addBox(0, 0, 0, 1, 0.5, 0.25)
        gmsh.model.occ.synchronize()
        for group in groups:
            gmsh.model.addPhysicalGroup(3, [1], name=group)
        if groups:
            gmsh.model.addPhysicalGroup(2, [1], name="left")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.25)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_body_of_a_file_without_groups_is_all_of_its_cells(version: float, tmp_path: Path) -> None:
    box(tmp_path / "a.msh", version=version)
    box(tmp_path / "b.msh", "body")
    found, named = (read_mesh(tmp_path / f"{n}.msh", "m", MPI.COMM_SELF) for n in "ab")
    assert counts(found) == counts(named) and volume(found) == pytest.approx(0.125)
    assert not found.facets and not found.notes


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("version", [2.2, 4.1])
def test_groups_that_overlap(version: float, order: int, tmp_path: Path) -> None:
    """Format 2.2 lists a cell once for each of its groups."""
    box(tmp_path / "a.msh", "body", "steel", version=version, order=order)
    tagged = read_mesh(tmp_path / "a.msh", "m", MPI.COMM_SELF)
    sizes = counts(tagged)
    assert sizes["body"] == sizes["steel"] == tagged.mesh.topology.index_map(3).size_local
    assert volume(tagged) == pytest.approx(0.125) and len(tagged.facets["left"])


@pytest.mark.parametrize("order", [1, 2])
def test_prisms_of_gmsh_are_split(order: int, tmp_path: Path) -> None:
    """Complete prisms of 18 nodes too; a box of hexahedra beside them."""
    with saved_model(tmp_path / "a.msh"):
        geo = gmsh.model.occ
        geo.addRectangle(0, 0, 0, 1, 1)
        geo.addRectangle(1, 0, 0, 1, 1)
        geo.fragment([(2, 1)], [(2, 2)])
        geo.synchronize()
        gmsh.model.mesh.setTransfiniteAutomatic(recombine=False)
        gmsh.model.mesh.setRecombine(2, 1)
        made = geo.extrude([(2, 1), (2, 2)], 0, 0, 0.5, numElements=[2], recombine=True)
        geo.synchronize()
        gmsh.model.addPhysicalGroup(3, [tag for dim, tag in made if dim == 3], name="all")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
    tagged = read_mesh(tmp_path / "a.msh", "m", MPI.COMM_SELF)
    assert volume(tagged) == pytest.approx(1.0)
    assert "hexahedra" in tagged.notes[-1] and "prisms are split into" in tagged.notes[-1]
    assert set(counts(tagged)) == {"all", "body"}
