"""Runs that fail after some points, or note each that they reported, for tests that kill them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.results import branch_file
from fenics_nnm.results.staging import living_run
from fenics_nnm.results.stored_point import ARRAYS

#: Runs a study; each point that was stored is noted in a file of its own, and takes 50 ms.
NOTING = """
import json, sys, time
import fenics_nnm.running.following
from fenics_nnm.cli import main

store = fenics_nnm.running.following.store

def noting(points, point):
    store(points, point)
    arrays = [getattr(point.motion, name).tolist() for name in ("q", "force", "free")]
    line = json.dumps([point.gamma_ratio, point.motion.frequency, point.motion.energy, *arrays])
    with open("noted", "a") as file:
        file.write(line + chr(10))
    time.sleep(0.05)

fenics_nnm.running.following.store = noting
sys.exit(main(sys.argv[1:]))
"""


def run_noting(folder: Path, study: Path) -> subprocess.Popen[bytes]:
    """Begin a run whose points are noted in `noted`."""
    script = folder / "noting.py"
    script.write_text(NOTING)
    (folder / "noted").unlink(missing_ok=True)
    return subprocess.Popen(
        [sys.executable, script, "run", study, "--output", "out"],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def noted_points(folder: Path) -> list[list[Any]]:
    """Numbers of the points noted so far; a last line cut short was not reported yet."""
    try:
        lines = (folder / "noted").read_text().splitlines(keepends=True)
    except FileNotFoundError:
        return []
    return [json.loads(line) for line in lines if line.endswith("\n")]


def numbers(point: BranchPoint) -> list[Any]:
    """Numbers of a point, as they are noted."""
    arrays = [getattr(point.motion, name).tolist() for name in ("q", "force", "free")]
    return [point.gamma_ratio, point.motion.frequency, point.motion.energy, *arrays]


def wait_for(condition: Callable[[], object], process: subprocess.Popen[Any]) -> None:
    """Wait until something holds, or a process has ended."""
    end = time.monotonic() + 60
    while not condition() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.005)


def wait_for_owners(folder: Path) -> None:
    """Wait until no process holds a run in a results folder any more."""
    end = time.monotonic() + 60
    while living_run(folder) and time.monotonic() < end:
        time.sleep(0.005)


def branch_in(folder: Path) -> Path:
    """The one branch.h5 of a results folder, of a finished run or not."""
    (path,) = [*folder.glob("branch.h5"), *folder.glob(".running-*/branch.h5")]
    return path


def assert_all_open(folder: Path) -> None:
    """Every file that is not being written opens."""
    for path in folder.rglob("*.h5"):
        with h5py.File(path) as file:
            assert file.attrs["format"] == branch_file.FORMAT
    for path in folder.rglob("branch.points/*.npz"):
        with np.load(path) as arrays:
            assert set(arrays) == {*ARRAYS, "scalars"}


#: Forks a child for each run, after imports that take longer than it does, and says how it ended.
FORKING = """
import json, os, signal, sys, time
import fenics_nnm.progress, fenics_nnm.run, fenics_nnm.running.following
import fenics_nnm.commands.lasting_console, fenics_nnm.study.reading
from fenics_nnm.cli import main

store = fenics_nnm.running.following.store

def noting(points, point):
    store(points, point)
    arrays = [getattr(point.motion, name).tolist() for name in ("q", "force", "free")]
    line = json.dumps([point.gamma_ratio, point.motion.frequency, point.motion.energy, *arrays])
    for name, text in (("noted", line), ("moments", str(time.process_time()))):
        with open(name, "a") as file:
            file.write(text + chr(10))
    end = time.process_time() + 0.015  # so that moments of CPU time are spread over the points
    while time.process_time() < end:
        pass

fenics_nnm.running.following.store = noting
for line in sys.stdin:
    folder, moment, arguments = json.loads(line)
    child = os.fork()
    if child == 0:
        os.chdir(folder)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # the pipe has exit codes alone
        signal.signal(signal.SIGPROF, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_PROF, moment)
        os._exit(main(arguments))
    _, status, used = os.wait4(child, 0)
    ended = os.waitstatus_to_exitcode(status)
    print(json.dumps([ended, used.ru_utime + used.ru_stime]), flush=True)
"""


class ForkedRuns:
    """Runs in processes that are born with the program imported."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-c", FORKING],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
            text=True,
        )

    def __enter__(self) -> ForkedRuns:
        return self

    def __exit__(self, *error: object) -> None:
        self._process.kill()
        self._process.communicate()

    def run(self, folder: Path, *arguments: object, moment: float = 0.0) -> tuple[int, float]:
        """Run the command line in a folder; exit code, or minus a signal, and seconds of CPU.

        Args:
            folder: Where it runs.
            arguments: Arguments of the command line.
            moment: Seconds of CPU after which the process is killed, where it stands, by the
                system; 0 lets it end.
        """
        assert self._process.stdin and self._process.stdout
        words = [str(folder), moment, [str(argument) for argument in arguments]]
        self._process.stdin.write(json.dumps(words) + "\n")
        self._process.stdin.flush()
        code, seconds = json.loads(self._process.stdout.readline())
        return int(code), float(seconds)


def failing_after(monkeypatch: Any, points: int, error: BaseException) -> None:
    """Make a run fail once a number of points are stored."""
    original, stored = branch_file.append, 0

    def append(journal: Any, point: Any) -> None:
        nonlocal stored
        if stored == points:
            raise error
        original(journal, point)
        stored += 1

    monkeypatch.setattr(branch_file, "append", append)
