"""Which solver finds the modes of a body: by factors of its stiffness, or by iteration."""

from __future__ import annotations

import logging
from typing import Literal

from fenics_nnm.errors import Code, ModelError, OutOfMemoryError
from fenics_nnm.fem.iterative_modes import IterativeModalSolver
from fenics_nnm.fem.memory import memory_of_rank
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.solid import Solid

logger = logging.getLogger(__name__)

ModalSolver = DirectModalSolver | IterativeModalSolver
"""Finds modes and static displacements of a body."""


def modal_solver(
    solid: Solid,
    linear: Literal["auto", "direct", "iterative"] = "auto",
    memory: float | None = None,
) -> ModalSolver:
    """The solver asked for; "auto" is direct if the factors fit in memory.

    Whether they fit is known from the factorisation's own analysis of the matrix.

    Args:
        solid: Assembled body.
        linear: Kind of solver.
        memory: Memory in GiB that the ranks of a machine may take for factors; if not given, most
            of what is free.

    Raises:
        ModelError: if the stiffness cannot be factorised, or the body not be iterated on.
        OutOfMemoryError: if the factors do not fit and "direct" is asked for.
    """
    own = memory_of_rank(solid.tagged.mesh.comm, memory)
    if linear == "iterative":
        return IterativeModalSolver(solid, own)
    try:
        return DirectModalSolver(solid, own)
    except OutOfMemoryError as error:
        lacking = f"the factors of the stiffness do not fit into memory ({error})"
        if linear == "direct":
            raise OutOfMemoryError(
                f"{lacking}: must have more memory for factors, or the iterative solver",
                code=Code.MEMORY,
            ) from error
        if solid.system.keys:
            raise OutOfMemoryError(
                f"{lacking}, and constraints ({solid.system.keys[0]}) leave no iterative solver: "
                "must have more memory for factors",
                code=Code.MEMORY_OF_FACTORS,
            ) from error
        if solid.body.degree < 2:
            raise ModelError(
                f"{lacking}, and degree = {solid.body.degree} leaves no iterative solver",
                code=Code.DEGREE_WITHOUT_MEMORY,
            ) from error
        logger.warning("%s: iterating instead", lacking)
    return IterativeModalSolver(solid, own)
