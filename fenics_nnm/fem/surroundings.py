"""What every computation depends on besides its input: this program and the libraries below it."""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from importlib import metadata
from pathlib import Path

import dolfinx
from petsc4py import PETSc
from slepc4py import SLEPc

import fenics_nnm
from fenics_nnm.files.cache import key_of

#: Libraries in Python whose versions count.
_LIBRARIES = (
    "fenics-basix",
    "fenics-ffcx",
    "fenics-ufl",
    "numpy",
    "scipy",
    "h5py",
    "meshio",
    "matplotlib",
    "pillow",
    "vtk",
)

#: How the names of native libraries begin whose files count: packages may be rebuilt.
_NATIVE = (
    "libgmsh",
    "libTKernel",
    "libdolfinx",
    "libpetsc",
    "libslepc",
    "libdmumps",
    "libcholmod",
    "libscotch",
    "libopenblas",
)


@lru_cache(maxsize=1)
def surroundings() -> str:
    """Digest of the source of this program, of versions of libraries, and of options of PETSc."""
    import gmsh  # takes 0.15 s, which runs without a cache have no use for

    return key_of(
        fenics_nnm.__version__,
        _source(Path(fenics_nnm.__file__).parent),
        platform.python_version(),
        platform.machine(),
        dolfinx.__version__,
        *map(_version, _LIBRARIES),
        str(PETSc.Sys.getVersion()),
        str(SLEPc.Sys.getVersion()),
        gmsh.__version__,
        *_native(),
        os.environ.get("PETSC_OPTIONS", ""),
    )


def _source(folder: Path) -> bytes:
    """Digest of all modules of a package, so that changes within a version count."""
    total = hashlib.sha256()
    for path in sorted(path for kind in ("*.py", "*.c") for path in folder.rglob(kind)):
        total.update(key_of(str(path.relative_to(folder)), path.read_bytes()).encode())
    return total.digest()


def _native(maps: Path = Path("/proc/self/maps")) -> Iterator[str]:
    """Native libraries of this process that compute, each with its size and date."""
    with suppress(OSError):  # another system has no such list
        loaded = {line.split(maxsplit=5)[-1].strip() for line in maps.read_text().splitlines()}
        for path in sorted(map(Path, loaded)):
            if path.name.startswith(_NATIVE) and path.is_file():
                status = path.stat()
                yield f"{path} {status.st_size} {status.st_mtime_ns}"


def _version(library: str) -> str:
    try:
        return metadata.version(library)
    except metadata.PackageNotFoundError:
        return ""
