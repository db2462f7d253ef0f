"""Jobs of native readers done in the process of a test, which is faster than one of their own."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fenics_nnm.fem.native import Job, Limits, answered
from fenics_nnm.fem.native_files import ANSWER, LOG
from fenics_nnm.fem.raw_mesh import RawMesh, write_raw

#: Modules that start a process for a reader or a mesher.
STARTERS = ("fem.mesh", "fem.cad", "fem.built_in")


def in_this_process(job: Job, limits: Limits) -> RawMesh:
    """What `in_own_process` does, without its limits and its fence."""
    with tempfile.TemporaryDirectory(prefix="fenics-nnm-") as name:
        folder = Path(name).resolve()
        with printed_to(folder / LOG):
            write_raw(folder / ANSWER, job(folder))
        return answered(folder)


@contextmanager
def printed_to(path: Path) -> Iterator[None]:
    """Have all that is printed here, by native code too, go to a file for a while."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(each) for each in (1, 2)]
    with path.open("wb") as log:
        try:
            for each in (1, 2):
                os.dup2(log.fileno(), each)
            yield
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for each, old in zip((1, 2), kept, strict=True):
                os.dup2(old, each)
                os.close(old)
