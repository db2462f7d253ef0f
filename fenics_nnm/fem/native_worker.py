"""The process in which native readers and meshers run: `python -P -m ... FOLDER`."""

from __future__ import annotations

import json
import logging
import pickle
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING

from fenics_nnm.errors import MeshError, NonlinearModeError
from fenics_nnm.fem.confinement import confined, die_with_parent, limit_memory
from fenics_nnm.fem.native_files import ANSWER, JOB, PROBLEM
from fenics_nnm.fem.raw_mesh import write_raw

if TYPE_CHECKING:
    from fenics_nnm.fem.native import Job


def main(folder: Path) -> int:
    """Do the job of a folder and put the mesh, or what went wrong, in it."""
    die_with_parent()
    logging.basicConfig(stream=sys.stdout, level=logging.INFO, format="%(message)s")
    job, gibibytes = pickle.loads((folder / JOB).read_bytes())
    import gmsh  # noqa: F401  # which starts a program to find its library

    limit_memory(gibibytes)
    if not job.trusted:
        confined(folder)
    try:
        write_raw(folder / ANSWER, job(folder))
    except NonlinearModeError as error:
        _tell(folder, type(error).__name__, str(error))
    except MemoryError:
        message = f"{job.what}: needs more than {gibibytes:.3g} GiB of memory (mesh.memory)"
        _tell(folder, MeshError.__name__, message)
    except Exception as error:
        traceback.print_exc()
        _tell(folder, MeshError.__name__, _unexpected(job, error))
    return 0


def _tell(folder: Path, kind: str, message: str) -> None:
    (folder / PROBLEM).write_text(json.dumps({"kind": kind, "message": message}))


def _unexpected(job: Job, error: Exception) -> str:
    """What is said of an error that no reader expects, which a damaged file can bring about."""
    reason = " ".join(f"{type(error).__name__}: {error}".split())
    return f"{job.what}: cannot be read: {reason}: {job.advice}"


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
