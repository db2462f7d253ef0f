"""What is asked of a structure, be it a body on a mesh or matrices of another code."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, Protocol

from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.fem.blocks import Data
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.reduction.displacement_basis import DisplacementBasis
from fenics_nnm.reduction.flexibility import FlexibilitySource
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.stages import Stages
from fenics_nnm.structure.coriolis import Frequencies
from fenics_nnm.structure.damped_rows import DampedRows
from fenics_nnm.structure.driven_linear import DrivenLinear
from fenics_nnm.structure.first_contact import FirstContact
from fenics_nnm.study.casing import AnyCasing


@dataclass(frozen=True, slots=True)
class Outline:
    """What can be drawn of a structure before anything is computed of it.

    Attributes:
        mesh: Makes its mesh with named groups; to be called on all ranks.
        roles: What groups of facets are there for: "clamped" or "contact".
        casings: Casings by the number of their patch.
    """

    mesh: Callable[[MPI.Comm], TaggedMesh]
    roles: Mapping[str, str]
    casings: Mapping[int, AnyCasing]


class Structure(Protocol):
    """A structure as a study gives it."""

    @property
    def outline(self) -> Outline | None:
        """What can be drawn of it; None without a mesh."""

    def linear(self, comm: MPI.Comm, stages: Stages, *, at_most: int | None = None) -> Linear:
        """Find modes and attachment solutions, and reduce; to be called on all ranks.

        Args:
            comm: Communicator of the mesh.
            stages: Timings and progress.
            at_most: Number of modes in place of that of the study; fewer where the structure has
                fewer.

        Raises:
            MeshError: if the mesh lacks a group, or contact facets touch the clamp.
            ModelError: if matrices cannot be read or are not of a structure, the body or structure
                is not held, or it cannot be reduced as asked.
            ConvergenceError: if the eigensolver fails or misses a mode.
        """

    def driven(self, comm: MPI.Comm, stages: Stages) -> DrivenLinear:
        """What it is reduced to under the forces of its study; to be called on all ranks.

        Raises:
            MeshError, ModelError, ConvergenceError: as `linear`, or if a force acts where there
                is nothing to move.
        """

    def damped_rows(self, linear: Any) -> DampedRows:
        """Damping and driving forces in the modes of what is linear of it; on all ranks."""


class Moving(Protocol):
    """How far a structure moves; methods are to be called on all ranks."""

    def displacement_basis(self) -> DisplacementBasis:
        """Displacement of all nodes by the coordinates of the model, on rank 0."""

    def largest(self, q: Array, force: Array) -> str:
        """Largest displacement, with its unit, of coordinates in kg^1/2 m and forces in N."""


class Turning(Protocol):
    """What loads and speed change of the frequencies of a structure."""

    @property
    def coriolis(self) -> Array:
        """Circular frequencies of the lowest modes with Coriolis forces, which it leaves out.

        In rad/s, that of the mode of its study among them; empty without speed.
        """

    def frequencies(self) -> Frequencies:
        """Frequencies besides those of the modes: unloaded, and with Coriolis forces."""


class Linear(Moving, Turning, Protocol):
    """All that is linear of a structure; methods are to be called on all ranks."""

    @property
    def modes(self) -> LinearModes:
        """Linear modes."""

    @property
    def reduction(self) -> Reduction:
        """Reduced model, and the way back to the structure."""

    @property
    def model(self) -> ReducedModel:
        """Reduced model."""

    @property
    def body(self) -> LinearAnalysis | None:
        """The body on its mesh, to draw and to write fields of; None without a mesh."""

    def reduced_to(self, modes: LinearModes, reduction: Reduction) -> Linear:
        """The same structure with other modes and another reduction."""

    def with_contact(self, study: Any) -> Linear | None:
        """The same with the gaps of another study; None if its contact rows are others.

        Args:
            study: Study of the same structure without its contact, so one of the same kind.
        """

    def first_contact(self, mode: int) -> FirstContact:
        """First contact of a mode of an index from 0, of the contact points and of all places.

        Raises:
            ModelError: as `RestState.amplitude`.
        """

    def flexibility(self, harmonics: int) -> AbstractContextManager[FlexibilitySource] | None:
        """Residual flexibility of the whole model at N harmonics; None where there is none."""

    def sizes(self) -> dict[str, Any]:
        """Sizes for summary.json."""

    def data(self) -> Data:
        """Data sets for branch.h5."""

    def heading(self) -> list[str]:
        """Lines about the structure and its contact points."""

    def groups(self) -> list[str]:
        """Lines about named groups; none without a mesh."""

    def notes(self) -> list[str]:
        """Lines about what was left out or changed on reading its files."""

    def warnings(self, study: Any, mode: int) -> list[str]:
        """What looks like a wrong unit or direction in its study, a line each.

        Args:
            study: Its study, so one of its kind.
            mode: Index of the mode that is followed, from 0.
        """
