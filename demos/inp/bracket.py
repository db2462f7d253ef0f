# %% [markdown]
# # A bracket from an Abaqus or CalculiX input file
#
# An L-shaped bracket of hexahedra of 20 nodes (C3D20R), written as a preprocessor writes it: nodes,
# elements, a set of nodes that holds the foot, sets of elements for two materials, and a surface of
# element sides at the end of the arm. `bracket.toml` names them and follows the first mode against
# a stop below the arm.
#
# Run `python3 demos/inp/bracket.py`, which writes demos/inp/results/bracket.inp, then
# `fenics-nnm run demos/inp/bracket.toml`.

# %%
from pathlib import Path

import numpy as np

RESULTS = Path(__file__).parent / "results"

# %% [markdown]
# In mm: a leg of 10 x 20 x 60 along z, and an arm of 80 x 20 x 10 along x at its top, with a
# buffer of 10 x 20 x 5 below its end; elements are cubes of 5 mm. Nodes are
# numbered on a grid of half that size.

# %%
EDGE = 5.0
CELLS = [
    (i, j, k)
    for k in range(12)
    for j in range(4)
    for i in range(16)
    if i < 2 or k >= 10 or (i >= 14 and k == 9)  # leg, arm, buffer
]

#: Corners, then middle nodes, of an element in half edges, in the order of C3D20.
CORNERS = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
ENDS = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
ENDS += [(0, 4), (1, 5), (2, 6), (3, 7)]
NODES = np.array(CORNERS + [tuple(np.add(CORNERS[a], CORNERS[b]) // 2) for a, b in ENDS])


def number(place: np.ndarray) -> int:
    """Number of the node at a place of the grid."""
    return int(1 + place[0] + 100 * (place[1] + 100 * place[2]))


def rows(numbers: list[int]) -> list[str]:
    return [", ".join(map(str, numbers[i : i + 8])) + "," for i in range(0, len(numbers), 8)]


def write_inp(path: Path) -> None:
    nodes: dict[int, np.ndarray] = {}
    elements = []
    for cell in CELLS:
        places = 2 * np.array(cell) + NODES
        elements.append([number(place) for place in places])
        nodes.update({number(place): place * EDGE / 2 for place in places})
    foot = [n for n, x in nodes.items() if x[2] == 0]
    below = [e + 1 for e, (i, _, k) in enumerate(CELLS) if i >= 14 and k == 9]
    others = sorted(set(range(1, len(CELLS) + 1)) - set(below))
    lines = ["*HEADING", "Bracket in mm", "*NODE, NSET=Nall"]
    lines += [f"{n}, {x[0]:g}, {x[1]:g}, {x[2]:g}" for n, x in sorted(nodes.items())]
    lines += ["*ELEMENT, TYPE=C3D20R, ELSET=Eall"]
    for e, element in enumerate(elements):
        lines += [*rows([e + 1, *element])[:-1], rows([e + 1, *element])[-1].rstrip(",")]
    lines += ["*NSET, NSET=Foot", *rows(sorted(foot))]
    lines += ["*ELSET, ELSET=Buffer", *rows(below), "*ELSET, ELSET=Frame", *rows(others)]
    lines += ["*SURFACE, NAME=Pad, TYPE=ELEMENT", "Buffer, S1"]
    path.write_text("\n".join([*lines, "*STEP", "*FREQUENCY", "10", "*END STEP", ""]))


RESULTS.mkdir(exist_ok=True)
write_inp(RESULTS / "bracket.inp")
