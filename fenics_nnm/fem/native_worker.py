"""The process in which native readers and meshers run: `python -P -m ... FOLDER`."""

from __future__ import annotations

import gc
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
    gc.disable()  # what is imported lives as long as this process; a tenth of a short one
    logging.basicConfig(stream=sys.stdout, level=logging.INFO, format="%(message)s")
    job, gibibytes = pickle.loads((folder / JOB).read_bytes())
    import gmsh  # noqa: F401  # which starts a program to find its library

    limit_memory(gibibytes)
    if not job.trusted:
        confined(folder)
    try:
        write_raw(folder / ANSWER, job(folder))
    except NonlinearModeError as error:
        _report(folder, error)
    except MemoryError:
        _report(folder, job.errors.too_large(f"needs more than {gibibytes:.3g} GiB of memory"))
    except Exception as error:
        traceback.print_exc()
        _report(folder, _unexpected(job, error))
    return 0


def _report(folder: Path, error: NonlinearModeError) -> None:
    problem = {"kind": type(error).__name__, "message": str(error), "code": error.code}
    (folder / PROBLEM).write_text(json.dumps(problem))


def _unexpected(job: Job, error: Exception) -> MeshError:
    """The error in place of one that no reader expects, which a damaged file can bring about."""
    reason = " ".join(f"{type(error).__name__}: {error}".split())
    return job.errors.failed(f"cannot be read: {reason}: {job.advice}")


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
