"""Linear modes of rotor 37: block Lanczos against SLEPc's Krylov-Schur with the same factors.

    environment/run python3 benchmarks/modes.py 0.0018 0.0011 [--modes 40] [--blocks 8 12 16]

CPU seconds of both in one process, in turn; give OMP_NUM_THREADS=1. The last column is the largest
relative difference of frequencies. Without factors, attachments and the count of modes.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from large import study_text
from mpi4py import MPI

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


def by_slepc(inverse: Factored, count: int) -> Array:
    """Squared circular frequencies."""
    factors, mass = inverse.inverse, inverse.inverse.matrix_in_order(inverse.system.mass)
    eps = eigenproblem(factors.ksp.getOperators()[0], mass, "reference_")
    eps.getST().setKSP(factors.ksp)
    ask_for(eps, count + SPARE)
    eps.solve()
    found = [eps.getEigenvalue(index).real for index in range(eps.getConverged())]
    vector = mass.createVecRight()
    for index in range(count):
        eps.getEigenvector(index, vector)
    return np.sort(found)[:count]  # not destroyed: that would reset the factors of the next pair


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sizes", type=float, nargs="+", help="element sizes in m")
    parser.add_argument("--modes", type=int, default=40)
    parser.add_argument("--blocks", type=int, nargs="+", default=[block_lanczos.BLOCK])
    parser.add_argument("--pairs", type=int, default=3, help="how often each is timed")
    arguments = parser.parse_args()
    print(f"{'dofs':>9} {'block':>5} {'Lanczos s':>10} {'SLEPc s':>9} {'ratio':>6} {'differ':>8}")
    for size in arguments.sizes:
        solid = body(size)
        with DirectModalSolver(solid) as solver:
            inverse = solver.factored()
            for block in arguments.blocks:
                block_lanczos.BLOCK = block
                print(row(inverse, solid, arguments.modes, block, arguments.pairs), flush=True)


def row(inverse: Factored, solid: Solid, count: int, block: int, pairs: int) -> str:
    """Least CPU seconds of both, and how far their frequencies are apart."""
    own, other = [], []
    for _ in range(pairs):
        begun = time.process_time()
        squared = by_lanczos(inverse, solid.free, count)
        between = time.process_time()
        reference = by_slepc(inverse, count)
        own.append(between - begun)
        other.append(time.process_time() - between)
    differ = np.abs(np.sqrt(squared / reference) - 1).max()
    spent = f"{min(own):10.2f} {min(other):9.2f} {min(own) / min(other):6.3f}"
    return f"{solid.dofs:9d} {block:5d} {spent} {differ:8.1e}"


if __name__ == "__main__":
    main()
