"""Displacements of the unknowns of matrices, from branch.h5."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.pairs import Pairs
from fenics_nnm.results import branch_file


@dataclass(frozen=True, slots=True)
class UnknownShapes:
    """What displacements of n unknowns are made of: u = shapes q - residual_shapes lambda.

    Attributes:
        shapes: Displacement per modal coordinate in kg^-1/2, shape (J, n).
        residual_shapes: Displacement per contact force in m/N, shape (n_c, n).
        bent_shapes: theta_ij of pairs of masters in 1/(kg m), shape (p, n).
    """

    shapes: Array
    residual_shapes: Array
    bent_shapes: Array

    def displaced(self, model: ReducedModel, q: Array, force: Array) -> Array:
        """Displacement in m of modal coordinates (s, J) and forces in N (s, n_c), shape (s, n)."""
        masters = model.kinematics.masters
        products = Pairs.of(len(masters)).products(q[:, masters], q[:, masters])
        bent = products @ self.bent_shapes if len(masters) else 0.0
        return np.asarray(q @ self.shapes - force @ self.residual_shapes + bent)


def stored_shapes(path: Path) -> UnknownShapes:
    """The shapes in the file of a run of matrices.

    Raises:
        OutputError: if it cannot be read.
    """
    with branch_file.reading(path), h5py.File(path, "r") as file:
        basis = file["basis"]
        bent = basis["bent_shapes"][:] if "bent_shapes" in basis else np.empty((0, 0))
        return UnknownShapes(basis["shapes"][:], basis["residual_shapes"][:], bent)
