"""Modes of a beam by iteration on the ranks that run this; rank 0 writes them to a file."""

import sys
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import read_study

linear = linear_analysis(read_study(Path(sys.argv[1])), MPI.COMM_WORLD)
if MPI.COMM_WORLD.rank == 0:
    static = linear.model.static_flexibility
    np.savez(sys.argv[2], omega=linear.modes.omega, static=static, R=linear.model.R)
