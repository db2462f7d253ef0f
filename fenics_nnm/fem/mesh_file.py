"""Which reader is for which file."""

from __future__ import annotations

from pathlib import Path

from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.abaqus_mesh import read_abaqus
from fenics_nnm.fem.ansys_mesh import read_ansys
from fenics_nnm.fem.file_kinds import assert_kind, sign_of
from fenics_nnm.fem.foreign_body import one_body
from fenics_nnm.fem.foreign_mesh import raw_mesh
from fenics_nnm.fem.gmsh_foreign import raw_of_model
from fenics_nnm.fem.gmsh_mesh import gmsh_session, open_mesh
from fenics_nnm.fem.meshio_mesh import read_meshio
from fenics_nnm.fem.nastran_mesh import read_nastran
from fenics_nnm.fem.raw_mesh import RawMesh
from fenics_nnm.fem.vtk_legacy import read_vtk
from fenics_nnm.fem.vtu_file import read_vtu

#: Files that gmsh reads with their named groups; it keeps the groups of .unv, which meshio lacks.
_GMSH = (".msh", ".msh2", ".msh4", ".unv")

#: Readers of our own; all other files are read by meshio.
_READERS = {
    ".vtu": read_vtu,
    ".vtk": read_vtk,
    ".bdf": read_nastran,
    ".cdb": read_ansys,
    ".nas": read_nastran,
    ".fem": read_nastran,
}


#: Readers of endings that Ansys has too.
_SHARED = {".inp": read_abaqus, ".dat": read_nastran}


def read_raw(path: Path) -> RawMesh:
    """Read a mesh with its named groups.

    Args:
        path: A .msh or .unv file, an .inp file of Abaqus or CalculiX, Nastran bulk data (.bdf,
            .dat, .nas, .fem), an archive of Ansys (.cdb, .dat), a file of VTK (.vtu, .vtk), or one
            that meshio reads, such as .med or .xdmf.

    Raises:
        MeshError: if the file cannot be used; the message says why.
    """
    if not path.is_file():
        what = "is not a file" if path.exists() else "there is no such file"
        raise MeshError(f"mesh file {path}: {what}", code=Code.MESH_FILE)
    suffix = path.suffix.lower()
    assert_kind(path)
    with gmsh_session(str(path)):
        if suffix in _GMSH:
            open_mesh(path)
            return raw_of_model(str(path))
        reader = _READERS.get(suffix, read_meshio)
        if suffix in _SHARED:
            reader = read_ansys if "Ansys" in sign_of(path)[0] else _SHARED[suffix]
        foreign = reader(path)
        return raw_mesh(str(path), one_body(str(path), foreign))
