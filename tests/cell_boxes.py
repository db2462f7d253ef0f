"""Boxes of hexahedra, prisms, pyramids and tetrahedra, of order 1 or 2, and files of them."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from fenics_nnm.fem.cell_shapes import shape_of
from fenics_nnm.fem.foreign_mesh import ForeignMesh

Place = Callable[[np.ndarray], np.ndarray]

#: A cube as two wedges, six pyramids about its centre or itself; nodes as of a hexahedron of VTK.
CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]] * 2) + 0.0
CUBE[4:, 2] = 1
TETRAHEDRA = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
WEDGES = [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]


def box(n: tuple[int, int, int], kind: Callable[[int], str], place: Place, order: int) -> Any:
    """A box of n cubes, each a hexahedron, two wedges or six pyramids, moved by `place`.

    Args:
        n: Numbers of cubes.
        kind: From the number of a column of cubes along z to their kind, as "wedge".
        place: From points of the unit cube to those of the body.
        order: 1 or 2.
    """
    row: dict[tuple[float, ...], int] = {}

    def node(x: np.ndarray) -> int:
        return row.setdefault(tuple(np.round(x, 9)), len(row))

    cells: dict[str, list[list[int]]] = {}
    for cube in product(*(range(k) for k in n)):
        corners = (CUBE + cube) / n
        for name, part in parts(kind(cube[0] * n[1] + cube[1]), corners):
            shape = shape_of(name)
            nodes = [node(x) for x in part]
            if order == 2:
                nodes += [node((part[a] + part[b]) / 2) for a, b in shape.edges]
                name += {"hexahedron": "20", "wedge": "15", "pyramid": "13", "tetra": "10"}[name]
            cells.setdefault(name, []).append(nodes)
    x = np.array(list(row))
    ends = {"low": np.flatnonzero(x[:, 0] == 0), "high": np.flatnonzero(x[:, 0] == 1)}
    kinds = {name: np.array(rows) for name, rows in cells.items()}
    sets = {name: {name: np.arange(len(rows))} for name, rows in kinds.items()}
    return ForeignMesh(place(x), kinds, sets, ends)


def parts(kind: str, corners: np.ndarray) -> list[tuple[str, np.ndarray]]:
    if kind == "hexahedron":
        return [(kind, corners)]
    if kind == "tetra":
        return [(kind, corners[list(rows)]) for rows in TETRAHEDRA]
    if kind == "wedge":
        return [(kind, corners[rows]) for rows in WEDGES]
    middle = corners.mean(axis=0)
    faces = [list(face)[::-1] for face in shape_of("hexahedron").faces]
    if kind == "pyramid":
        return [(kind, np.array([*corners[face], middle])) for face in faces]
    raise ValueError(kind)


#: Types of elements of Abaqus and CalculiX.
_ABAQUS = {
    **{"tetra": "C3D4", "tetra10": "C3D10", "hexahedron": "C3D8", "hexahedron20": "C3D20"},
    **{"wedge": "C3D6", "wedge15": "C3D15"},
}
_VTK = {
    **{"tetra": 10, "tetra10": 24, "hexahedron": 12, "hexahedron20": 25, "wedge": 13},
    **{"wedge15": 26, "pyramid": 14, "pyramid13": 27},
}
_NASTRAN = {"tetra": "CTETRA", "hexahedron": "CHEXA", "wedge": "CPENTA", "pyramid": "CPYRAM"}
_NASTRAN_ORDER = {
    "hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
}

#: Places in a wedge of the nodes of a hexahedron that it is written as by Ansys.
_SHRUNK = [0, 1, 2, 2, 3, 4, 5, 5]
_SHRUNK_MIDDLES = [6, 7, 2, 8, 9, 10, 5, 11, 12, 13, 14, 14]


def write_inp(foreign: ForeignMesh, path: Path, more: str = "") -> None:
    """Abaqus and CalculiX, with the sets of nodes."""
    lines = ["*NODE, NSET=Nall"]
    lines += [", ".join(map(str, (i + 1, *x))) for i, x in enumerate(foreign.points.tolist())]
    number = 1
    for kind, rows in foreign.cells.items():
        lines += [f"*ELEMENT, TYPE={_ABAQUS[kind]}, ELSET=Eall"]
        for row in rows.tolist():
            lines += _wrapped([number, *(node + 1 for node in row)])
            number += 1
    for name, nodes in foreign.node_sets.items():
        lines += [f"*NSET, NSET={name}", *(f"{node + 1}," for node in nodes.tolist())]
    path.write_text("\n".join([*lines, more, ""]))


def _wrapped(numbers: list[int]) -> list[str]:
    parts = [", ".join(map(str, numbers[i : i + 12])) for i in range(0, len(numbers), 12)]
    return [f"{part}," for part in parts[:-1]] + parts[-1:]


def write_bdf(foreign: ForeignMesh, path: Path) -> None:
    """Nastran in free fields."""
    lines = ["BEGIN BULK"]
    for i, (x, y, z) in enumerate(foreign.points.tolist()):
        lines.append(f"GRID,{i + 1},,{x:.12g},{y:.12g},{z:.12g}")
    number = 1
    for kind, rows in foreign.cells.items():
        for row in rows[:, _NASTRAN_ORDER.get(kind, list(range(rows.shape[1])))] + 1:
            fields = [number, 1, *row.tolist()]
            parts = [fields[i : i + 8] for i in range(0, len(fields), 8)]
            card = _NASTRAN[kind.rstrip("0123456789")]
            starts = [card, *["+"] * (len(parts) - 1)]
            lines += [
                ",".join(map(str, (start, *part)))
                for start, part in zip(starts, parts, strict=True)
            ]
            number += 1
    path.write_text("\n".join([*lines, "ENDDATA", ""]))


def write_vtu(foreign: ForeignMesh, path: Path) -> None:
    """VTK, in text."""
    rows = [(_VTK[kind], row) for kind, found in foreign.cells.items() for row in found.tolist()]
    arrays = {
        "connectivity": [node for _, row in rows for node in row],
        "offsets": np.cumsum([len(row) for _, row in rows]).tolist(),
        "types": [kind for kind, _ in rows],
    }
    cells = "".join(
        f'<DataArray type="Int64" Name="{name}" format="ascii">{" ".join(map(str, values))}'
        "</DataArray>"
        for name, values in arrays.items()
    )
    points = " ".join(map(repr, foreign.points.ravel().tolist()))
    path.write_text(
        '<VTKFile type="UnstructuredGrid" version="1.0"><UnstructuredGrid><Piece><Points>'
        f'<DataArray type="Float64" NumberOfComponents="3" format="ascii">{points}</DataArray>'
        f"</Points><Cells>{cells}</Cells></Piece></UnstructuredGrid></VTKFile>"
    )


def write_cdb(foreign: ForeignMesh, path: Path) -> None:
    """Ansys: SOLID185, 186 and 187, prisms as hexahedra with nodes that stand twice."""
    quadratic = any(rows.shape[1] > 8 for rows in foreign.cells.values())
    lines = ["/PREP7", f"ET,1,{186 if quadratic else 185}", "ET,2,187", "NBLOCK,6,SOLID"]
    lines.append("(3i9,6e21.13e3)")
    for i, x in enumerate(foreign.points.tolist()):
        lines.append(f"{i + 1:9d}{0:9d}{0:9d}" + "".join(f"{value:21.13E}" for value in x))
    lines += ["N,R5.3,LOC,       -1,", "EBLOCK,19,SOLID", "(19i9)"]
    number = 1
    for kind, rows in foreign.cells.items():
        order = list(range(rows.shape[1]))
        if kind.startswith("wedge"):
            order = _SHRUNK + (_SHRUNK_MIDDLES if quadratic else [])
        for row in (rows[:, order] + 1).tolist():
            head = [1, 2 if kind == "tetra10" else 1, 1, 1, 0, 0, 0, 0, len(row), 0, number]
            for part in ([*head, *row[:8]], row[8:]):
                lines += ["".join(f"{value:9d}" for value in part)] if part else []
            number += 1
    path.write_text("\n".join([*lines, f"{-1:9d}", ""]))
