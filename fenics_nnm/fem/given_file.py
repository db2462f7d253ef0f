"""What gmsh gets of a file: under a plain name in a private folder, and checked before.

gmsh takes a .msh that does not begin as one for a script and runs it, and it runs `NAME.opt`, if
there is one, whenever it reads NAME. In a private folder there is none.
"""

from __future__ import annotations

import itertools
import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from fenics_nnm.errors import Code, MeshError
from fenics_nnm.fem.geo_script import plain_script

#: Bytes of a .msh that are looked at for its beginning.
_HEAD = 1_000_000

#: Endings of meshes of gmsh.
MSH_ENDINGS = (".msh", ".msh2", ".msh4")

#: What may stand before a mesh of gmsh: a byte order mark, white space and comments.
_BEFORE = re.compile(rb"(?:\xef\xbb\xbf)?(?:\s+|\$Comments\b.*?\$EndComments\b)*", re.DOTALL)


@dataclass(frozen=True, slots=True)
class PrivateFolder:
    """A folder from which gmsh reads.

    Attributes:
        path: The folder, which nobody else writes to.
        numbers: Numbers of the files to come.
    """

    path: Path
    numbers: Iterator[int] = field(default_factory=itertools.count)

    def given(self, path: Path) -> Path:
        """The path under which gmsh gets a file.

        Raises:
            MeshError: if the file is not what its ending says, or is a script that does more than
                to build a geometry.
        """
        suffix = path.suffix.lower()
        if suffix in MSH_ENDINGS:
            return self._mesh(path)
        if suffix == ".geo":
            target = self._name(".geo")
            target.write_text(plain_script(path, self.given), "latin-1")
            return target
        return self._linked(path, suffix)

    def trusted(self, path: Path) -> Path:
        """The path under which gmsh gets a script as it is, that may do all; not its .opt file."""
        quote = '"' if '"' not in str(path) else "'"
        if quote in str(path):
            raise MeshError(
                f"mesh file {path}: must not have both kinds of quotes in its name",
                code=Code.MESH_FILE,
            )
        target = self._name(".geo")
        target.write_text(f"Include {quote}{path.resolve()}{quote};\n")
        return target

    def _mesh(self, path: Path) -> Path:
        with path.open("rb") as file:
            head = file.read(_HEAD)
        found = _BEFORE.match(head)
        start = found.end() if found else 0
        if not head.startswith(b"$MeshFormat", start):
            raise _not_a_mesh(path, head[start : start + 20])
        if start == 0:
            return self._linked(path, ".msh")
        target = self._name(".msh")
        with path.open("rb") as file, target.open("wb") as copy:
            file.seek(start)
            shutil.copyfileobj(file, copy)
        return target

    def _linked(self, path: Path, suffix: str) -> Path:
        target = self._name(suffix)
        target.symlink_to(path.resolve())
        return target

    def _name(self, suffix: str) -> Path:
        return self.path / f"file{next(self.numbers)}{suffix}"


def _not_a_mesh(path: Path, head: bytes) -> MeshError:
    """Why a file is no mesh of gmsh."""
    if head.startswith(b"$NOD"):
        return MeshError(
            f"mesh file {path}: is a mesh of gmsh's format 1: must be of format 2.2 or 4.1 "
            "(gmsh FILE -save -format msh41)",
            code=Code.MESH_FILE,
        )
    if not head:
        return MeshError(f"mesh file {path}: holds no mesh: is empty", code=Code.MESH_FILE)
    return MeshError(
        f"mesh file {path}: gmsh cannot read it: is neither a mesh nor text of one: must begin "
        "with $MeshFormat; a script of gmsh must end in .geo",
        code=Code.MESH_FILE,
    )
