"""Square plate of test SDLS01, of solid elements; prints its frequencies on three meshes.

python3 tests/square_plate.py
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
from mpi4py import MPI
from numpy.polynomial import legendre
from scipy.linalg import eigh

from fenics_nnm.fem.attachments import Attachment
from fenics_nnm.fem.mesh import generate_mesh
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.regions import Region
from fenics_nnm.fem.solid import Body, assemble_solid
from fenics_nnm.geometry import Beam
from fenics_nnm.materials.elasticity import Isotropic
from fenics_nnm.materials.material import Material

REFERENCE = Path(__file__).parent / "reference" / "sdls01_square_plate.csv"
YOUNG, POISSON, DENSITY, THICKNESS = 2.1e11, 0.3, 7800.0, 0.01

#: Frequency in Hz that soft springs give the rigid motions of the free plate.
RIGID = 0.5


def published(support: str) -> np.ndarray:
    """Values of Leissa (1973) in Hz: Ritz's method with beam functions."""
    lines = (line for line in REFERENCE.read_text().splitlines() if not line.startswith("#"))
    return np.array([float(r["f_ref_Hz"]) for r in csv.DictReader(lines) if r["bc"] == support])


def thin_plate(support: str, count: int, terms: int = 14) -> np.ndarray:
    """Frequencies of the thin plate in Hz, without rigid motions.

    Ritz's method with products of Legendre polynomials on [-1, 1]^2, so the side a is 2; times
    (1 + x)^2 for a side x = -1 that is clamped.
    """
    clamped = support == "CFFF"
    # (1 + x)^2 = 4/3 P_0 + 2 P_1 + 2/3 P_2
    X, X0, X1, X2 = _integrals([4 / 3, 2.0, 2 / 3] if clamped else [1.0], terms)
    Y, Y0, Y1, Y2 = _integrals([1.0], terms)
    mixed = np.kron(X0, Y0.T) + np.kron(X0.T, Y0)
    bending = np.kron(X2, Y) + np.kron(X, Y2) + POISSON * mixed
    twisting = 2 * (1 - POISSON) * np.kron(X1, Y1)
    squares = eigh(bending + twisting, np.kron(X, Y), eigvals_only=True)
    rigid = 0 if clamped else 3
    stiffness = YOUNG * THICKNESS**3 / 12 / (1 - POISSON**2)
    unit = np.sqrt(stiffness / (DENSITY * THICKNESS)) / (2 * np.pi)
    return unit * 4 * np.sqrt(squares[rigid : rigid + count])


def _integrals(factor: list[float], terms: int) -> list[np.ndarray]:
    """Integrals of products of two of the functions: P P, P P'', P' P', P'' P''."""
    points, weights = legendre.leggauss(terms + 4)
    rows = [legendre.legmul(factor, unit) for unit in np.eye(terms)]
    P, dP, ddP = (
        np.array([legendre.legval(points, legendre.legder(row, k)) for row in rows])
        for k in range(3)
    )
    pairs = ((P, P), (P, ddP), (dP, dP), (ddP, ddP))
    return [(left * weights) @ right.T for left, right in pairs]


def solid_plate(support: str, elements: int) -> np.ndarray:
    """Frequencies in Hz of quadratic hexahedra, as many as published; six rigid ones if free.

    The free plate lies on soft springs; they add less than (RIGID / f)^2 / 2 to any other
    frequency f.
    """
    beam = Beam(
        length=1.0,
        width=1.0,
        height=THICKNESS,
        elements=(elements, elements, 1),
        cells="hexahedron",
    )
    tagged = generate_mesh(beam, MPI.COMM_SELF)
    free, count = support == "FFFF", len(published(support))
    soft = DENSITY * THICKNESS * (2 * np.pi * RIGID) ** 2
    springs = Attachment("spring[1]", "spring", (soft,) * 3, facets=("bottom",), per_area=True)
    steel = Region(Material(Isotropic(YOUNG, POISSON), DENSITY))
    clamped = tagged.facets_of(("left",), "clamp.facets")[: 0 if free else None]
    body = Body("solid", (steel,), attachments=(springs,) if free else ())
    with DirectModalSolver(assemble_solid(tagged, body, clamped)) as solver:
        return solver.modes(count + 6 * free).frequencies


def tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")


def main() -> None:
    """Print the smallest and largest difference from both references on each mesh, in percent."""
    tell("docs: square_plate")
    tell(
        "| support and modes | elements, or Leissa's values | difference from Leissa (%) "
        "| difference from converged thin plate (%) |"
    )
    tell("|---|---|---|---|")
    for support, name in (("CFFF", "clamped on one side, six modes"), ("FFFF", "free, five modes")):
        reference = published(support)
        thin = thin_plate(support, len(reference))
        tell(f"| {name} | Leissa's values | | {difference(reference, thin)} |")
        for elements in (12, 20, 30):
            found = solid_plate(support, elements)[-len(reference) :]
            parts = (difference(found, reference), difference(found, thin))
            tell(f"| {name} | {elements} x {elements} elements | {parts[0]} | {parts[1]} |")
    tell("")


def difference(found: np.ndarray, exact: np.ndarray) -> str:
    part = (found / exact - 1) * 100
    return f"{part.min():.2f} to {part.max():.2f}"


if __name__ == "__main__":
    main()
