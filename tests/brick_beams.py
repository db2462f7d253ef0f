"""Beams of bricks in files of Abaqus, Nastran, Ansys and VTK, written by hand."""

from __future__ import annotations

from typing import Any

import numpy as np

SIZE = (0.2, 0.02, 0.01)


def nodes(n: tuple[int, int, int]) -> Any:
    """Nodes of a beam of n bricks, x fastest."""
    axes = [np.linspace(0, size, k + 1) for size, k in zip(SIZE, n, strict=True)]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()])


def bricks(n: tuple[int, int, int]) -> list[list[int]]:
    """Nodes of each brick from 1, in the order of Abaqus and Nastran."""
    a, b = n[0] + 1, (n[0] + 1) * (n[1] + 1)
    cells = []
    for k in range(n[2]):
        for j in range(n[1]):
            for i in range(n[0]):
                base = 1 + i + j * a + k * b
                low = [base, base + 1, base + 1 + a, base + a]
                cells.append([*low, *(node + b for node in low)])
    return cells


def inp(rest: str = "", n: tuple[int, int, int] = (4, 1, 1)) -> str:
    lines = ["*NODE, NSET=Nall"]
    lines += [", ".join(map(str, (i + 1, *x))) for i, x in enumerate(nodes(n).tolist())]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=Eall"]
    lines += [", ".join(map(str, (i + 1, *row))) for i, row in enumerate(bricks(n))]
    return "\n".join([*lines, rest, ""])


def bdf(rest: str = "", n: tuple[int, int, int] = (4, 1, 1)) -> str:
    lines = ["BEGIN BULK"]
    lines += [f"GRID,{i + 1},,{x},{y},{z}" for i, (x, y, z) in enumerate(nodes(n).tolist())]
    for i, row in enumerate(bricks(n)):
        lines += [f"CHEXA,{i + 1},1," + ",".join(map(str, row[:6])) + ",+", f"+,{row[6]},{row[7]}"]
    return "\n".join([*lines, "PSOLID,1,1", "MAT1,1,2.1+11,,.3,7850.", rest, "ENDDATA", ""])


def cdb(
    rest: str = "", n: tuple[int, int, int] = (4, 1, 1), *, kind: int = 185, width: int = 9
) -> str:
    """An archive of Ansys with elements of one type."""
    lines = ["/COM,ANSYS RELEASE", "/PREP7", f"ET,1,{kind}", "NBLOCK,6,SOLID", "(3i9,6e21.13e3)"]
    for i, x in enumerate(nodes(n).tolist()):
        lines.append(f"{i + 1:9d}{0:9d}{0:9d}" + "".join(f"{value:21.13E}" for value in x))
    lines += ["N,R5.3,LOC,       -1,", eblock(bricks(n), width)]
    return "\n".join([*lines, rest, "FINISH", ""])


def eblock(cells: list[list[int]], width: int = 9, first: int = 1) -> str:
    """Elements of type 1 and material 1, 8 nodes on the first line."""
    lines = ["EBLOCK,19,SOLID", f"(19i{width})"]
    for i, row in enumerate(cells):
        head = [1, 1, 1, 1, 0, 0, 0, 0, len(row), 0, first + i]
        for part in ([*head, *row[:8]], row[8:]):
            lines += ["".join(f"{value:{width}d}" for value in part)] if part else []
    return "\n".join([*lines, f"{-1:9d}"])
