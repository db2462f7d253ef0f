"""The mesh that a stored run was solved on, so that `--resume` needs neither its file nor gmsh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import h5py

from fenics_nnm.fem.blocks import KEPT_MESH
from fenics_nnm.fem.kept_mesh import mesh_as_read
from fenics_nnm.fem.other_files import names_others
from fenics_nnm.fem.raw_mesh import RawMesh, raw_of
from fenics_nnm.files.bounds import assert_fits
from fenics_nnm.results import branch_file
from fenics_nnm.results.branch_file import BranchHeader

#: Keys of a study whose files the mesh is made of begin so.
_OF_MESH = "mesh."


@dataclass(frozen=True, slots=True)
class KeptMesh:
    """The mesh in a branch.h5.

    Attributes:
        path: The branch.h5.
        digest: Digest of the mesh.
        metres: Metres in one unit of its coordinates.
    """

    path: Path
    digest: str
    metres: float

    def read(self) -> RawMesh:
        """The mesh.

        Raises:
            OutputError: if the file is damaged.
        """
        return _read(self.path)[0]


def kept_mesh(
    path: Path, header: BranchHeader, inputs: Mapping[str, str], files: Mapping[str, Path]
) -> KeptMesh | None:
    """The mesh of a stored run, if it is that of a study.

    It is not where a file that it is made of has changed, or may have: then the mesh is made anew.
    Files that are gone have not changed.

    Args:
        path: Its branch.h5.
        header: What it holds besides its points.
        inputs: Digests of the files that the study names now, by key.
        files: These files.

    Raises:
        OutputError: if branch.h5 is damaged.
    """
    there = {key: digest for key, digest in inputs.items() if key.startswith(_OF_MESH)}
    if any(header.inputs.get(key) != digest for key, digest in there.items()):
        return None
    if any(names_others(files[key]) for key in there):
        return None
    with branch_file.reading(path), h5py.File(path, "r") as file:
        if KEPT_MESH not in file:
            return None
    raw, metres = _read(path)
    return KeptMesh(path, mesh_as_read(raw, metres).digest, metres)


def _read(path: Path) -> tuple[RawMesh, float]:
    """The mesh of a branch.h5 whose seal was looked at, and metres in one unit of it."""
    with branch_file.reading(path), h5py.File(path, "r") as file:
        group = file[KEPT_MESH]
        for name, values in group.items():
            assert_fits(values.nbytes, name)
        return raw_of(group), float(group["metres"][0])
