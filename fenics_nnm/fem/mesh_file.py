"""Which reader is for which file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.cached_mesh import contents
from fenics_nnm.fem.given_file import MSH_ENDINGS, PrivateFolder
from fenics_nnm.fem.msh_text import fault_of_msh
from fenics_nnm.fem.native_errors import FileErrors
from fenics_nnm.fem.raw_mesh import RawMesh

if TYPE_CHECKING:
    from fenics_nnm.fem.foreign_mesh import ForeignMesh

#: Files that gmsh reads with their named groups; it keeps the groups of .unv, which meshio lacks.
_GMSH = (*MSH_ENDINGS, ".unv")

#: Files that hold all of a mesh unless they name others; .med is refused if it does.
_ALONE = (*_GMSH, ".inp", ".bdf", ".nas", ".fem", ".vtk", ".vtu", ".med")

#: Seconds that reading may take, and per byte of the file.
_SECONDS, _SECONDS_A_BYTE = 60.0, 1e-5


def assert_file(path: Path) -> None:
    """Refuse what is no file.

    Raises:
        MeshError: if it is not.
    """
    if not path.is_file():
        what = "is not a file" if path.exists() else "there is no such file"
        raise MeshError(f"mesh file {path}: {what}", code=Code.MESH_FILE)


def seconds_to_read(path: Path) -> float:
    """How long the reading of a file may take."""
    return _SECONDS + _SECONDS_A_BYTE * path.stat().st_size


@dataclass(frozen=True, slots=True)
class ReadMesh:
    """The job of reading a mesh with its named groups.

    Attributes:
        path: A .msh or .unv file, an .inp file of Abaqus or CalculiX, Nastran bulk data (.bdf,
            .dat, .nas, .fem), an archive of Ansys (.cdb, .dat), a file of VTK (.vtu, .vtk), or one
            that meshio reads, such as .med or .xdmf.
    """

    path: Path

    @property
    def errors(self) -> FileErrors:
        """Errors of the file."""
        return FileErrors(self.path)

    @property
    def advice(self) -> str:
        """What to try."""
        return "the file may be damaged: write it again, or in another format"

    def fault(self) -> str:
        """What is wrong with the file as far as can be seen without gmsh."""
        return fault_of_msh(self.path) if self.path.suffix.lower() in MSH_ENDINGS else ""

    @property
    def trusted(self) -> bool:
        """A mesh needs no more than to be read."""
        return False

    def identity(self) -> str:
        """As `cached_mesh.Identified`, of files that are known to stand alone."""
        if self.path.suffix.lower() not in _ALONE:
            return ""
        return contents(self.path)

    def __call__(self, folder: Path) -> RawMesh:
        """Read it.

        Raises:
            MeshError: if the file cannot be used; the message says why.
        """
        from fenics_nnm.fem.file_kinds import assert_kind
        from fenics_nnm.fem.gmsh_foreign import raw_of_model
        from fenics_nnm.fem.gmsh_mesh import gmsh_session, open_mesh

        name = str(self.path)
        assert_kind(self.path)
        _check_ended(self.path)
        with gmsh_session(name, talks=True):
            if self.path.suffix.lower() in _GMSH:
                open_mesh(self.path, PrivateFolder(folder).given(self.path), self.fault)
                return raw_of_model(name)
            return _read_foreign(self.path)


def _check_ended(path: Path) -> None:
    """Refuse a universal file that ends within a dataset: gmsh would read the elements before."""
    if path.suffix.lower() != ".unv":
        return
    with path.open("rb") as file:
        marks = sum(line.strip() == b"-1" for line in file)
    if marks % 2:
        raise MeshError(
            f"mesh file {path}: ends within a dataset: each must stand between two lines -1: "
            "the file may be cut off",
            code=Code.MESH_FILE,
        )


def _check_whole(path: Path) -> None:
    """Refuse an HDF5 file, such as .med, that takes data from other files."""
    import h5py

    from fenics_nnm.files.bounds import UnsafeFileError, check_hdf5

    if h5py.is_hdf5(path):
        try:
            check_hdf5(path)
        except UnsafeFileError as error:
            raise MeshError(f"mesh file {path}: {error}", code=Code.MESH_FILE) from error


def _read_foreign(path: Path) -> RawMesh:
    """Read a mesh of another program; all without a reader of our own are read by meshio."""
    from fenics_nnm.fem.foreign_body import one_body
    from fenics_nnm.fem.foreign_mesh import raw_mesh

    _check_whole(path)
    return raw_mesh(str(path), one_body(str(path), _reader(path)(path)))


def _reader(path: Path) -> Callable[[Path], ForeignMesh]:
    """The reader of a file of another program, by its ending and, where two share it, content."""
    from fenics_nnm.fem.abaqus_mesh import read_abaqus
    from fenics_nnm.fem.ansys_mesh import read_ansys
    from fenics_nnm.fem.file_kinds import sign_of
    from fenics_nnm.fem.meshio_mesh import read_meshio
    from fenics_nnm.fem.nastran_mesh import read_nastran
    from fenics_nnm.fem.vtk_legacy import read_vtk
    from fenics_nnm.fem.vtu_file import read_vtu

    readers: dict[str, Callable[[Path], ForeignMesh]] = {
        ".vtu": read_vtu,
        ".vtk": read_vtk,
        ".bdf": read_nastran,
        ".cdb": read_ansys,
        ".nas": read_nastran,
        ".fem": read_nastran,
    }
    shared: dict[str, Callable[[Path], ForeignMesh]] = {".inp": read_abaqus, ".dat": read_nastran}
    suffix = path.suffix.lower()
    if suffix in shared:
        return read_ansys if "Ansys" in sign_of(path)[0] else shared[suffix]
    return readers.get(suffix, read_meshio)
