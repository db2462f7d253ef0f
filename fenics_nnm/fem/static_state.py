"""Static state of a body under steady loads, geometrically exact.

First all loads are tried at once, with the factors of the stiffness of the unloaded body
(`fem.loads_at_once`). Steps with them are accelerated (`fem.anderson`), and what they end at counts
if its tangent stiffness is positive definite: the same factors show it (`fem.least_ratio`), or
those of the tangent stiffness do that modes are found with, which costs nothing more.

Else Newton's method takes over, and the loads are applied in parts as large as it takes. A step of
the load is refused if it does not converge, ends where the tangent stiffness is not positive
definite (the body buckles on the way), turns cells inside out, there or in its linear prediction,
or goes much farther than that (it snaps through to another state).
"""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
from petsc4py import PETSc

from fenics_nnm.arrays import Array
from fenics_nnm.errors import Code, ConvergenceError, ModelError, OutOfMemoryError
from fenics_nnm.fem.block import solved
from fenics_nnm.fem.cached_state import StepsTaken, keeper_of
from fenics_nnm.fem.factorisation import (
    ROOT_ALONE,
    factorise,
    limited_memory,
    negative_pivots,
    use_mumps,
)
from fenics_nnm.fem.inside_out import turned_inside_out
from fenics_nnm.fem.loaded_residual import LoadedResidual
from fenics_nnm.fem.loads import Loads
from fenics_nnm.fem.loads_at_once import LoadsAtOnce
from fenics_nnm.fem.parallel import HeldTogether
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.state import StaticState
from fenics_nnm.fem.system import FreeSystem

logger = logging.getLogger(__name__)

#: Newton's method has converged when a step is this part of the displacement, or when steps of the
#: second part of it do not get smaller any more, by round-off.
_ACCURACY, _ROUND_OFF = 1e-10, 1e-7

#: A step that is more than this part of the one before asks for a new tangent stiffness.
_CONTRACTING = 0.3

#: It diverges when a step is so many times its first one; it fails after so many steps.
_DIVERGING, _MOST_STEPS = 1e6, 40

#: A step of the load that moves the body by more than this times its linear prediction is halved.
_FARTHER = 3.0

#: The smallest part of the loads that is applied at once.
_LEAST = 2.0**-9


class _Refused(Exception):
    """A load step that does not lead to a state to go on from; its text says why."""


def loaded(
    solid: Solid, loads: Loads, memory: float | None = None, *, proven: bool = True
) -> Solid:
    """A body about its state under loads, with its tangent stiffness there; called on all ranks.

    Args:
        solid: Assembled body, without loads.
        loads: Loads.
        memory: Memory in bytes that a rank may take for factors; no limit if None.
        proven: Whether its stiffness must be known to be positive definite. Else it is up to the
            caller to look at it, and to call `loaded_in_parts` if it is not.

    PETSc options take the prefix `nnm_static_`.

    Raises:
        ConvergenceError: if the loads cannot be applied in full; it says which part of them can.
        MeshError, ModelError: if a load does not go with the body.
    """
    if solid.system.keys:
        raise ModelError(
            f"{solid.system.keys[0]}: constraints hold for small rotations, and under steady loads "
            "a body turns too far for them",
            code=Code.STEADY_LOADS,
        )
    residual = LoadedResidual(solid, loads)
    keeper = keeper_of(solid, residual, proven)
    found = keeper.restored()
    if found is None:
        with _Newton(solid, residual, memory) as newton:
            found = newton.loaded(proven)
        keeper.keep(found)
    return _about(solid, loads, residual, found)


def loaded_in_parts(solid: Solid, memory: float | None = None) -> Solid:
    """A body about a state whose stiffness is not positive definite, about one where it is.

    Its loads are applied by Newton's method, in parts. To be called on all ranks.

    Args:
        solid: Body about its state under loads.
        memory: Memory in bytes that a rank may take for factors; no limit if None.

    Raises:
        ConvergenceError: if the loads cannot be applied in full; it says which part of them can.
    """
    state = solid.state
    assert state is not None
    system = FreeSystem(state.unloaded, solid.mass)
    bare = replace(solid, stiffness=state.unloaded, system=system, state=None)
    residual = LoadedResidual(bare, state.loads)
    keeper = keeper_of(bare, residual, proven=False)
    with _Newton(bare, residual, memory) as newton:
        found = newton.loaded_in_parts()
    keeper.keep(found)
    return _about(bare, state.loads, residual, found)


def _about(solid: Solid, loads: Loads, residual: LoadedResidual, found: StepsTaken) -> Solid:
    """The body about the state that its residual is at, with the tangent assembled there."""
    state = StaticState(
        loads=loads,
        displacement=residual.displacement,
        unloaded=solid.stiffness,
        steps=found.solutions,
        load_steps=found.load_steps,
        asymmetry=residual.asymmetry,
    )
    stiffness = residual.tangent
    system = FreeSystem(stiffness, solid.mass)
    return replace(solid, stiffness=stiffness, system=system, state=state)


class _Newton(HeldTogether):
    """Newton's method for the residual of a body."""

    def __init__(self, solid: Solid, residual: LoadedResidual, memory: float | None) -> None:
        super().__init__(solid.tagged.mesh.comm)
        self._solid, self._residual, self._memory = solid, residual, memory
        self._ksp = PETSc.KSP().create(solid.stiffness.comm)
        self._ksp.setOptionsPrefix("nnm_static_")
        self._steps = 0

    def release(self) -> None:
        """Free the factorisation."""
        self._ksp.destroy()

    def loaded(self, proven: bool) -> StepsTaken:
        """Move the residual to the state under all loads, and assemble its tangent there.

        Args:
            proven: Whether the tangent must be known to be positive definite.
        """
        residual = self._residual
        with LoadsAtOnce(self._solid, residual, self._memory) as at_once:
            if at_once.found() and (not proven or at_once.firm()):
                return StepsTaken(at_once.steps, 1)
        residual.move(np.zeros(self._solid.owned))
        return self.loaded_in_parts()

    def loaded_in_parts(self) -> StepsTaken:
        """The same by Newton's method from u = 0, in as many parts as it needs."""
        reached, step, count = 0.0, 1.0, 0
        while reached < 1.0:
            level, before = min(1.0, reached + step), self._residual.owned.copy()
            try:
                self._apply(level)
            except _Refused as refusal:
                self._residual.move(before)
                step /= 2
                if step < _LEAST:
                    raise _failure(reached, refusal) from refusal
                logger.info("loads in steps of %g, as %s", step, refusal)
                continue
            reached, count, step = level, count + 1, 2 * step
        self._residual.assemble()
        return StepsTaken(self._steps, count)

    def _apply(self, level: float) -> None:
        """Newton's method at a part of the loads, from the displacement before.

        Raises:
            _Refused: if it leads nowhere.
        """
        residual = self._residual
        residual.apply(level)
        start, first, last, anew = residual.owned.copy(), 0.0, np.inf, True
        for _ in range(_MOST_STEPS):
            if anew:
                self._factorise(residual.assemble())
            change = self._step()
            moved = residual.norm(change)
            first = first or moved
            if not np.isfinite(moved) or moved > _DIVERGING * first:
                raise _Refused("Newton's method diverges")
            residual.move(residual.owned + change)
            self._steps += 1
            if np.isinf(last) and turned_inside_out(residual.displacement):
                raise _Refused("the body turns inside out")
            whole = residual.norm(residual.owned)
            anew = moved > _CONTRACTING * last or np.isinf(last)
            if moved <= _ACCURACY * whole or (anew and moved <= _ROUND_OFF * whole):
                break
            last = moved
        else:
            raise _Refused("Newton's method does not converge")
        if residual.norm(residual.owned - start) > _FARTHER * first:
            raise _Refused("the body snaps through")
        if negative_pivots(self._ksp):
            raise _Refused("the body buckles")
        if turned_inside_out(residual.displacement):
            raise _Refused("the body turns inside out")

    def _step(self) -> Array:
        """Newton's next change of the displacement in m, shape (n_owned,).

        Raises:
            _Refused: if there is none.
        """
        try:
            return solved(self._ksp, -self._residual.value()[:, None])[:, 0]
        except ConvergenceError as error:
            raise _Refused("Newton's method diverges") from error

    def _factorise(self, stiffness: PETSc.Mat) -> None:
        """Factorise a stiffness, for the steps that follow.

        Raises:
            _Refused: if it is singular.
            OutOfMemoryError: if there is too little memory for its factors.
        """
        self._ksp.setOperators(stiffness)
        use_mumps(self._ksp, (ROOT_ALONE,))
        try:
            with limited_memory(self._ksp, self._memory):
                factorise(self._ksp)
        except OutOfMemoryError:
            raise
        except ConvergenceError as error:
            raise _Refused("its tangent stiffness is singular") from error


def _failure(reached: float, why: _Refused) -> ConvergenceError:
    held = "" if reached else ", or held in more directions"
    return ConvergenceError(
        f"static state: {reached:.1%} of the steady loads can be applied: beyond that {why}: they "
        f"must be less, or the body stiffer{held}",
        code=Code.STEADY_LOADS,
    )
