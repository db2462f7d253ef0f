"""A whole nonlinear analysis beside the linear modes of CalculiX, on the same mesh of rotor 37.

    python3 benchmarks/calculix.py 0.0018 0.0011 [--pairs 2]

needs ccx (apt-get install calculix-ccx).

Each pair is a run of `large.py` (mesh to files, 30 points, four motions), in the environment, and
40 modes by ccx, one after the other, each with one thread. Times are CPU seconds of the whole
process with its start, of the user and of the system. Caches of the program are off; its modules
are compiled before, as they are where it is installed. Both must have the same frequencies to
1e-3: CalculiX integrates the mass with four points an element,
which changes high modes most.
This script needs no package, so that it runs wherever ccx is; "--write FOLDER SIZE", which it runs
itself in the environment, writes the mesh for ccx.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent

#: How many modes both compute.
MODES = 40

#: Nodes of a quadratic tetrahedron of Basix (middles of edges 23, 13, 12, 03, 02, 01) as C3D10
#: has them (01, 12, 02, 03, 13, 23).
C3D10 = [0, 1, 2, 3, 9, 6, 8, 7, 5, 4]

#: Nodes of a C3D10 with the first two corners exchanged.
MIRRORED = [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]

#: One thread each, and nothing that an earlier run has kept.
ENVIRONMENT = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "CCX_NPROC_EQUATION_SOLVER"), "1"
) | {"FENICS_NNM_CACHE": "off"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sizes", type=float, nargs="+", help="element sizes in m")
    parser.add_argument("--pairs", type=int, default=2, help="runs of each, in turn")
    parser.add_argument("--write", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.write:
        write_input(arguments.write / "a.inp", arguments.sizes[0])
        return
    print("| dofs | fenics_nnm, all (s) | CalculiX, 40 modes (s) | ratio | frequencies |")
    print("|---|---|---|---|---|", flush=True)
    for size in arguments.sizes:
        print(row(size, arguments.pairs), flush=True)


def row(size: float, pairs: int) -> str:
    """The row of a mesh."""
    with tempfile.TemporaryDirectory(dir=ROOT) as name:
        folder = Path(name)
        seconds(["environment/run", "python3", "-m", "compileall", "-q", "fenics_nnm"])
        seconds(["environment/run", "python3", __file__, "--write", name, str(size)])
        large = ["environment/run", "python3", "benchmarks/large.py", "--child", str(size)]
        ours, other = [], []
        for _ in range(pairs):
            spent, told = seconds(large)
            ours.append(spent)
            other.append(seconds(["ccx", "a"], folder)[0])
        found = json.loads(told.splitlines()[-1])
        apart = difference(found["linear_Hz"], calculix_frequencies(folder))
    shares = [one / two for one, two in zip(ours, other, strict=True)]
    return (
        f"| {found['dofs']} | {listed(ours)} | {listed(other)} |"
        f" {statistics.median(shares):.2f} ({min(shares):.2f} to {max(shares):.2f}) | {apart:.1e} |"
    )


def seconds(command: list[str], folder: Path = ROOT) -> tuple[float, str]:
    """CPU seconds of a command and of all that it starts, and what it prints."""
    before = spent()
    ended = subprocess.run(
        command, cwd=folder, env={**os.environ, **ENVIRONMENT}, stdout=subprocess.PIPE, text=True
    )
    if ended.returncode:
        sys.exit(f"{' '.join(command)} ended with exit code {ended.returncode}")
    return spent() - before, ended.stdout


def spent() -> float:
    """CPU seconds of all children that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def difference(ours: list[float], other: list[float]) -> float:
    """Largest relative difference of frequencies; ends the program where it is over 1e-3."""
    apart = max(abs(one / two - 1) for one, two in zip(ours, other, strict=True))
    if apart > 1e-3:
        sys.exit(f"frequencies are {apart:.1e} apart: not the same body")
    return apart


def listed(values: list[float]) -> str:
    """Seconds, to a tenth."""
    return ", ".join(f"{value:.1f}" for value in values)


def calculix_frequencies(folder: Path) -> list[float]:
    """Frequencies in Hz that ccx wrote into a.dat."""
    text = (folder / "a.dat").read_text()
    rows = re.findall(r"^ +\d+ +\S+ +\S+ +(\S+) +\S+ *$", text, re.MULTILINE)
    return [float(each) for each in rows[:MODES]]


def write_input(file: Path, size: float) -> None:
    """Write the blade with elements of this size in m as an input of CalculiX."""
    import numpy as np
    from modes import body

    solid: Any = body(size)
    x = solid.space.tabulate_dof_coordinates()
    cells = solid.space.dofmap.list[:, C3D10]
    edges = x[cells[:, 1:4]] - x[cells[:, :1]]
    mirrored = np.linalg.det(edges) < 0
    cells[mirrored] = cells[mirrored][:, MIRRORED]
    held = np.unique(solid.clamped // 3) + 1
    material = solid.regions.parts[0][0]
    with file.open("w") as out:
        # CalculiX reads 20 characters of a number, so more digits would cut off exponents.
        out.write("*NODE, NSET=Nall\n")
        out.writelines(f"{n}, {a:.12g}, {b:.12g}, {c:.12g}\n" for n, (a, b, c) in enumerate(x, 1))
        out.write("*ELEMENT, TYPE=C3D10, ELSET=Eall\n")
        out.writelines(f"{n}, {', '.join(map(str, row))}\n" for n, row in enumerate(cells + 1, 1))
        out.write("*NSET, NSET=held\n")
        out.writelines(f"{n},\n" for n in held)
        out.write(
            f"*MATERIAL, NAME=M\n*ELASTIC\n{material.law.young}, {material.law.poisson}\n"
            f"*DENSITY\n{material.density}\n*SOLID SECTION, ELSET=Eall, MATERIAL=M\n"
            f"*BOUNDARY\nheld, 1, 3\n*STEP\n*FREQUENCY, SOLVER=SPOOLES\n{MODES}\n*END STEP\n"
        )


if __name__ == "__main__":
    main()
