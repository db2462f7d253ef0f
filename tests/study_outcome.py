"""How runs of studies end, judged by their results, in a process that may hang or die."""

from __future__ import annotations

import contextlib
import csv
import io
import math
import multiprocessing
import re
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from independent_motion import Exact, TooLong, after_a_period, exact_motion

from fenics_nnm.backbone.point import VERIFIED, BranchPoint
from fenics_nnm.backbone.point_numbers import return_error, shot_distance
from fenics_nnm.results import branch_file
from fenics_nnm.results.branch_file import BranchHeader

#: What a reason must have: a key of the study file to change.
_KEY = re.compile(r"\b(mesh|body|material|clamp|contact|reduction|mode|continuation|matrices)\.\w+")

#: Columns that are numbers at every point.
_NUMBERS = (
    "gamma_ratio",
    "frequency_Hz",
    "frequency_ratio",
    "rayleigh_frequency_Hz",
    "energy_J",
    "penetration_m",
    "virial_error",
    "contact_fraction",
)

#: Verified points: largest return error, largest delay of the return in periods, and by how much
#: the frequency of the exact motion of the same energy may differ.
_RETURN, _LATE, _FREQUENCY = 0.05, 0.01, 1e-3

#: Shooting takes longer than integration: of the points of a study about so many are shot.
_SHOT_POINTS = 3

#: What a complete run writes.
_FILES = {"backbone.csv", "backbone.png", "branch.h5", "summary.json"}


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a study ended.

    Attributes:
        end: "complete", "incomplete", "refused", or what is wrong: "crash", "hang", "wrong".
        seconds: Seconds of CPU of the run; of waiting for it where it hangs or crashes.
        message: Its lines on stderr.
        statuses: Number of points of each status.
        checked: Verified points that were integrated in time.
        shot: Those of them in contact whose frequency was found by shooting, too.
        faults: What is wrong with the run or its points.
    """

    end: str
    seconds: float
    message: str = ""
    statuses: Counter[str] = field(default_factory=Counter)
    checked: int = 0
    shot: int = 0
    faults: tuple[str, ...] = ()

    @property
    def faulty(self) -> bool:
        """Whether the study ended as none must."""
        return self.end in ("crash", "hang", "wrong")

    def __str__(self) -> str:
        points = ", ".join(f"{count} {status}" for status, count in self.statuses.items())
        told = "".join(f"\n        {line}" for line in [*self.message.splitlines(), *self.faults])
        return f"{self.end:10s} {self.seconds:6.1f} s  {points}{told}"


class Examiner:
    """Runs studies in another process, and begins a new one where that hangs or dies."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._spawn = multiprocessing.get_context("spawn")

    def __enter__(self) -> Examiner:
        self._begin()
        return self

    def __exit__(self, *error: object) -> None:
        self._end()

    def outcome(self, study: Path) -> Outcome:
        """Run a study and judge its results, which go to a folder beside it."""
        start = time.monotonic()
        self._pipe.send(study)
        try:
            if self._pipe.poll(self._seconds):
                ended: Outcome = self._pipe.recv()
                return ended
            end = "hang"
        except EOFError:
            end = "crash"
        self._end()
        self._begin()
        return Outcome(end, time.monotonic() - start, str(study))

    def _begin(self) -> None:
        self._pipe, there = self._spawn.Pipe()
        self._process = self._spawn.Process(target=_serve, args=(there,), daemon=True)
        self._process.start()
        there.close()
        self._pipe.recv()

    def _end(self) -> None:
        self._process.kill()
        self._process.join()
        self._pipe.close()


def _serve(pipe: Any) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ImportWarning)
        from fenics_nnm import run

    del run
    warnings.simplefilter("error")
    pipe.send("ready")
    while True:
        pipe.send(run_and_judge(pipe.recv()))


def run_and_judge(study: Path) -> Outcome:
    """Run a study in this process and judge its results."""
    from fenics_nnm.cli import main

    folder, told = study.parent / "results", io.StringIO()
    start = time.process_time()
    with contextlib.redirect_stderr(told), contextlib.redirect_stdout(io.StringIO()):
        code = main(["run", str(study), "--output", str(folder)])
    seconds, message = time.process_time() - start, told.getvalue().strip()
    if code not in (0, 1, 2) or "this is a defect" in message:
        return Outcome("crash", seconds, message)
    if code == 2:
        faults = tuple(_faults_of_refusal(message, folder))
        return Outcome("wrong" if faults else "refused", seconds, message, faults=faults)
    return _judged(folder, ("complete", "incomplete")[code], seconds, message)


def _faults_of_refusal(message: str, folder: Path) -> Iterator[str]:
    if len(message.splitlines()) != 1 or not message.startswith("fenics-nnm: "):
        yield "the reason is not one line"
    if not _KEY.search(message):
        yield "the reason names no key"
    if folder.exists():
        yield f"there are results: {sorted(path.name for path in folder.iterdir())}"


def _judged(folder: Path, end: str, seconds: float, message: str) -> Outcome:
    header, points = branch_file.read(folder / "branch.h5")
    bends = len(header.model.kinematics.masters) > 0
    table = _faults_of_table(folder, points, bends=bends)
    faults = [*_faults_of_files(folder, end, message), *table]
    verified = [point for point in points if point.status == VERIFIED]
    in_contact = [point for point in verified if point.motion.contact_fraction > 0]
    to_shoot = in_contact[:: max(1, len(in_contact) // _SHOT_POINTS)]
    seen = [_seen(header, point, shoot=any(point is one for one in to_shoot)) for point in verified]
    faults += [fault for witness in seen for fault in witness.faults]
    return Outcome(
        end="wrong" if faults else end,
        seconds=seconds,
        message=message,
        statuses=Counter(point.status for point in points),
        checked=sum(witness.followed for witness in seen),
        shot=sum(witness.shot for witness in seen),
        faults=tuple(faults),
    )


@dataclass(frozen=True, slots=True)
class _Witness:
    """What integration in time says of a point: whether it could, and what is wrong."""

    followed: bool
    shot: bool
    faults: tuple[str, ...]


def _seen(header: BranchHeader, point: BranchPoint, *, shoot: bool) -> _Witness:
    model, harmonics = header.model, header.harmonics
    if not model.massless:  # linear modes, which the table is checked for
        return _Witness(False, False, ())
    try:
        back = after_a_period(model, point, harmonics)
    except TooLong:
        return _Witness(False, False, ())
    faults, exact = [], Exact()
    same = abs(back.error - return_error(point)) <= 0.01 * return_error(point) + 1e-4
    if not (same and back.error <= _RETURN and abs(back.late) <= _LATE):
        faults.append(
            f"gamma_ratio {point.gamma_ratio:.6g}, {VERIFIED}: misses its start by "
            f"{back.error:.3g} ({return_error(point):.3g} in the table) and is nearest to it "
            f"{back.late:+.3g} of a period late"
        )
    if shoot and 'method = "none"' not in header.study and not len(model.kinematics.masters):
        with contextlib.suppress(TooLong):
            exact = exact_motion(model, point, harmonics)
    nearest = not exact.distance > 1.1 * shot_distance(point) + 1e-3  # no other motion beyond it
    if nearest and abs(exact.frequency / point.motion.frequency - 1) > _FREQUENCY:
        faults.append(
            f"gamma_ratio {point.gamma_ratio:.6g}, {VERIFIED}: {point.motion.frequency:.9g} Hz, "
            f"and {exact.frequency:.9g} Hz by shooting"
        )
    return _Witness(True, nearest and math.isfinite(exact.frequency), tuple(faults))


def _faults_of_files(folder: Path, end: str, message: str) -> Iterator[str]:
    names = {path.name for path in folder.iterdir()}
    if not names >= _FILES:
        yield f"missing: {sorted(_FILES - names)}"
    if hidden := {name for name in names if name.startswith(".")}:
        yield f"left behind: {sorted(hidden)}"
    if not all(line.startswith("fenics-nnm: ") for line in message.splitlines()):
        yield "stderr has other lines than those of the program"
    if end == "incomplete" and not _KEY.search(message):
        yield "the reason names no key"


def _faults_of_table(
    folder: Path, points: tuple[BranchPoint, ...], *, bends: bool
) -> Iterator[str]:
    with (folder / "backbone.csv").open() as file:
        rows = list(csv.DictReader(file))
    if [row["status"] for row in rows] != [point.status for point in points]:
        yield "backbone.csv and branch.h5 have other points"
    places = [point.position for point in points]
    if places != sorted(set(places)):
        yield "points are not in order"
    for row in rows:
        yield from (
            f"gamma_ratio {row['gamma_ratio']}: {fault}"
            for fault in _faults_of_row(row, bends=bends)
        )


def _faults_of_row(row: dict[str, str], *, bends: bool) -> Iterator[str]:
    """What is wrong with a point; where a body bends its frequency depends on its amplitude."""
    yield from (f"{name} = {row[name]}" for name in _NUMBERS if not math.isfinite(float(row[name])))
    ratio, frequency = float(row["gamma_ratio"]), float(row["frequency_ratio"])
    if abs(float(row["virial_error"])) > 1e-6:
        yield f"virial_error = {row['virial_error']}"
    free = float(row["contact_fraction"]) == 0
    if free and not bends and abs(frequency - 1) > 1e-8:
        yield f"frequency_ratio = {frequency} without contact"
    if ratio > 1.02 and free and not bends:
        yield "no contact above grazing"
