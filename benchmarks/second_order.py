"""What loads and large deflection cost beside linear kinematics, on the rotor 37 blade at speed.

    environment/run python3 benchmarks/second_order.py --size 0.0011
    environment/run python3 benchmarks/second_order.py --branches

With --size the linear part of the study of demos/rotor37/engine.toml is made on a mesh of that
element size, with 40 modes and six masters (21 modal derivatives and the tensors): CPU seconds of
the static state, of the modes (SLEPc) and of second order, and the first and the last over modes.
With --branches its branch is followed with linear and with second-order kinematics, one master, on
the 6 mm mesh, in turn and several times: least CPU seconds a point of harmonic balance and of the
check in time, and the median of the ratios of all pairs, from the least to the largest, of both
and of their sum.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import cProfile
import pstats
import statistics
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from large import timed_stages
from mpi4py import MPI

from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.files.cache import turn_off
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.prepared import Prepared, prepared
from fenics_nnm.study import Study, read_study

ROOT = Path(__file__).resolve().parent.parent
STUDY = ROOT / "demos/rotor37/engine.toml"

#: Modes J, harmonics N, samples m of the branches.
CASES = ((40, 10, 128), (40, 20, 256), (20, 10, 128), (20, 20, 256))

#: Kinematics and stages that are compared.
KINEMATICS, STAGES = ("linear", "second-order"), ("balance", "check", "whole")


@dataclass(frozen=True, slots=True)
class Spent:
    """CPU seconds of a branch.

    Attributes:
        points: Number of points.
        verified: Number of those that are verified.
        balance: Seconds until the last motion was found.
        check: Seconds of the check in time.
    """

    points: int
    verified: int
    balance: float
    check: float

    @property
    def whole(self) -> float:
        """Seconds of both."""
        return self.balance + self.check

    @property
    def row(self) -> str:
        """Points and seconds a point."""
        each = f"{self.balance / self.points:.3f} | {self.check / self.points:.3f}"
        return f"{self.points} | {self.verified} | {each}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=float, help="element size in m")
    parser.add_argument("--branches", action="store_true")
    parser.add_argument("--pairs", type=int, default=5, help="how often each branch is followed")
    parser.add_argument("--only", type=int, help="number of the case of the branches, from 0")
    parser.add_argument("--profile", action="store_true", help="tell where time is spent, too")
    arguments = parser.parse_args()
    turn_off()  # what was kept costs nothing
    profiler = cProfile.Profile(time.process_time)
    if arguments.profile:
        profiler.enable()
    if arguments.size:
        print(linear_part(arguments.size), flush=True)
    if arguments.branches:
        cases = CASES if arguments.only is None else CASES[arguments.only :][:1]
        branches(cases, arguments.pairs)
    profiler.disable()
    if arguments.profile:
        pstats.Stats(profiler).strip_dirs().sort_stats("tottime").print_stats(30)


def linear_part(size: float) -> str:
    """Row of the linear part on a mesh."""
    stages = timed_stages()
    study = study_of(size, 40, "second-order", (1, 2, 3, 4, 5, 6))
    found = linear_analysis(study, MPI.COMM_WORLD, stages)
    spent = stages.timings
    state, modes, bent = (spent[each] for each in ("static state", "modes", "second order"))
    return (
        f"| {size:g} | {found.solid.dofs} | {state:.1f} | {spent['factors']:.1f} | {modes:.1f} | "
        f"{bent:.1f} | {(state + bent) / modes:.3f} |"
    )


def branches(cases: Sequence[tuple[int, int, int]], pairs: int) -> None:
    """Rows of branches, each followed so many times with either kinematics, in turn."""
    for modes, harmonics, samples in cases:
        studies = [study_of(0.006, modes, each, (1,)) for each in KINEMATICS]
        ready = [prepared(each, linear_analysis(each, MPI.COMM_WORLD)) for each in studies]
        balance = HarmonicBalance(harmonics, samples)
        spent = [[followed(each, balance) for each in ready] for _ in range(pairs)]
        for kinematics, each in zip(KINEMATICS, zip(*spent, strict=True), strict=True):
            row = min(each, key=lambda one: one.whole).row
            print(f"| {modes} | {harmonics} | {samples} | {kinematics} | {row} |")
        found = [spread([getattr(b, n) / getattr(a, n) for a, b in spent]) for n in STAGES]
        print(f"ratios {', '.join(found)}", flush=True)


def spread(ratios: Sequence[float]) -> str:
    """Median of ratios, with the least and the largest."""
    return f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"


def followed(ready: Prepared, balance: HarmonicBalance) -> Spent:
    """A branch and what it costs."""
    last = [0.0]
    start = time.process_time()

    def noted(point: BranchPoint) -> None:
        last[0] = time.process_time()

    branch = replace(ready, balance=balance).followed(on_point=noted)
    end = time.process_time()
    verified = sum(point.status == "verified" for point in branch.points)
    return Spent(len(branch.points), verified, last[0] - start, end - last[0])


def study_of(size: float, modes: int, kinematics: str, masters: tuple[int, ...]) -> Study:
    """The study of the demo with another mesh, number of modes and kinematics."""
    text = STUDY.read_text().replace("../../meshes", str(ROOT / "meshes"))
    kept = [
        line
        for line in text.splitlines()
        if not line.startswith(("element_size", "kinematics", "modes"))
    ]
    bent = f'kinematics = "{kinematics}"'
    if kinematics == "second-order":
        bent += f"\nmasters = {list(masters)}"
    text = "\n".join(kept).replace("[mesh]", f"[mesh]\nelement_size = {size}")
    text = text.replace("[body]", f"[body]\n{bent}")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "study.toml"
        file.write_text(text.replace("[reduction]", f"[reduction]\nmodes = {modes}"))
        return read_study(file)


if __name__ == "__main__":
    main()
