"""Meshes that are kept for commands that need the same again.

A mesh depends on the contents of its file, on what is asked of the reader or mesher, and on the
program and its libraries: all of that is in the key. It does not depend on the number of ranks, as
one of them reads or meshes for all.
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from fenics_nnm.fem.other_files import names_others
from fenics_nnm.fem.raw_mesh import RawMesh, arrays_of, raw_of
from fenics_nnm.fem.surroundings import surroundings
from fenics_nnm.files.cache import Cache, cache_of_user, key_of

logger = logging.getLogger(__name__)


class Identified(Protocol):
    """Work that gives a mesh."""

    def identity(self) -> str:
        """All that its mesh depends on, files by their contents; empty if that is not known.

        Raises:
            OSError: if a file cannot be read.
        """


def kept_or_made(job: Identified, make: Callable[[], RawMesh]) -> RawMesh:
    """The mesh of a job, which is made and kept if it was not before.

    Args:
        job: Names all that the mesh depends on.
        make: Makes the mesh, bit for bit as `read_written` reads it.

    Raises:
        NonlinearModeError: what `make` raises; an error is not kept.
    """
    cache, identity = cache_of_user(), _identity(job)
    if cache is None or not identity:
        return make()
    key = key_of("mesh", surroundings(), identity)
    found = _kept(cache, key)
    if found is not None:
        logger.info("the mesh is taken from %s", cache.folder)
        return found
    made = make()
    if _identity(job) == identity:  # else a file was changed meanwhile
        cache.write(key, arrays_of(made))
    return made


def contents(path: Path) -> str:
    """Digest of a file by its contents, with the name that messages have; empty if others matter.

    Raises:
        OSError: if it cannot be read.
    """
    if names_others(path):
        return ""
    return f"{path} {hashlib.sha256(path.read_bytes()).hexdigest()}"


def _identity(job: Identified) -> str:
    try:
        return job.identity()
    except OSError:  # what makes the mesh has the words for it
        return ""


def _kept(cache: Cache, key: str) -> RawMesh | None:
    arrays = cache.read(key)
    if arrays is None:
        return None
    try:
        return raw_of(arrays)
    except (ValueError, KeyError, IndexError, TypeError) as error:
        logger.info("the mesh in %s is left out: %s", cache.folder, error)
        return None
