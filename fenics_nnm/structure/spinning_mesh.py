"""A body on a mesh at the speeds of a Campbell diagram."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.fem.block import product
from fenics_nnm.fem.contact_sites import contact_sites
from fenics_nnm.fem.gyroscopic import coriolis_frequencies
from fenics_nnm.fem.linear import operators_of
from fenics_nnm.fem.memory import memory_of_rank
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.static_state import loaded
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import with_reference
from fenics_nnm.structure.assembled import Assembled, factored
from fenics_nnm.structure.contact_patches import contact_patches
from fenics_nnm.structure.kinematics import Reached, asked_of_study
from fenics_nnm.structure.loading import loads_of
from fenics_nnm.structure.mesh_structure import MeshStructure
from fenics_nnm.structure.point_choice import evenly_spread
from fenics_nnm.structure.spinning import SPARE, Spin, SpinModes
from fenics_nnm.structure.structure import Linear
from fenics_nnm.study import MeshStudy


@dataclass(frozen=True, slots=True)
class SpinningMesh:
    """A body that is meshed and assembled once.

    Attributes:
        study: Study with a section [rotation].
        plain: The body without speed and loads.
    """

    study: MeshStudy
    plain: Assembled

    @classmethod
    def of(cls, study: MeshStudy, comm: MPI.Comm, stages: Stages) -> SpinningMesh:
        """The body of a study; to be called on all ranks."""
        bare = study.model_copy(update={"rotation": None, "load": None})
        return cls(study, MeshStructure(bare).assembled(comm, stages))

    def inner(self, left: Array, right: Array) -> Array:
        """a^T b over all ranks, of two blocks of columns at the degrees of freedom."""
        comm: MPI.Intracomm = self.plain.solid.tagged.mesh.comm
        return np.asarray(comm.allreduce(left.T @ right))

    def at(self, speed: float, count: int) -> Spin:
        """The body at a speed, see `structure.campbell`; to be called on all ranks."""
        loaded_body = self._loaded(mesh_spun(self.study, speed))
        assembled, solver = factored(loaded_body, DirectModalSolver)
        solid = assembled.solid
        with solver:
            modes = solver.modes(min(count + SPARE, solid.free))
            omega = _with_coriolis(assembled, modes, solver)
        momenta, gap = product(solid.mass, modes.shapes), float(assembled.sites.gap.min())
        found = SpinModes(speed, omega / (2 * np.pi), modes.shapes, momenta, gap)
        return Spin(assembled.study, _analysing(assembled), found)

    def _loaded(self, study: MeshStudy) -> Assembled:
        """The body at the speed of a study."""
        solid = self.plain.solid
        if study.loaded:
            memory = memory_of_rank(solid.tagged.mesh.comm, study.solver.memory)
            solid = loaded(solid, loads_of(study, solid), memory, proven=False)
        sites = contact_sites(solid, contact_patches(study, solid.tagged))
        return Assembled(study, solid, sites)


def _analysing(assembled: Assembled) -> Any:
    """Finds what is linear of an assembled body, as `linear_analysis`."""

    def analyse(
        study: MeshStudy,
        comm: MPI.Comm,
        stages: Stages | None = None,
        *,
        at_most: int | None = None,
        reached: Reached = asked_of_study,
    ) -> Linear:
        body = replace(assembled, study=study, reached=reached)
        found = MeshStructure(study).reduced(body, stages or Stages(), at_most=at_most)
        return with_reference(found, study)

    return analyse


def _with_coriolis(assembled: Assembled, modes: LinearModes, solver: DirectModalSolver) -> Array:
    """Circular frequencies in rad/s, with Coriolis forces if the study asks for them."""
    solid, study = assembled.solid, assembled.study
    if not (study.coriolis and study.speed and solid.state is not None):
        return modes.omega
    rotation = solid.state.loads.rotation
    assert rotation is not None
    operators = operators_of(solid, assembled.interface(evenly_spread(assembled.sites)), solver)
    return coriolis_frequencies(solid, rotation, modes, operators)


def mesh_spun(study: MeshStudy, speed: float) -> MeshStudy:
    """The study at another speed in rad/s; casings grow with its square."""
    assert study.rotation is not None
    rotation = study.rotation.model_copy(update={"speed": speed, "rpm": None})
    own = study.speed
    contact = _at(study, (speed / own) ** 2 if own else 0.0)
    return study.model_copy(update={"rotation": rotation, "contact": contact})


def _at(study: MeshStudy, factor: float) -> Any:
    """The contact section with the growth of its casings times a factor."""
    contact = study.contact
    if "patch" not in type(contact).model_fields:
        return _grown(contact, factor)
    patches = tuple(_grown(patch, factor) for patch in contact.patches.values())
    return contact.model_copy(update={"patch": patches})


def _grown(patch: Any, factor: float) -> Any:
    growth = getattr(patch.casing, "growth", 0.0)
    if not growth:
        return patch
    casing = patch.casing.model_copy(update={"growth": growth * factor})
    return patch.model_copy(update={"casing": casing})
