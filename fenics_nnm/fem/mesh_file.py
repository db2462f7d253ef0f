"""Which reader is for which file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.given_file import MSH_ENDINGS, PrivateFolder
from fenics_nnm.fem.msh_text import fault_of_msh
from fenics_nnm.fem.native_errors import FileErrors
from fenics_nnm.fem.raw_mesh import RawMesh

#: Files that gmsh reads with their named groups; it keeps the groups of .unv, which meshio lacks.
_GMSH = (*MSH_ENDINGS, ".unv")

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
            .nas, .fem), or a file that meshio reads, such as .med, .vtu, .vtk or .xdmf.
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

    def __call__(self, folder: Path) -> RawMesh:
        """Read it.

        Raises:
            MeshError: if the file cannot be used; the message says why.
        """
        from fenics_nnm.fem.gmsh_mesh import extracted, gmsh_session, open_mesh

        name = str(self.path)
        with gmsh_session(name, talks=True):
            if self.path.suffix.lower() in _GMSH:
                open_mesh(self.path, PrivateFolder(folder).given(self.path), self.fault)
                return extracted(name)
            return _read_foreign(self.path)


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
    from fenics_nnm.fem.abaqus_mesh import read_abaqus
    from fenics_nnm.fem.foreign_mesh import ForeignMesh, raw_mesh
    from fenics_nnm.fem.nastran_mesh import read_nastran

    readers: dict[str, Callable[[Path], ForeignMesh]] = {
        ".inp": read_abaqus,
        ".bdf": read_nastran,
        ".nas": read_nastran,
        ".fem": read_nastran,
    }
    suffix = path.suffix.lower()
    _check_whole(path)
    if suffix in readers:
        return raw_mesh(str(path), readers[suffix](path))
    from fenics_nnm.fem.meshio_mesh import read_meshio

    return raw_mesh(str(path), read_meshio(path))
