"""What a mesh file is by its first bytes, where its ending says something else."""

from __future__ import annotations

import re
from pathlib import Path

from fenics_nnm.errors import Code, MeshError

#: Bytes of a file that are looked at.
_HEAD = 20_000

#: Formats by what their files hold near the beginning: words for messages, and right endings.
_SIGNS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    (r"\A\s*\$MeshFormat", "a mesh of gmsh", (".msh", ".msh2", ".msh4")),
    (r"\A(<\?xml[^>]*>\s*)?<VTKFile", "a file of VTK in XML", (".vtu",)),
    (r"\A# vtk DataFile", "a legacy file of VTK", (".vtk",)),
    (r"\AISO-10303-21", "a STEP file", (".step", ".stp")),
    (r"\A(<\?xml[^>]*>\s*)?(<!DOCTYPE[^>]*>\s*)?<Xdmf", "a file of XDMF", (".xdmf", ".xmf")),
    (r"(?im)^\s*(/PREP7|NBLOCK\s*,)", "a file of Ansys", (".cdb", ".dat", ".inp")),
    (r"(?im)^\*NODE\s*($|,)", "a file of Abaqus or CalculiX", (".inp",)),
    (
        r"(?im)^(BEGIN\s+BULK|GRID\*?[\s,]+\d)",
        "a file of Nastran",
        (".bdf", ".dat", ".nas", ".fem"),
    ),
    (r"(?m)\A\s+-1\s*\n\s+\d+\s*$", "a universal file", (".unv",)),
    (r"\A\s*solid\b[^\n]*\n\s*facet", "a surface of STL", (".stl",)),
)

#: Endings of files that are read, as messages list them.
_READ = (
    ".msh, .unv (gmsh), .inp (Abaqus, CalculiX), .bdf, .dat, .nas, .fem (Nastran), .cdb, .dat "
    "(Ansys), .med (Salome), .vtu, .vtk (VTK), .xdmf and others of meshio; and geometries .step, "
    ".iges, .brep, .geo"
)

#: Endings of files of surfaces.
_SURFACES = (".stl", ".obj", ".ply", ".off", ".vtp", ".wrl", ".3mf")


def sign_of(path: Path) -> tuple[str, tuple[str, ...]]:
    """What a file is by its content, and the endings of such files; "" if that is not seen.

    Raises:
        MeshError: if it cannot be read.
    """
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD).decode("latin-1").removeprefix("\xef\xbb\xbf")
    except OSError as error:
        raise MeshError(
            f"mesh file {path}: cannot be read: {error.strerror}", code=Code.MESH_FILE
        ) from error
    for pattern, what, endings in _SIGNS:
        if re.search(pattern, head):
            return what, endings
    return "", ()


def not_read(path: Path, reason: str) -> MeshError:
    """The error for a file that no reader takes."""
    return MeshError(
        f"mesh file {path}: meshio cannot read it: {reason}; files that are read: {_READ}",
        code=Code.MESH_FILE,
    )


def assert_kind(path: Path) -> None:
    """Refuse a surface, and a file that is not what its ending says.

    Raises:
        MeshError: with what it is.
    """
    suffix = path.suffix.lower()
    what, endings = sign_of(path)
    if suffix in _SURFACES or ".stl" in endings:
        raise MeshError(
            f"mesh file {path}: is a surface without volume: must be a mesh of solid elements, "
            "or a geometry (.step) to be meshed here",
            code=Code.MESH_FILE,
        )
    if endings and suffix not in endings:
        raise MeshError(
            f"mesh file {path}: is {what} by its content: its name must end in "
            f"{' or '.join(endings)}",
            code=Code.MESH_FILE,
        )
