"""Matrices without their zeros: fewer entries, and products that are the same bit for bit."""

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from fenics_nnm.fem.block import product
from fenics_nnm.fem.sparsity import without_zeros


def test_zeros_of_a_mass_are_left_out_and_its_products_stay() -> None:
    rng = np.random.default_rng(3)
    of_nodes = rng.standard_normal((8, 8))
    of_nodes[2:4] = of_nodes[:, 2:4] = 0.0  # clamped: rows that are empty afterwards
    dense = np.kron(of_nodes, np.eye(3))
    first, columns = 24 * np.arange(25, dtype=np.int32), np.tile(np.arange(24, dtype=np.int32), 24)
    csr = (first, columns, dense.ravel())
    full = PETSc.Mat().createAIJ((24, 24), csr=csr, comm=MPI.COMM_SELF)
    few = without_zeros(full)
    assert full.getInfo()["nz_used"] == 24 * 24
    assert few.getInfo()["nz_used"] == 3 * 6 * 6
    block = np.asfortranarray(rng.standard_normal((24, 5)))
    assert np.array_equal(product(few, block), product(full, block))
    np.testing.assert_allclose(product(few, block), dense @ block, atol=1e-14)
