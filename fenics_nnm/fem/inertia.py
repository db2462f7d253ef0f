"""Counting modes by Sylvester's law of inertia."""

from __future__ import annotations

import logging

import numpy as np
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.errors import Code, ModelError, OutOfMemoryError
from fenics_nnm.fem.factorisation import (
    ROOT_ALONE,
    factorise,
    limited_memory,
    negative_pivots,
    use_mumps,
)
from fenics_nnm.fem.parts import parts_that_move
from fenics_nnm.fem.solid import Solid
from fenics_nnm.reduction.linear_modes import counted, counting_shift

logger = logging.getLogger(__name__)

#: MUMPS's ICNTL(31) = 1: the factors are thrown away as they are made. A count needs none.
_DISCARD = ("mat_mumps_icntl_31", 1)

#: A squared frequency below this part of the highest one computed is a rigid-body mode.
_RIGID = 1e-9


def assert_held(solid: Solid, squared: Array) -> None:
    """Refuse a body that can move as a rigid body.

    Args:
        solid: Assembled body.
        squared: Its lowest squared circular frequencies; infinite where they are lost in the
            round-off of lower ones.

    Raises:
        ModelError: if some of them are zero to round-off.
    """
    limit = _RIGID * np.abs(squared).max()
    rigid = int(np.count_nonzero(np.isfinite(squared) & (squared <= limit)))
    if rigid:
        raise ModelError(
            f"{rigid} rigid-body modes found: the body is not held; "
            "name facets that hold it, or springs that are stiff enough"
            f"{parts_that_move(solid)}",
            code=Code.NOT_HELD,
        )


def counted_below(solid: Solid, squared: Array, count: int, memory: float | None) -> float:
    """Count the eigenvalues below the first gap after `count` modes by Sylvester's law.

    Args:
        solid: Assembled body.
        squared: Squared circular frequencies found, ascending.
        count: Number of modes wanted.
        memory: Memory in bytes that a rank may take; no limit if None.

    Returns:
        Circular frequency in rad/s below which none was missed; 0 if that was not found out, for
        want of memory or of a gap.

    Raises:
        ConvergenceError: if a mode was missed.
    """
    shift, inside = counting_shift(squared, count)
    if inside == 0:
        return 0.0
    try:
        negative = modes_below(solid, shift, memory)
    except OutOfMemoryError as error:
        logger.warning("modes are not counted, as memory is short: one might be missed: %s", error)
        return 0.0
    return counted(shift, inside, negative)


def modes_below(solid: Solid, shift: float, memory: float | None = None) -> int:
    """Number of eigenvalues of (K, M) below `shift`, from a factorisation of K - shift M.

    It takes a quarter of the memory of one that is kept. PETSc options take the prefix
    `nnm_inertia_`.

    Args:
        solid: Assembled body.
        shift: Squared circular frequency in rad^2/s^2.
        memory: Memory in bytes that a rank may take; no limit if None.

    Raises:
        OutOfMemoryError: if that is not enough.
        ConvergenceError: if there is no factorisation for another reason.
    """
    shifted = solid.system.stiffness.copy()
    shifted.axpy(-shift, solid.system.mass, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
    shifted.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    ksp = PETSc.KSP().create(shifted.comm)
    ksp.setOptionsPrefix("nnm_inertia_")
    ksp.setOperators(shifted)
    use_mumps(ksp, (_DISCARD, ROOT_ALONE))
    try:
        with limited_memory(ksp, memory):
            factorise(ksp)
        return negative_pivots(ksp)
    finally:
        ksp.destroy()
        shifted.destroy()
