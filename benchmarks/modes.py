"""Linear modes of rotor 37: block Lanczos against SLEPc's Krylov-Schur with the same factors.

    environment/run python3 benchmarks/modes.py 0.0018 0.0011 [--modes 40] [--blocks 8 12 16]

CPU seconds of both in one process, in turn; give OMP_NUM_THREADS=1. SLEPc has the mass as dolfinx
assembles it, with the pattern of the stiffness, and as this program does, without its zeros: two
times and two ratios. The last column is the largest relative difference of frequencies. Without
factors, attachments and the count of modes.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from large import study_text
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.fem import block_lanczos
from fenics_nnm.fem.block_lanczos import BlockLanczos
from fenics_nnm.fem.eigenproblem import ask_for, eigenproblem
from fenics_nnm.fem.factored import Factored
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.solid import Solid
from fenics_nnm.stages import Stages
from fenics_nnm.structure.mesh_structure import MeshStructure
from fenics_nnm.study import read_study

#: Modes beyond those asked for, of both.
SPARE = 4

#: Solvers of SLEPc, which would reset the factors of the next pair if they were destroyed.
KEPT: list[Any] = []


def body(size: float) -> Solid:
    """The blade with elements of a size in m."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "study.toml"
        file.write_text(study_text(size, "direct"))
        return MeshStructure(read_study(file)).assembled(MPI.COMM_WORLD, Stages()).solid


def by_lanczos(inverse: Factored, free: int, count: int) -> Array:
    """Squared circular frequencies."""
    lanczos = BlockLanczos(inverse, inverse.rows, free, count, SPARE)
    lanczos.run()
    lanczos.shapes(count)
    return np.sort(1 / lanczos.theta[:count])


def by_slepc(inverse: Factored, count: int, mass: PETSc.Mat) -> Array:
    """Squared circular frequencies."""
    factors = inverse.inverse
    eps = eigenproblem(factors.ksp.getOperators()[0], mass, "reference_")
    eps.getST().setKSP(factors.ksp)
    ask_for(eps, count + SPARE)
    eps.solve()
    found = [eps.getEigenvalue(index).real for index in range(eps.getConverged())]
    vector = mass.createVecRight()
    for index in range(count):
        eps.getEigenvector(index, vector)
    KEPT.append(eps)
    return np.sort(found)[:count]


def as_dolfinx_has_it(mass: PETSc.Mat, stiffness: PETSc.Mat) -> PETSc.Mat:
    """The mass with entries, which are zero, wherever the stiffness has some."""
    found = stiffness.copy()
    found.zeroEntries()
    found.axpy(1.0, mass, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
    found.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sizes", type=float, nargs="+", help="element sizes in m")
    parser.add_argument("--modes", type=int, default=40)
    parser.add_argument("--blocks", type=int, nargs="+", default=[block_lanczos.BLOCK])
    parser.add_argument("--pairs", type=int, default=3, help="how often each is timed")
    arguments = parser.parse_args()
    heads = f"{'SLEPc s':>9} {'ratio':>6} {'no zeros':>9} {'ratio':>6}"
    print(f"{'dofs':>9} {'block':>5} {'Lanczos s':>10} {heads} {'differ':>8}")
    for size in arguments.sizes:
        solid = body(size)
        with DirectModalSolver(solid) as solver:
            inverse = solver.factored()
            for block in arguments.blocks:
                block_lanczos.BLOCK = block
                print(row(inverse, solid, arguments.modes, block, arguments.pairs), flush=True)


def row(inverse: Factored, solid: Solid, count: int, block: int, pairs: int) -> str:
    """Least CPU seconds of both, and how far their frequencies are apart."""
    mass = inverse.inverse.matrix_in_order(inverse.system.mass)
    masses = as_dolfinx_has_it(mass, inverse.inverse.ksp.getOperators()[0]), mass
    own: list[float] = []
    others: tuple[list[float], list[float]] = [], []
    for _ in range(pairs):
        begun = time.process_time()
        squared = by_lanczos(inverse, solid.free, count)
        own.append(time.process_time() - begun)
        for each, other in zip(masses, others, strict=True):
            begun = time.process_time()
            reference = by_slepc(inverse, count, each)
            other.append(time.process_time() - begun)
    differ = np.abs(np.sqrt(squared / reference) - 1).max()
    least = min(own)
    spent = " ".join(f"{min(other):9.2f} {least / min(other):6.3f}" for other in others)
    return f"{solid.dofs:9d} {block:5d} {least:10.2f} {spent} {differ:8.1e}"


if __name__ == "__main__":
    main()
