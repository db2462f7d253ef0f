"""Frequencies of CalculiX that tests/fem compares with, made anew.

    python3 tests/calculix.py     # needs ccx, of the package calculix-ccx

writes tests/reference/calculix.json and calculix_joined.json, of nodes that are joined.
"""

from __future__ import annotations

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


def frequencies(name: str) -> list[float]:
    """The lowest four of CalculiX in Hz."""
    with tempfile.TemporaryDirectory() as folder:
        write_inp(mesh(name), Path(folder) / "a.inp", _STEP)
        return solved(Path(folder))


def frequencies_joined(name: str) -> list[float]:
    """Those of one of the beams whose nodes are joined."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "a.inp").write_text(joined(name))
        return solved(Path(folder))


def solved(folder: Path) -> list[float]:
    """The lowest four of the file a.inp in a folder."""
    subprocess.run(["ccx", "a"], cwd=folder, check=True, capture_output=True)
    text = (folder / "a.dat").read_text()
    rows = re.findall(r"^ +\d+ +\S+ +\S+ +(\S+) +\S+ *$", text, re.MULTILINE)
    return [float(row) for row in rows[:4]]


if __name__ == "__main__":
    found = {KEPT: {name: frequencies(name) for name in MESHES}}
    found[KEPT_JOINED] = {name: frequencies_joined(name) for name in JOINED}
    for path, values in found.items():
        path.write_text(json.dumps(values, indent=1) + "\n")
