"""Beams of bricks with constraints, read in this process, and what CalculiX is compared on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from brick_beams import bricks, inp, nodes
from mpi4py import MPI
from scipy.optimize import brentq

from fenics_nnm.fem.clamp import Clamp
from fenics_nnm.fem.mesh import TaggedMesh, spread_mesh
from fenics_nnm.fem.mesh_file import ReadMesh
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.picking import Level, Pick, with_groups
from fenics_nnm.fem.regions import Region
from fenics_nnm.fem.solid import Body, Solid, assemble_solid
from fenics_nnm.materials.elasticity import Isotropic
from fenics_nnm.materials.material import Material
from fenics_nnm.reduction.linear_modes import LinearModes

#: Numbers of bricks along the axes.
N = (8, 2, 2)

YOUNG, POISSON, DENSITY = 2.1e11, 0.3, 7850.0


def numbers_at(x: float, n: tuple[int, int, int] = N) -> list[int]:
    """Numbers of the nodes at a place along the beam."""
    return [i + 1 for i, point in enumerate(nodes(n)) if abs(point[0] - x) < 1e-9]


def listed(numbers: list[int]) -> str:
    """Numbers on lines of ten."""
    rows = [numbers[i : i + 10] for i in range(0, len(numbers), 10)]
    return "\n".join(", ".join(map(str, row)) for row in rows)


TIP = numbers_at(0.2)
MIDDLE = numbers_at(0.1)
_TIP_BRICKS = [i + 1 for i, row in enumerate(bricks(N)) if set(row) & set(TIP)]

#: A reference node, one for rotations, the tip as nodes, bricks and surface, and a mass there.
_SETS = f"""*NODE, NSET=point
900, .22, .01, .005
901, .3, 0, 0
*NSET, NSET=tip
{listed(TIP)}
*NSET, NSET=held
{listed(numbers_at(0.0))}
*ELSET, ELSET=tipE
{listed(_TIP_BRICKS)}
*SURFACE, NAME=tipS, TYPE=ELEMENT
tipE, S4
"""
_MASS = """*ELEMENT, TYPE=MASS, ELSET=m
1000, 900
*MASS, ELSET=m
0.5
"""

#: Keywords that join nodes of the beam of `N` bricks.
JOINED = {
    "*COUPLING, *KINEMATIC with *MASS": f"{_SETS}{_MASS}"
    "*COUPLING, REF NODE=900, SURFACE=tipS, CONSTRAINT NAME=c\n*KINEMATIC\n1, 3\n",
    "*RIGID BODY of elements": f"{_SETS}{_MASS}"
    "*RIGID BODY, ELSET=tipE, REF NODE=900, ROT NODE=901\n",
    "*EQUATION": f"{_SETS}*EQUATION\n"
    f"3\n{TIP[0]}, 3, 1., {TIP[-1]}, 3, -.7, {MIDDLE[0]}, 2, .4\n"
    f"2\n{TIP[2]}, 1, 1., {MIDDLE[1]}, 1, -3.\n",
}

#: What CalculiX needs besides.
STEP = f"""*MATERIAL, NAME=S
*ELASTIC
{YOUNG}, {POISSON}
*DENSITY
{DENSITY}
*SOLID SECTION, ELSET=Eall, MATERIAL=S
*BOUNDARY
held, 1, 3
*STEP
*FREQUENCY
4
*END STEP"""


def joined(name: str) -> str:
    """A file of CalculiX."""
    return inp(JOINED[name] + STEP, N)


def read_here(path: Path, text: str, comm: MPI.Comm = MPI.COMM_SELF) -> TaggedMesh:
    """Read a file in this process, lengths in m."""
    path.write_text(text)
    return spread_mesh(lambda: ReadMesh(path)(path.parent), 1.0, comm)


def assembled(
    tagged: TaggedMesh, degree: int, *, poisson: float = POISSON, clamps: tuple[Clamp, ...] = ()
) -> Solid:
    """A beam of a file, clamped at x = 0."""
    whole = with_groups(tagged, {"root of the beam": Pick([Level(0, 0.0)])})
    region = Region(Material(Isotropic(YOUNG, poisson), DENSITY))
    body = Body("solid", (region,), degree=degree)
    return assemble_solid(whole, body, whole.facets["root of the beam"], clamps)


def modes(solid: Solid, count: int = 4) -> LinearModes:
    """The lowest modes."""
    with DirectModalSolver(solid) as solver:
        return solver.modes(count)


def rigid_misfit(places: np.ndarray, moved: np.ndarray) -> float:
    """How far motions (n, 3) of places (n, 3) are from that of a rigid body, over their size."""
    x = places - places.mean(axis=0)
    turns = [np.cross(axis, x).ravel() for axis in np.eye(3)]
    shifts = [np.tile(axis, len(x)) for axis in np.eye(3)]
    basis = np.array([*shifts, *turns]).T
    left = moved.ravel() - basis @ np.linalg.lstsq(basis, moved.ravel())[0]
    return float(np.linalg.norm(left) / np.linalg.norm(moved))


def cantilever(EI: float, rhoA: float, length: float, *, mass: float, inertia: float) -> float:
    """First frequency of a cantilever of Euler and Bernoulli with a rigid mass at its tip, in Hz.

    With w = A (cosh bx - cos bx) + B (sinh bx - sin bx), the moment at the tip is
    E I w_xx = omega^2 J w_x and the shear E I w_xxx = -omega^2 m w.
    """

    def determinant(b: float) -> float:
        squared, x = EI * b**4 / rhoA, b * length
        c, s, C, S = np.cos(x), np.sin(x), np.cosh(x), np.sinh(x)
        w, slope = np.array([C - c, S - s]), b * np.array([S + s, C - c])
        moment, shear = EI * b**2 * np.array([C + c, S + s]), EI * b**3 * np.array([S - s, C + c])
        rows = moment - squared * inertia * slope, shear + squared * mass * w
        return float(np.linalg.det(np.array(rows)))

    b = brentq(determinant, 0.01 / length, 1.8 / length)
    return float(b**2 * np.sqrt(EI / rhoA) / (2 * np.pi))
