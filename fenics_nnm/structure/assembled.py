"""A body before its modes are known, and its factors, which show whether its state is stable."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

from fenics_nnm.fem.contact import ContactInterface, interface_at
from fenics_nnm.fem.contact_sites import ContactSites, contact_sites
from fenics_nnm.fem.memory import memory_of_rank
from fenics_nnm.fem.modal_solver import ModalSolver
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.static_state import loaded_in_parts
from fenics_nnm.structure.contact_patches import contact_patches
from fenics_nnm.structure.kinematics import Reached, asked_of_study
from fenics_nnm.structure.loading import assert_off_axis
from fenics_nnm.structure.point_choice import Choices, chosen_of
from fenics_nnm.study import MeshStudy

Solver = TypeVar("Solver", bound=ModalSolver)


@dataclass(frozen=True, slots=True)
class Assembled:
    """A body before its contact points are chosen, on all ranks.

    Attributes:
        study: Study.
        solid: Assembled body.
        sites: Vertices of the contact patches.
        reached: Largest energy of its branch, which decides about its kinematics.
    """

    study: MeshStudy
    solid: Solid
    sites: ContactSites
    reached: Reached = asked_of_study

    @property
    def mode(self) -> int:
        """Index of the mode that is followed, from 0."""
        return self.study.mode.number - 1

    def interface(self, choices: Choices) -> ContactInterface:
        """Contact points of a choice."""
        return interface_at(self.solid, self.sites, chosen_of(choices))


def factored(
    assembled: Assembled, solver_of: Callable[[Solid], Solver]
) -> tuple[Assembled, Solver]:
    """A body and its modal solver; to be called on all ranks.

    If its static state turns out not to be stable, the loads are applied again, in parts.

    Args:
        assembled: Body about its static state, which may not be known to be stable.
        solver_of: Makes the solver.

    Raises:
        ConvergenceError: if there is no stable state of all loads that parts of them lead to.
    """
    solver = solver_of(assembled.solid)
    if assembled.solid.state is None or not solver.negative:
        return assembled, solver
    solver.release()
    stable = _in_parts(assembled)
    return stable, solver_of(stable.solid)


def _in_parts(assembled: Assembled) -> Assembled:
    """The body about the state that parts of its loads lead to."""
    study, solid = assembled.study, assembled.solid
    memory = memory_of_rank(solid.tagged.mesh.comm, study.solver.memory)
    solid = loaded_in_parts(solid, memory)
    assert solid.state is not None
    sites = contact_sites(solid, contact_patches(study, solid.tagged))
    assert_off_axis(solid.state.loads, sites)
    return replace(assembled, solid=solid, sites=sites)
