"""Costs of this checkout over those of another one, in pairs one after the other.

Run: environment/run python3 benchmarks/paired.py ../other [--pairs 7]

Each checkout is measured by its own benchmarks/newton.py and benchmarks/backbone.py, in a process
of its own, first the one and then the other, and the other way round in the next pair. Printed are
the medians of the ratios, this checkout over the other: CPU times of a Newton iteration, and of a
branch with its check in time. In a private root both checkouts must be below the current folder.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent.parent

#: What is measured: a name, and a program that prints one number.
NEWTON = (
    "from newton import BASE, SWEEPS, cost\nsize = {size}\ncost(size)\nprint(cost(size).median)"
)
BACKBONE = "from backbone import CASES, row\ncells = row(CASES[{case}]).split('|')\n"
BACKBONE += "print(float(cells[8]) + float(cells[9]))"
MEASURED = {
    "Newton iteration, J = 40, n_c = 24, N = 10": NEWTON.format(size="BASE"),
    "Newton iteration, N = 40": NEWTON.format(size="SWEEPS['N'][3]"),
    "Newton iteration, J = 160": NEWTON.format(size="SWEEPS['J'][3]"),
    "Newton iteration, n_c = 100": NEWTON.format(size="SWEEPS['n_c'][3]"),
    "backbone, J = 20, n_c = 12, N = 10": BACKBONE.format(case=1),
    "backbone, J = 40, n_c = 24, N = 10": BACKBONE.format(case=2),
}


def measured(checkout: Path, program: str) -> float:
    """The number that a program prints with the package and the benchmarks of a checkout."""
    paths = os.pathsep.join(map(str, (checkout / "benchmarks", checkout)))
    found = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": paths, "OMP_NUM_THREADS": "1"},
        cwd=checkout,
        capture_output=True,
        text=True,
        check=True,
    )
    return float(found.stdout.split()[-1])


def main() -> None:
    """Measure all pairs."""
    parser = argparse.ArgumentParser(description="Costs over those of another checkout.")
    parser.add_argument("other", type=Path, help="folder of the other checkout")
    parser.add_argument("--pairs", type=int, default=7)
    chosen = parser.parse_args()
    print("| what | this | other | ratio | smallest | largest |\n|---|---|---|---|---|---|")
    for name, program in MEASURED.items():
        pairs = []
        for number in range(chosen.pairs):
            both = [HERE, chosen.other.resolve()]
            order = both if number % 2 else both[::-1]
            times = {checkout: measured(checkout, program) for checkout in order}
            pairs.append([times[checkout] for checkout in both])
        this, other = np.median(pairs, axis=0)
        ratios = [one / two for one, two in pairs]
        print(
            f"| {name} | {this:.3g} | {other:.3g} | {np.median(ratios):.3f} "
            f"| {min(ratios):.3f} | {max(ratios):.3f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
