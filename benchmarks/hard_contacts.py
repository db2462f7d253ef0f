"""Backbones through contact that is hard to solve: a bare-metal blade, and stiff chains.

    environment/run python3 benchmarks/hard_contacts.py --chains 84 [--base ../other]
    environment/run python3 benchmarks/hard_contacts.py --blade blade.npz [--base ../other]
    environment/run python3 benchmarks/hard_contacts.py --write blade.npz

Chains of 3 to 8 masses in a row, of which one to three meet stops, have springs whose stiffness
spreads over up to four orders of magnitude, and frequencies some of which are nearly equal or
nearly multiples of each other. They are random, but always the same. `--write` keeps the reduced
model of the blade of demos/step (20 modes, 8 points, linear kinematics; run demos/step/blade.py
first), which `--blade` follows with J = 20, N = 40, m = 512 and J = 10, N = 80, m = 512 at ten
energies from 0.2 to 2 times grazing. Each branch is followed in a process of its own, with
shooting: CPU seconds of one thread, Newton solves, and points by status. With `--base` the same
models are followed by another checkout, too, and points are compared.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import argparse
import itertools
import json
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent.parent

#: Longest CPU time of a branch in s.
LIMIT = 150

#: Modes J, harmonics N and samples m of the blade.
BLADES = ((20, 40, 512), (10, 80, 512))

Arrays = dict[str, Any]

#: Follows the branch of a model in a file and prints what it gave, in checkouts old and new.
FOLLOW = """
import json, sys, time
import numpy as np
try:
    from fenics_nnm.backbone.follow import EnergyContinuation, follow
    from fenics_nnm.backbone.levels import HarmonicBalance
    from fenics_nnm.mechanics.model import ReducedModel
except ModuleNotFoundError:
    from fenics_nnm.continuation.follow import EnergyContinuation, follow
    from fenics_nnm.continuation.levels import HarmonicBalance
    from fenics_nnm.reduction.model import ReducedModel
from fenics_nnm.nonlinear import newton

given = np.load(sys.argv[1])
solves, run = [0, 0], newton._Iteration.run

def counted(iteration, start):
    found = run(iteration, start)
    solves[0] += 1
    solves[1] += found.iterations
    return found

newton._Iteration.run = counted
model = ReducedModel(given["omega"], given["Phi"], given["R"], given["gap"])
energies = EnergyContinuation(*map(float, given["energies"]))
balance = HarmonicBalance(int(given["harmonics"]), int(given["samples"]))
began = time.process_time()
branch = follow(model, energies, balance, mode=0, shooting=True)
points = [
    (point.gamma_ratio, point.motion.frequency if hasattr(point, "motion") else point.frequency,
     point.status)
    for point in branch.points
]
print(json.dumps({
    "seconds": time.process_time() - began, "solves": solves[0], "steps": solves[1],
    "points": points, "missing": [ratio for ratio, _ in branch.failures],
}))
"""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What following a branch gave.

    Attributes:
        seconds: CPU seconds; the limit if it did not end.
        solves: Newton solves.
        steps: Newton steps.
        points: Gamma ratio, frequency in Hz and status of each point.
        missing: Energies without a point.
        error: The last line of an error, or nothing.
    """

    seconds: float
    solves: int = 0
    steps: int = 0
    points: list[tuple[float, float, str]] = field(default_factory=list)
    missing: list[float] = field(default_factory=list)
    error: str = ""

    @property
    def statuses(self) -> str:
        """Numbers of points by status."""
        counted = Counter(status for _, _, status in self.points)
        counted["missing"] = len(self.missing)
        return self.error or ", ".join(f"{n} {name}" for name, n in sorted(counted.items()) if n)


def followed(checkout: Path, model: Path) -> Outcome:
    """Follow the branch of a model with a checkout."""
    command = f"ulimit -t {LIMIT}; exec {sys.executable} -c '{FOLLOW}' {model}"
    ended = subprocess.run(
        ["bash", "-c", command],
        env={**os.environ, "PYTHONPATH": str(checkout)},
        cwd=checkout,
        capture_output=True,
        text=True,
        check=False,
    )
    if ended.returncode == 0:
        return Outcome(**json.loads(ended.stdout.splitlines()[-1]))
    lines = ended.stderr.strip().splitlines()
    return Outcome(seconds=LIMIT, error=lines[-1] if lines else "did not end")


def chain(number: int) -> Arrays:
    """The random chain of a number: its reduced model, energies, harmonics and samples.

    One whose contact points have no flexibility of their own is drawn again.
    """
    drawn = _chain(Random(f"chain {number}"))
    for again in itertools.count():
        if np.linalg.eigvalsh(drawn["R"])[0] > 1e-9 * np.linalg.eigvalsh(drawn["R"])[-1]:
            return drawn
        drawn = _chain(Random(f"chain {number}, {again}"))
    raise AssertionError


def _chain(chance: Random) -> Arrays:
    size = chance.randint(3, 8)
    K, M = _matrices(chance, size)
    values, shapes = np.linalg.eigh(K / np.sqrt(np.outer(M, M)))
    omega, shapes = np.sqrt(values), shapes / np.sqrt(M)[:, None]
    points = chance.randint(1, min(3, size - 2))
    places = sorted(chance.sample(range(size), points))
    modes = chance.randint(2, size - points)
    signs = np.array([chance.choice([1.0, 1.0, -1.0]) for _ in places])
    B = signs[:, None] * np.eye(size)[places]
    Phi = B @ shapes[:, :modes]
    left_out = (B @ shapes[:, modes:]) / omega[modes:]
    gap = [1e-3 * chance.uniform(0.7, 1.5) for _ in places]
    harmonics = chance.choice([5, 8, 10, 15, 20])
    return {
        "omega": omega[:modes],
        "Phi": Phi,
        "R": left_out @ left_out.T,
        "gap": gap,
        "energies": [0.8, chance.uniform(1.4, 3.0), chance.choice([0.1, 0.2])],
        "harmonics": harmonics,
        "samples": chance.choice([6 * harmonics, 128, 256]),
    }


def _matrices(chance: Random, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness matrix and masses: springs between masses, and from each to the ground.

    Half of the chains have nearly equal halves with a weak spring between them, so that their
    frequencies come in pairs; the ground of a third makes neighbouring frequencies near multiples.
    """
    spread = 10 ** chance.uniform(1.0, 4.0)
    between = [1e5 * spread ** -chance.random() for _ in range(size - 1)]
    ground = [1e5 * spread ** -chance.random() for _ in range(size)]
    masses = [10 ** chance.uniform(-1.0, 0.0) for _ in range(size)]
    if chance.random() < 0.5:
        half = size // 2
        for at in range(half):
            detuned = 1 + 1e-3 * chance.uniform(-1.0, 1.0)
            ground[size - 1 - at] = ground[at] * detuned
            masses[size - 1 - at] = masses[at]
            between[size - 2 - at] = between[at]
        between[half - 1 : size - half] = [1e-2 * min(ground)] * (size - 2 * half + 1)
    elif chance.random() < 2 / 3:
        multiple = chance.choice([2, 3, 5])
        ground[1] = ground[0] * masses[1] / masses[0] * multiple**2 * chance.uniform(0.99, 1.01)
        between[0] = 1e-2 * ground[0]
    K = np.diag(np.array(ground) + np.array([*between, 0.0]) + np.array([0.0, *between]))
    K -= np.diag(between, 1) + np.diag(between, -1)
    return K, np.array(masses)


def blades(path: Path) -> Iterator[tuple[str, Arrays]]:
    """The blade of a file with each number of modes, harmonics and samples."""
    with np.load(path) as file:
        omega, Phi, R, gap = (file[name] for name in ("omega", "Phi", "R", "gap"))
    for modes, harmonics, samples in BLADES:
        left_out = Phi[:, modes:] / omega[modes:]
        model = {
            "omega": omega[:modes],
            "Phi": Phi[:, :modes],
            "R": R + left_out @ left_out.T,
            "gap": gap,
        }
        size = {"energies": [0.2, 2.0, 0.2], "harmonics": harmonics, "samples": samples}
        yield f"J = {modes}, N = {harmonics}", {**model, **size}


def compare(ours: Outcome, base: Outcome) -> str:
    """How the points of this checkout differ from those of the other one."""
    found = {round(ratio, 9): (frequency, status) for ratio, frequency, status in ours.points}
    worse, moved = 0, 0.0
    for ratio, frequency, status in base.points:
        here, now = found.get(round(ratio, 9), (np.nan, "missing"))
        worse += status == "verified" != now
        if status == now == "verified":
            moved = max(moved, abs(here / frequency - 1))
    return f"{worse} no longer verified, verified frequencies differ by {moved:.0e}"


def report(name: str, model: Arrays, base: Path | None, scratch: Path) -> tuple[Outcome, ...]:
    """Follow a branch, with both checkouts if there are two, and print what it gave."""
    path = scratch / "model.npz"
    np.savez(path, **model)
    ours = followed(HERE, path)
    row = f"| {name} | {ours.seconds:.1f} | {ours.solves} | {ours.steps} | {ours.statuses} |"
    if base is None:
        print(row, flush=True)
        return (ours,)
    other = followed(base.resolve(), path)
    print(
        f"{row} {other.seconds:.1f} | {other.solves} | {other.steps} | {other.statuses} "
        f"| {ours.seconds / other.seconds:.2f} | {compare(ours, other)} |",
        flush=True,
    )
    return ours, other


def write(path: Path) -> None:
    """Keep the reduced model of the blade of demos/step."""
    from mpi4py import MPI

    from fenics_nnm.structure.analysis import linear_analysis
    from fenics_nnm.study.reading import read_values, study_from

    source = HERE / "demos" / "step" / "damped.toml"
    values = read_values(source)
    del values["damping"]
    model = linear_analysis(study_from(values, source), MPI.COMM_SELF).model
    np.savez(path, omega=model.omega, Phi=model.Phi, R=model.R, gap=model.gap)


def main() -> None:
    parser = argparse.ArgumentParser(description="Backbones through hard contact.")
    parser.add_argument("--chains", type=int, default=0, help="how many random chains")
    parser.add_argument("--first", type=int, default=0, help="number of the first chain")
    parser.add_argument("--blade", type=Path, help="file with the reduced model of the blade")
    parser.add_argument("--write", type=Path, help="write that file")
    parser.add_argument("--base", type=Path, help="another checkout, to compare with")
    chosen = parser.parse_args()
    if chosen.write:
        write(chosen.write)
    models = list(blades(chosen.blade)) if chosen.blade else []
    numbers = range(chosen.first, chosen.first + chosen.chains)
    models += [(f"chain {number}", chain(number)) for number in numbers]
    head = "| what | CPU s | solves | steps | points |"
    head += " base: CPU s | solves | steps | points | ratio | points |" if chosen.base else ""
    print(f"{head}\n{'|---' * head.count(' |')}|")
    with tempfile.TemporaryDirectory() as scratch:
        found = [report(*model, chosen.base, Path(scratch)) for model in models]
    for outcomes in zip(*found, strict=True):
        seconds = [outcome.seconds for outcome in outcomes]
        print(f"\nall: {sum(seconds):.1f} s; the longest: {max(seconds):.1f} s")


if __name__ == "__main__":
    main()
