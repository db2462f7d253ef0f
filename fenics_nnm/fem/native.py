"""Native readers and meshers in a process of their own.

gmsh and OpenCASCADE may crash, loop or take all memory on a file that is damaged or merely unusual.
They run in a process that has limits, so that such an end is one line that names the file.
"""

from __future__ import annotations

import json
import logging
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

from fenics_nnm import errors
from fenics_nnm.errors import Code, MeshError, NonlinearModeError
from fenics_nnm.fem.confinement import same_addresses
from fenics_nnm.fem.native_errors import NativeErrors
from fenics_nnm.fem.native_files import ANSWER, JOB, LOG, PROBLEM
from fenics_nnm.fem.raw_mesh import RawMesh, read_written
from fenics_nnm.files.free_memory import free_memory
from fenics_nnm.processes import environment_of_child

logger = logging.getLogger(__name__)

_GIB = 2**30

#: GiB of addresses that the libraries take before they do anything.
_LIBRARIES = 2.0

#: Share of the free memory that a mesher may take if nobody says otherwise.
_PART = 0.8

#: Seconds that a mesher may take if nobody says otherwise.
_TIME = 3600.0

#: Seconds between two looks at the process.
_PAUSE = 0.02

#: Beginnings of gmsh's lines that name a step of its work.
_STEPS = ("Reading", "Meshing", "Optimizing", "Healing", "Sewing", "Computing", "Fragment")


class Job(Protocol):
    """Work of native libraries that gives a mesh.

    Attributes:
        errors: Makes its errors.
        advice: What to try where it fails.
        trusted: Whether it may start programs and write files.
    """

    @property
    def errors(self) -> NativeErrors:
        """Makes its errors."""

    @property
    def advice(self) -> str:
        """What to try."""

    def fault(self) -> str:
        """What is wrong with the input as far as can be seen without native code; empty: nothing.

        It is asked after a crash.
        """

    @property
    def trusted(self) -> bool:
        """Whether it may do all that this process may."""

    def __call__(self, folder: Path) -> RawMesh:
        """Do it; `folder` is private and is removed afterwards."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What a process may take.

    Attributes:
        memory: GiB; most of what is free if not given.
        time: Seconds; an hour if not given.
    """

    memory: float | None = None
    time: float | None = None

    @property
    def seconds(self) -> float:
        """Time in s."""
        return _TIME if self.time is None else self.time

    @property
    def gibibytes(self) -> float:
        """Memory in GiB, without that of the libraries."""
        if self.memory is not None:
            return self.memory
        return _PART * (free_memory() or 16 * _GIB) / _GIB


def in_own_process(job: Job, limits: Limits) -> RawMesh:
    """Do a job in a process of its own.

    Args:
        job: The job, which can be pickled.
        limits: What the process may take.

    Raises:
        MeshError: if the process crashes, is too slow or takes too much memory.
        NonlinearModeError: what the job raises.
    """
    with tempfile.TemporaryDirectory(prefix="fenics-nnm-") as name:
        folder = Path(name).resolve()
        (folder / JOB).write_bytes(pickle.dumps((job, limits.gibibytes + _LIBRARIES)))
        code = _waited(_started(folder), folder, job, limits.seconds)
        if (folder / PROBLEM).exists():
            raise _problem(folder)
        if code or not (folder / ANSWER).exists():
            raise _ended(code, folder, job, limits)
        return answered(folder)


def answered(folder: Path) -> RawMesh:
    """The mesh that a job has written, with the notes that it has printed."""
    raw = read_written(folder / ANSWER)
    return replace(raw, notes=(*raw.notes, *_lines(folder, "note: ")))


def _started(folder: Path) -> subprocess.Popen[bytes]:
    environment = environment_of_child(
        HOME=str(folder),
        TMPDIR=str(folder),
        OMP_NUM_THREADS="1",
        OPENBLAS_NUM_THREADS="1",
        PYTHONHASHSEED="0",
    )
    with (folder / LOG).open("wb") as log:
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "fenics_nnm.fem.native_worker", str(folder)],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            preexec_fn=same_addresses,
            start_new_session=True,  # Ctrl-C comes to this process, which ends that one
        )


def _waited(process: subprocess.Popen[bytes], folder: Path, job: Job, seconds: float) -> int:
    """Exit code of the process; its steps are logged on the way."""
    end = time.monotonic() + seconds
    read = 0
    try:
        while process.poll() is None:
            if time.monotonic() > end:
                raise job.errors.too_slow(
                    f"took more than {seconds:g} s{_last_step(folder)}: {job.advice}"
                )
            time.sleep(_PAUSE)
            read = _log(folder, read)
    finally:
        _end(process)
        _log(folder, read)
    return process.returncode


def _end(process: subprocess.Popen[bytes]) -> None:
    """End the process and all that it may have started."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass  # it has ended, and nothing is left of it
    process.wait()


def _log(folder: Path, read: int) -> int:
    """Log what the process wrote after `read` bytes; how many bytes there are now."""
    if not logger.isEnabledFor(logging.INFO):
        return read
    with (folder / LOG).open("rb") as file:
        file.seek(read)
        text = file.read()
    whole = text.rpartition(b"\n")[0]
    for line in whole.decode(errors="replace").splitlines():
        if line.strip():
            logger.info("gmsh: %s", line.strip())
    return read + len(whole) + (1 if whole else 0)


def _problem(folder: Path) -> NonlinearModeError:
    """The error that the job has raised."""
    problem = json.loads((folder / PROBLEM).read_text())
    kind = getattr(errors, problem["kind"])
    assert issubclass(kind, NonlinearModeError)
    error = kind(problem["message"])
    error.code = Code(problem["code"]) if problem["code"] else None
    return error


def _ended(code: int, folder: Path, job: Job, limits: Limits) -> MeshError:
    """The error of a process that has ended without an answer."""
    fault = job.fault()
    if _lines(folder, "terminate called after throwing an instance of 'std::bad_alloc'"):
        reason = f"needs more than {limits.gibibytes:.3g} GiB of memory"
        return job.errors.failed(f"{fault} ({reason})") if fault else job.errors.too_large(reason)
    death = _death(code, folder)
    return job.errors.failed(f"{fault} ({death})" if fault else f"{death}: {job.advice}")


def _death(code: int, folder: Path) -> str:
    """Why a process has ended without an answer."""
    if code < 0:
        name = signal.Signals(-code).name
        return f"gmsh or OpenCASCADE crashed{_last_step(folder)} ({name})"
    return f"gmsh ended{_last_step(folder)} with exit code {code} and without a mesh"


def _last_step(folder: Path) -> str:
    """The last step that gmsh has named."""
    steps = [line for line in _lines(folder, "Info    : ") if line.startswith(_STEPS)]
    steps = [line for line in steps if not line.startswith("Reading '")]
    if not steps:
        return " on reading"
    last = steps[-1].rstrip(". ")
    return f" at the step '{last}'"


def _lines(folder: Path, beginning: str) -> list[str]:
    """What stands after a beginning of lines in the log."""
    text = (folder / LOG).read_text("utf-8", errors="replace")
    return [
        line.removeprefix(beginning) for line in text.splitlines() if line.startswith(beginning)
    ]
