"""What many contact points cost: time by stage, memory, and exponents.

    environment/run python3 benchmarks/points.py

A beam of 12 726 degrees of freedom above an obstacle, of whose upper vertices some are contact
points: three energies, one with contact, with the check in time. Each number of points is a run in
a process of its own, so that its peak memory is its own. Times are CPU seconds of one thread.
"Told" is what the program says before it begins, on the clock of the machine at that time.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import json
import resource
import subprocess
import sys
import tempfile
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from large import timed_stages

POINTS = (100, 250, 500, 1000, 2000)
STAGES = ("attachments", "backbone", "output")

STUDY = """
mesh.model = "beam"
mesh.length_unit = "m"
mesh.length = 1.0
mesh.width = 0.2
mesh.height = 0.05
mesh.elements = [100, 20, 1]
body = { theory = "solid", degree = 1 }
material = { young = 210000000000.0, poisson = 0.3, density = 7800.0 }
clamp = { facets = "left" }
contact = { facets = "g", direction = [0.0, 0.0, 1.0], gap = 0.001, points = POINTS }
reduction = { modes = 10 }
mode = { harmonics = 5, samples = 64 }
continuation = { energies = { from = 0.9, to = 1.1, step = 0.1 }, shooting = false }
groups = { g = { facets = "top", box = { from = [0.015, -1, -1], to = [2, 1, 1] } } }
"""


def main() -> None:
    if len(sys.argv) > 1:
        print(json.dumps(measured(int(sys.argv[1]))))
        return
    print(f"| n_c | touched | {' | '.join(STAGES)} | all | peak GiB | told |")
    print("|" + "---|" * (len(STAGES) + 5))
    found = [told(points) for points in POINTS]
    print(f"\n| exponent | {' | '.join(STAGES)} | all |")
    print("|" + "---|" * (len(STAGES) + 2))
    for one, other in pairwise(found):
        print(exponents(one, other))


def told(points: int) -> dict[str, Any]:
    """A run in a process of its own, of which a row is printed."""
    command = [sys.executable, __file__, str(points)]
    ended = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    found = dict(json.loads(ended.stdout.splitlines()[-1]))
    numbers = " | ".join(f"{found[name]:.1f}" for name in (*STAGES, "all"))
    print(
        f"| {points} | {found['touched']} | {numbers} | {found['peak']:.2f} | {found['told']} |",
        flush=True,
    )
    return found


def exponents(one: dict[str, Any], other: dict[str, Any]) -> str:
    """A row of slopes of log(time) over log(points)."""
    grown = np.log(other["points"] / one["points"])
    slopes = " | ".join(
        f"{np.log(other[name] / one[name]) / grown:.2f}" for name in (*STAGES, "all")
    )
    return f"| {one['points']} to {other['points']} | {slopes} |"


def measured(points: int) -> dict[str, Any]:
    """CPU seconds of the stages and the peak memory of one run."""
    from fenics_nnm.run import run_study
    from fenics_nnm.study import read_study

    stages, lines = timed_stages(), []
    stages.tell = lines.append
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "study.toml"
        file.write_text(STUDY.replace("POINTS", str(points)))
        text = file.read_text()
        branch = run_study(read_study(file), text, Path(folder) / "r", stages=stages).branch
    touched = np.count_nonzero((branch.points[-1].motion.force > 0).any(axis=0))
    return {
        "points": points,
        "touched": int(touched),
        "all": sum(stages.timings.values()),
        "peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20,
        "told": lines[0].split(" from here")[0].rpartition("about ")[2] if lines else "",
        **stages.timings,
    }


if __name__ == "__main__":
    main()
