"""One small mesh written in the formats of several programs, by hand where that is short."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import gmsh
import meshio
import numpy as np
from small_meshes import saved_model

#: Shapes of cells by dimension; the order of the elements follows.
SHAPES = {"triangle": 2, "quad": 2, "tetra": 3, "hexahedron": 3}


def box(path: Path, shape: str, order: int, *, complete: bool = True) -> None:
    """A box, or a rectangle, with the groups body, left and right; edges bulge for order 2."""
    dim = SHAPES[shape]
    with saved_model(path):
        occ = gmsh.model.occ
        if dim == 2:
            occ.addRectangle(0, 0, 0, 1, 0.25)
        else:
            occ.addBox(0, 0, 0, 1, 0.25, 0.125)
        occ.synchronize()
        if shape in ("quad", "hexahedron"):
            gmsh.model.mesh.setTransfiniteAutomatic(recombine=True)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.25)
        gmsh.option.setNumber("Mesh.MeshSizeMin", 0.25)
        for name, x in (("left", 0.0), ("right", 1.0)):
            found = gmsh.model.getEntitiesInBoundingBox(x - 0.01, -1, -1, x + 0.01, 1, 1, dim - 1)
            gmsh.model.addPhysicalGroup(dim - 1, [tag for _, tag in found], name=name)
        gmsh.model.addPhysicalGroup(dim, [1], name="body")
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 0 if complete else 1)
        gmsh.model.mesh.generate(dim)
        gmsh.model.mesh.setOrder(order)
        if order == 2:
            _bulge()


def _bulge() -> None:
    """Move the nodes a little, so that elements of order 2 are curved."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    for tag, (x, y, z) in zip(tags, coordinates.reshape(-1, 3), strict=True):
        rise = 0.0625 * x * (1 - x)
        gmsh.model.mesh.setNode(tag, [x, y + rise, z + (rise * y if z else 0)], [])


def read(path: Path) -> tuple[np.ndarray, dict[str, np.ndarray], dict[str, dict[str, np.ndarray]]]:
    """Points, cells by kind, and rows of each group by kind, of a .msh file."""
    mesh = meshio.read(path)
    groups: dict[str, dict[str, np.ndarray]] = {}
    for name, (tag, _) in mesh.field_data.items():
        for kind, values in mesh.cell_data_dict["gmsh:physical"].items():
            if (values == tag).any():
                groups.setdefault(name, {})[kind] = np.flatnonzero(values == tag)
    return mesh.points, mesh.cells_dict, groups


ABAQUS = {
    "tetra": "C3D4",
    "tetra10": "C3D10",
    "hexahedron": "C3D8R",
    "hexahedron20": "C3D20R",
    "triangle": "CPS3",
    "triangle6": "CPS6",
    "quad": "CPS4R",
    "quad8": "CPS8R",
}


def inp(msh: Path, path: Path) -> None:
    """Abaqus: "left" as a set of nodes, "right" as a set named through another one."""
    points, cells, groups = read(msh)
    lines = ["** written by hand", "*HEADING", "a box, *NODE here is text", "*NODE, NSET=ALL"]
    lines += [f"{i + 10}, {x!r}, {y!r}, {z!r}" for i, (x, y, z) in enumerate(points.tolist())]
    lines += ["99999, 5.0, 5.0, 5.0"]  # a reference point, which is no node of an element
    number = 100
    for kind, rows in cells.items():
        if kind in groups["body"]:
            lines += [f"*Element, type={ABAQUS[kind]}, ELSET=Eall"]
            for row in rows.tolist():
                lines += _wrapped([number, *(n + 10 for n in row)])
                number += 1
    for name in ("left", "right"):
        ((kind, rows),) = groups[name].items()
        nodes = np.unique(cells[kind][rows]) + 10
        lines += [f"*NSET, NSET={name}_nodes", *_wrapped(nodes.tolist())]
        lines += [f"*NSET, NSET={name}", f"{name}_nodes"]
    path.write_text("\n".join([*lines, "*NSET, NSET=corner", "10", "*STEP", "*FREQUENCY", "4", ""]))


def _wrapped(numbers: list[int]) -> list[str]:
    parts = [numbers[i : i + 11] for i in range(0, len(numbers), 11)]
    lines = [", ".join(map(str, part)) for part in parts]
    return [f"{line}," for line in lines[:-1]] + lines[-1:]


#: Nastran's card and VTK's place of each of its nodes.
NASTRAN = {
    "tetra": ("CTETRA", [0, 1, 2, 3]),
    "tetra10": ("CTETRA", list(range(10))),
    "hexahedron": ("CHEXA", list(range(8))),
    "hexahedron20": ("CHEXA", [*range(12), 16, 17, 18, 19, 12, 13, 14, 15]),
    "triangle": ("CTRIA3", [0, 1, 2]),
    "triangle6": ("CTRIA6", list(range(6))),
    "quad": ("CQUAD4", [0, 1, 2, 3]),
    "quad8": ("CQUAD8", list(range(8))),
}


def bdf(msh: Path, path: Path) -> None:
    """Nastran: properties 1, 2 and 3 for body, left and right, named by HyperMesh's comments."""
    points, cells, groups = read(msh)
    lines = ["SOL 103", "CEND", "BEGIN BULK"]
    lines += [f'$HMNAME COMP {i + 1:20d}"{name}"' for i, name in enumerate(groups)]
    for i, (x, y, z) in enumerate(points.tolist()):
        lines += [f"GRID*   {i + 1:16d}{'':16}{x:16.10f}{y:16.10f}*", f"*       {z:16.10f}"]
    number = 1
    for pid, kinds in enumerate(groups.values(), start=1):
        for kind, rows in kinds.items():
            card, order = NASTRAN[kind]
            for row in cells[kind][rows]:
                fields = [number, pid, *(row[order] + 1)]
                parts = [fields[:8], *(fields[i : i + 8] for i in range(8, len(fields), 8))]
                lines += [
                    f"{card if not i else '+':8}" + "".join(f"{n:8d}" for n in part)
                    for i, part in enumerate(parts)
                ]
                number += 1
    path.write_text("\n".join([*lines, "ENDDATA", ""]))


def vtu(msh: Path, path: Path) -> None:
    """VTK: an array "part" of whole numbers on the cells: 1 body, 2 left, 3 right."""
    points, cells, groups = read(msh)
    parts = {kind: np.zeros(len(rows), dtype=np.int64) for kind, rows in cells.items()}
    for name, value in (("body", 1), ("left", 2), ("right", 3)):
        for kind, rows in groups[name].items():
            parts[kind][rows] = value
    meshio.Mesh(points, cells, cell_data={"part": list(parts.values())}).write(path)


def med(msh: Path, path: Path) -> None:
    """MED: families of cells; one of them belongs to two groups."""
    points, cells, groups = read(msh)
    tags = {kind: np.zeros(len(rows), dtype=np.int64) for kind, rows in cells.items()}
    for name, family in (("body", -1), ("left", -2), ("right", -3)):
        for kind, rows in groups[name].items():
            tags[kind][rows] = family
    mesh = meshio.Mesh(points, cells, cell_data={"cell_tags": list(tags.values())})
    mesh.cell_tags = {-1: ["body"], -2: ["left"], -3: ["right", "tip"]}
    mesh.point_tags = {}
    mesh.write(path, file_format="med")


def unv(msh: Path, path: Path) -> None:
    """Universal file of I-deas, by gmsh."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(msh))
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


WRITERS: dict[str, Callable[[Path, Path], None]] = {
    "inp": inp,
    "bdf": bdf,
    "vtu": vtu,
    "med": med,
    "unv": unv,
}

#: Name of the groups left and right in a file.
NAMES = {"vtu": ("part=2", "part=3")}
