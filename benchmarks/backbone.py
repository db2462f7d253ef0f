"""Cost of whole backbones for models of growing size, and memory along a long one.

Run: environment/run python3 benchmarks/backbone.py [--profile] [--long 2000]

Each case follows 30 energies of a blade tip (benchmarks/tips.py) from 0.7 to 3 times grazing, with
error estimates, and verifies them in time, as a run does. Times are CPU times of one thread. Each
case runs in a process of its own, whose peak memory is that of the case and of Python with its
libraries. With --profile what the third case spends its time on is kept as text in
benchmarks/profiles. With --long a rod with one contact point is followed over that many points, and
the memory is told at ten of them.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import cProfile
import io
import pstats
import resource
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tips import blade_tip

from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.follow import EnergyContinuation, Progress, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.mechanics.model import ReducedModel

#: Modes J, contact points n_c, harmonics N, samples m.
CASES = ((10, 6, 5, 64), (20, 12, 10, 128), (40, 24, 10, 128), (80, 48, 10, 128))
_PROFILED = (40, 24, 10, 128)
_ENERGIES = EnergyContinuation(0.7, 3.0, 2.3 / 29)
_HEAD = (
    "| J | n_c | N | m | points | verified | Newton steps | branch (s) | check (s) | MB |\n"
    "|---|---|---|---|---|---|---|---|---|---|"
)
_PROFILES = Path(__file__).parent / "profiles"


@dataclass(slots=True)
class Measured:
    """A branch, and the CPU time in s until its last point was found and until it was verified."""

    branch: Branch
    found: float
    whole: float


def measured(
    model: ReducedModel, balance: HarmonicBalance, energies: EnergyContinuation = _ENERGIES
) -> Measured:
    """Follow a branch and time it."""
    last = [0.0]
    start = time.process_time()

    def noted(point: BranchPoint) -> None:
        last[0] = time.process_time()

    branch = follow(
        model, energies, balance, mode=0, shooting=True, progress=Progress(on_point=noted)
    )
    return Measured(branch, last[0] - start, time.process_time() - start)


def peak_memory() -> float:
    """Peak memory of this process in MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def memory() -> float:
    """Present memory of this process in MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


def row(case: tuple[int, int, int, int]) -> str:
    """Row of the table for a case, measured in this process."""
    modes, points, harmonics, samples = case
    found = measured(blade_tip(modes, points), HarmonicBalance(harmonics, samples))
    steps = sum(point.notes.iterations for point in found.branch.points)
    verified = sum(point.status == "verified" for point in found.branch.points)
    return (
        f"| {modes} | {points} | {harmonics} | {samples} | {len(found.branch.points)} | {verified} "
        f"| {steps} | {found.found:.2f} | {found.whole - found.found:.2f} | {peak_memory():.0f} |"
    )


def profile() -> None:
    """Write what the middle case spends its time on."""
    modes, points, harmonics, samples = _PROFILED
    profiler = cProfile.Profile(time.process_time)
    profiler.runcall(measured, blade_tip(modes, points), HarmonicBalance(harmonics, samples))
    text = io.StringIO()
    stats = pstats.Stats(profiler, stream=text)
    stats.strip_dirs().sort_stats("cumulative").print_stats(40)
    stats.sort_stats("tottime").print_stats(25)
    _PROFILES.mkdir(exist_ok=True)
    (_PROFILES / f"backbone_{modes}_{points}.txt").write_text(text.getvalue())


def rod(modes: int) -> ReducedModel:
    """Clamped-free rod of unit length and wave speed with a stop at its end, in closed form."""
    order = np.arange(modes)
    omega = (order + 0.5) * np.pi
    end = np.sqrt(2.0) * (-1.0) ** order
    return ReducedModel(omega, end[None], [[1 - np.sum((end / omega) ** 2)]], [1.0])


def long_branch(points: int) -> None:
    """Tell the memory along a branch of many points."""
    count = [0]

    def noted(point: BranchPoint) -> None:
        count[0] += 1
        if count[0] % max(1, points // 10) == 0:
            print(f"| {count[0]} | {memory():.1f} |", flush=True)

    print("| points | memory (MB) |\n|---|---|", flush=True)
    energies = EnergyContinuation(1.05, 2.0, 0.95 / (points - 1))
    follow(rod(4), energies, HarmonicBalance(3, 32), mode=0, progress=Progress(on_point=noted))


def main() -> None:
    """Measure the cases one after the other."""
    parser = argparse.ArgumentParser(description="Cost of whole backbones.")
    parser.add_argument("--case", type=int, help="measure this case alone, in this process")
    parser.add_argument("--profile", action="store_true", help="keep a profile as text")
    parser.add_argument("--long", type=int, help="follow a rod over this many points")
    chosen = parser.parse_args()
    if chosen.case is not None:
        print(row(CASES[chosen.case]))
    elif chosen.long:
        long_branch(chosen.long)
    elif chosen.profile:
        profile()
    else:
        print(
            "| J | n_c | N | m | points | verified | Newton steps | branch (s) | check (s) | MB |"
        )
        print("|---|---|---|---|---|---|---|---|---|---|", flush=True)
        for number in range(len(CASES)):
            command = [sys.executable, __file__, "--case", str(number)]
            print(subprocess.check_output(command, text=True).strip(), flush=True)


if __name__ == "__main__":
    main()
