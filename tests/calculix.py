"""Frequencies of CalculiX that tests/fem compares with, made anew.

    python3 tests/calculix.py     # needs ccx, of the package calculix-ccx

writes tests/reference/calculix.json and calculix_joined.json, of nodes that are joined. Where ccx
is not in the environment that has dolfinx, in three steps, the second one wherever ccx is:

    environment/run python3 tests/calculix.py --write /tmp/calculix
    for folder in /tmp/calculix/*; do (cd "$folder" && ccx a); done
    environment/run python3 tests/calculix.py --read /tmp/calculix
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from cell_boxes import box, write_inp
from constrained_beams import JOINED, joined

from fenics_nnm.fem.foreign_mesh import ForeignMesh

#: Where the figures are kept.
KEPT = Path(__file__).parent / "reference" / "calculix.json"

KEPT_JOINED = KEPT.with_name("calculix_joined.json")

#: A clamped beam of steel, 0.2 x 0.02 x 0.01 m.
YOUNG, POISSON, DENSITY = 2.1e11, 0.3, 7850.0

Kinds = Callable[[int], str]


def mixed(column: int) -> str:
    """Hexahedra and pairs of prisms by turns."""
    return ("hexahedron", "wedge")[column % 2]


#: Kinds of cells, order and numbers of cubes of each mesh.
MESHES: dict[str, tuple[Kinds, int, tuple[int, int, int]]] = {
    "C3D4": (lambda column: "tetra", 1, (8, 2, 1)),
    "C3D10": (lambda column: "tetra", 2, (8, 2, 1)),
    "C3D20": (lambda column: "hexahedron", 2, (8, 2, 1)),
    "C3D20, finer": (lambda column: "hexahedron", 2, (16, 2, 2)),
    "C3D15": (lambda column: "wedge", 2, (12, 2, 1)),
    "C3D15, finer": (lambda column: "wedge", 2, (16, 2, 2)),
    "C3D20 and C3D15": (mixed, 2, (12, 2, 1)),
    "C3D20 and C3D15, finer": (mixed, 2, (16, 2, 2)),
}


def mesh(name: str) -> ForeignMesh:
    """One of the meshes."""
    kinds, order, n = MESHES[name]
    found: ForeignMesh = box(n, kinds, lambda x: x * np.array([0.2, 0.02, 0.01]), order)
    return found


_STEP = f"""*MATERIAL, NAME=S
*ELASTIC
{YOUNG}, {POISSON}
*DENSITY
{DENSITY}
*SOLID SECTION, ELSET=Eall, MATERIAL=S
*BOUNDARY
low, 1, 3
*STEP
*FREQUENCY
4
*END STEP"""


def inputs() -> dict[Path, list[str]]:
    """Names of the beams by the file that keeps their frequencies."""
    return {KEPT: list(MESHES), KEPT_JOINED: list(JOINED)}


def written(folder: Path) -> list[Path]:
    """Write an a.inp for each beam, in a folder of its own below one."""
    for name in MESHES:
        place(folder, name).mkdir(parents=True, exist_ok=True)
        write_inp(mesh(name), place(folder, name) / "a.inp", _STEP)
    for name in JOINED:
        place(folder, name).mkdir(parents=True, exist_ok=True)
        (place(folder, name) / "a.inp").write_text(joined(name))
    return [place(folder, name) for names in inputs().values() for name in names]


def place(folder: Path, name: str) -> Path:
    """Folder of a beam below one."""
    return folder / re.sub(r"\W+", "_", name)


def frequencies(folder: Path) -> list[float]:
    """The lowest four that CalculiX wrote for the file a.inp of a folder, in Hz."""
    text = (folder / "a.dat").read_text()
    rows = re.findall(r"^ +\d+ +\S+ +\S+ +(\S+) +\S+ *$", text, re.MULTILINE)
    return [float(row) for row in rows[:4]]


def keep(folder: Path) -> None:
    """Keep what CalculiX wrote."""
    for path, names in inputs().items():
        found = {name: frequencies(place(folder, name)) for name in names}
        path.write_text(json.dumps(found, indent=1) + "\n")


def solve(folder: Path) -> None:
    """Write all files, have ccx solve them, and keep its figures."""
    for each in written(folder):
        subprocess.run(["ccx", "a"], cwd=each, check=True, capture_output=True)
    keep(folder)


def main() -> None:
    """Run the script."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", type=Path, metavar="FOLDER", help="write files for ccx only")
    parser.add_argument("--read", type=Path, metavar="FOLDER", help="read what ccx wrote only")
    arguments = parser.parse_args()
    if arguments.write:
        written(arguments.write)
    elif arguments.read:
        keep(arguments.read)
    else:
        with tempfile.TemporaryDirectory() as folder:
            solve(Path(folder))


if __name__ == "__main__":
    main()
