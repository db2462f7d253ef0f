"""A structure that is a body on a mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.fem.blocks import Data
from fenics_nnm.fem.cached_modes import kept_modes
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.contact_sites import ContactSites, contact_sites
from fenics_nnm.fem.deflection import BodyForces
from fenics_nnm.fem.driven import Others, driven_places
from fenics_nnm.fem.gathering import gathered_basis, gathering
from fenics_nnm.fem.gyroscopic import coriolis_frequencies
from fenics_nnm.fem.harmonic import HarmonicSolver
from fenics_nnm.fem.kept_mesh import StoredMesh
from fenics_nnm.fem.linear import (
    LinearAnalysis,
    craig_bampton_reduced,
    massless_reduced,
    operators_of,
)
from fenics_nnm.fem.memory import memory_of_rank
from fenics_nnm.fem.modal_solver import ModalSolver, modal_solver
from fenics_nnm.fem.patch_summary import patch_summaries
from fenics_nnm.fem.solid import Solid, assemble_solid
from fenics_nnm.fem.static_state import loaded
from fenics_nnm.reduction.displacement_basis import DisplacementBasis
from fenics_nnm.reduction.driven import driven_basis
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.stages import Stages
from fenics_nnm.structure.assembled import Assembled, factored
from fenics_nnm.structure.bending import Bending
from fenics_nnm.structure.body import body_of, dashpots_of, excitations_of, monitors_of
from fenics_nnm.structure.clamps import clamped_facets, other_clamps
from fenics_nnm.structure.contact_patches import contact_patches
from fenics_nnm.structure.coriolis import Frequencies
from fenics_nnm.structure.damped_body import rows_of_body
from fenics_nnm.structure.damped_rows import DampedRows
from fenics_nnm.structure.driven_body import DrivenBody
from fenics_nnm.structure.driven_coriolis import turning
from fenics_nnm.structure.driven_kinematics import bent_modes, modal_motions, with_kinematics
from fenics_nnm.structure.expected_time import MANY, Costs, expectation
from fenics_nnm.structure.first_contact import FirstContact
from fenics_nnm.structure.frequencies import frequencies_of
from fenics_nnm.structure.group_table import facet_counts, group_table
from fenics_nnm.structure.kinematics import (
    asked_of_study,
    bending_of,
    can_choose,
    chosen_kind,
    in_choice,
)
from fenics_nnm.structure.kinematics_lines import kinematics_lines
from fenics_nnm.structure.load_lines import load_lines
from fenics_nnm.structure.loading import assert_followers_apart, assert_off_axis, loads_of
from fenics_nnm.structure.material_lines import attachment_lines, material_lines
from fenics_nnm.structure.mesh_data import with_mesh
from fenics_nnm.structure.mesh_notes import report_notes
from fenics_nnm.structure.meshing import tagged_mesh
from fenics_nnm.structure.mode_count import mode_count
from fenics_nnm.structure.motions import least_motions
from fenics_nnm.structure.passing_casings import gap_motion_of
from fenics_nnm.structure.point_choice import (
    Choices,
    approach_of,
    chosen_about_rest,
    chosen_by_mode,
    chosen_of,
    evenly_spread,
    same_points,
)
from fenics_nnm.structure.rigid_facets import rigid_lines
from fenics_nnm.structure.sanity import mesh_warnings
from fenics_nnm.structure.structure import Outline
from fenics_nnm.study import MeshStudy

#: Coriolis forces of so many of the lowest modes are dealt with, and of all up to the followed one.
_COUPLED = 6

#: Where points are pressed at rest, contact points are chosen anew at most so many times.
_MORE_CHOICES = 4


@dataclass(frozen=True, slots=True)
class MeshStructure:
    """The body of a study; all ranks deal with it together.

    Attributes:
        study: Study.
        stored: Its mesh as an earlier run has kept it, if it is to be that.
    """

    study: MeshStudy
    stored: StoredMesh | None = None

    @property
    def outline(self) -> Outline:
        """Mesh, roles of its groups and casings."""
        patches = self.study.contact.patches.values()
        clamp = self.study.clamped
        touching = [name for patch in patches for name in (*patch.facets, *(patch.against or ()))]
        casings = {n: patch.casing for n, patch in enumerate(patches) if patch.casing is not None}
        return Outline(
            mesh=lambda comm: tagged_mesh(self.study, comm),
            roles=dict.fromkeys(clamp, "clamped") | dict.fromkeys(touching, "contact"),
            casings=casings,
        )

    def linear(self, comm: MPI.Comm, stages: Stages, *, at_most: int | None = None) -> MeshLinear:
        """As `Structure.linear`: mesh, assemble, find modes and attachment solutions, reduce."""
        assembled = self.assembled(comm, stages, proven=False)
        return self.reduced(assembled, stages, at_most=at_most)

    def reduced(
        self, assembled: Assembled, stages: Stages, *, at_most: int | None = None
    ) -> MeshLinear:
        """As `linear`, of a body that is assembled."""
        with stages.stage("factors"):
            assembled, found = factored(assembled, partial(_modal_solver, self.study))
        with found as solver:
            return _reduced(assembled, solver, stages, at_most)

    def driven(self, comm: MPI.Comm, stages: Stages) -> DrivenBody:
        """As `Structure.driven`."""
        assembled = self.assembled(comm, stages, proven=False)
        with stages.stage("factors"):
            assembled, found = factored(assembled, partial(_modal_solver, self.study))
        with found as solver:
            return _driven(assembled, solver, stages)

    def damped_rows(self, linear: LinearAnalysis) -> DampedRows:
        """As `Structure.damped_rows`."""
        return rows_of_body(linear, self.study)

    def assembled(self, comm: MPI.Comm, stages: Stages, *, proven: bool = True) -> Assembled:
        """The body about its static state, with the vertices that can become contact points.

        Args:
            comm: Communicator.
            stages: Timings and progress.
            proven: Whether the state must be known to be stable; else `factored` finds it out.
        """
        study = self.study
        with stages.stage("mesh"):
            tagged = tagged_mesh(study, comm, self.stored)
            clamped, clamps = clamped_facets(study, tagged), other_clamps(study, tagged.dim)
            patches = contact_patches(study, tagged)
        with stages.stage("assembly"):
            solid = assemble_solid(tagged, body_of(study, tagged.dim), clamped, clamps)
            if not study.loaded:
                return Assembled(study, solid, contact_sites(solid, patches))
            loads = loads_of(study, solid)
            assert_followers_apart(loads, tagged, patches)
        with stages.stage("static state"):
            memory = memory_of_rank(comm, study.solver.memory)
            proven |= study.solver.linear == "iterative"
            solid = loaded(solid, loads, memory, proven=proven)
            sites = contact_sites(solid, patches)
        assert_off_axis(loads, sites)
        return Assembled(study, solid, sites)


@dataclass(frozen=True, slots=True)
class MeshLinear(LinearAnalysis):
    """An analysis of a mesh as all that is linear of a structure, spread over the ranks.

    Attributes:
        sites: Vertices of the contact patches.
        choices: Which of them are contact points.
        bending: Reduced models with one kind of kinematics and the other.
        forces: Derivatives of the internal force of the body.
        coriolis: Circular frequencies of the lowest modes, the followed one among them, with
            Coriolis forces in rad/s; empty without speed.
    """

    sites: ContactSites
    choices: Choices
    bending: Bending
    forces: BodyForces
    coriolis: Array = field(default_factory=lambda: np.empty(0))

    @property
    def body(self) -> LinearAnalysis:
        """The body itself."""
        return self

    def reduced_to(self, modes: LinearModes, reduction: Reduction) -> MeshLinear:
        """As `Linear.reduced_to`."""
        return replace(self, modes=modes, reduction=reduction)

    def with_contact(self, study: MeshStudy) -> MeshLinear | None:
        """As `Linear.with_contact`; second order depends on gaps, mode and energies."""
        patches = contact_patches(study, self.solid.tagged)
        new = Assembled(study, self.solid, contact_sites(self.solid, patches))
        unknown = new.mode >= len(self.coriolis) > 0
        if unknown or not _same_rows(new.sites, self.sites):
            return None
        even = evenly_spread(new.sites)
        choices = chosen_by_mode(even, new.sites, self.modes, new.mode)
        interface = new.interface(choices)
        if not _same_rows(interface, self.interface):
            return None
        moved = replace(self, interface=interface, sites=new.sites, choices=choices)
        found = _rechosen(moved, study)
        if found is None:
            return None
        return found if same_points(found.better_choices(new.mode), choices) else None

    def better_choices(self, mode: int) -> Choices:
        """Contact points that the followed mode, of an index from 0, asks for about rest."""
        return chosen_about_rest(self.choices, self.sites, self.reduction, mode)

    def first_contact(self, mode: int) -> FirstContact:
        """As `Linear.first_contact`."""
        rest, sites = self.model.at_rest(), self.sites
        amplitude = over_all = rest.amplitude(mode)
        if sites.limited and rest.is_linear(mode):
            approach = approach_of(sites, chosen_of(self.choices), self.reduction, mode)
            over_all = min(amplitude, float(approach.reach.min()))
        omega = float(rest.omega[mode])
        return FirstContact(
            points=self.interface.count,
            vertices=len(sites.gap),
            energy=(omega * amplitude) ** 2 / 2,
            over_all=(omega * over_all) ** 2 / 2,
            place=_contact_name(self.interface, rest.first(mode)),
        )

    def frequencies(self) -> Frequencies:
        """As `Linear.frequencies`."""
        return frequencies_of(self)

    def flexibility(self, harmonics: int) -> HarmonicSolver:
        """As `Linear.flexibility`.

        Raises:
            TypeError: if the reduction is not the massless-boundary one.
        """
        return HarmonicSolver(self, harmonics=harmonics)

    def displacement_basis(self) -> DisplacementBasis:
        """As `Linear.displacement_basis`."""
        way, found = gathering(self.solid), self.reduction
        bent = way.nodal(found.bent_shapes) if found.bent_shapes.size else np.zeros((0, 0, 0))
        return DisplacementBasis(way.nodal(found.shapes), way.nodal(found.residual_shapes), bent)

    def sizes(self) -> dict[str, Any]:
        """Numbers of degrees of freedom and contact points, their area, and each patch."""
        interface = self.interface
        return {
            "dofs": self.solid.dofs,
            "contact_points": interface.count,
            "contact_area_m2": float(interface.areas.sum()),
            "contact_patches": [dict(asdict(patch)) for patch in patch_summaries(interface)],
            "facet_groups": facet_counts(self.solid.tagged),
            "mesh_notes": self.notes(),
        }

    def data(self) -> Data:
        """Contact points and mesh in memory, shapes in blocks, and the mesh as it was read."""
        return with_mesh(gathered_basis(self), self.solid, self.interface)

    def heading(self) -> list[str]:
        """Mesh, materials, attachments and contact in words."""
        solid, interface = self.solid, self.interface
        return [
            f"mesh             {_cells(solid)} cells, {solid.dofs} degrees of freedom",
            f"bounding box     {_box(solid)} m",
            *material_lines(solid),
            *attachment_lines(solid, interface),
            *rigid_lines(solid.body.constraints),
            *load_lines(solid),
            *kinematics_lines(self.reduction),
            f"contact          {interface.count} points, {interface.areas.sum():.6g} m^2, "
            f"{'smallest ' * (len(interface.names) > 1)}gap {interface.gap.min():.4g} m",
            *(f"  {patch}" for patch in patch_summaries(interface)),
        ]

    def groups(self) -> list[str]:
        """Table of the named groups."""
        return group_table(self.solid.tagged)

    def notes(self) -> list[str]:
        """What was left out or changed on reading the mesh."""
        return list(self.solid.tagged.notes)

    def largest(self, q: Array, force: Array) -> str:
        """Largest displacement of any node, of coordinates in kg^1/2 m and contact forces in N."""
        return f"{self.largest_displacement(q, force):.4g} m"

    def warnings(self, study: MeshStudy, mode: int) -> list[str]:
        """As `Linear.warnings`."""
        return mesh_warnings(study, self, mode)


def _rechosen(linear: MeshLinear, study: MeshStudy) -> MeshLinear | None:
    """The same with the gaps of its interface; None if second order is needed, or not known.

    To be called on all ranks.
    """
    bending = linear.bending.at_gaps(linear)
    if not can_choose(study, bending):
        return None
    straight = replace(linear, reduction=bending.straight, bending=bending)
    choice = chosen_kind(study, bending, straight, asked_of_study)
    if choice.second_order:
        return None
    return replace(straight, reduction=replace(bending.straight, choice=choice))


def _reduced(
    assembled: Assembled, solver: ModalSolver, stages: Stages, at_most: int | None
) -> MeshLinear:
    """Modes of an assembled body, then its contact points, then its reduced model."""
    study, sites, mode = assembled.study, assembled.sites, assembled.mode
    even = evenly_spread(sites)
    retained = _retained(study, assembled.solid, assembled.interface(even))
    count = mode_count(study, at_most, solver.free - retained)
    with stages.stage("modes"):
        modes = kept_modes(assembled.solid, solver, count).unique(sites.displacement)
        choices = chosen_by_mode(even, sites, modes, mode)
        coupled = _with_coriolis(assembled, modes, solver)
    forces = BodyForces(assembled.solid)
    reduced = partial(_reduced_at, assembled, forces, solver, modes, count, stages)
    return replace(_settled(reduced, choices, mode), coriolis=coupled)


def _driven(assembled: Assembled, solver: ModalSolver, stages: Stages) -> DrivenBody:
    """Modes of an assembled body, and what drives, damps and monitors it."""
    study, solid = assembled.study, assembled.solid
    choices = evenly_spread(assembled.sites)
    interface = assembled.interface(choices)
    gap_motion = gap_motion_of(assembled.sites, chosen_of(choices))
    report_notes(solid.tagged.notes, solid.tagged.mesh.comm)
    pushes = tuple(excitations_of(study, solid.tagged.dim))
    others = Others(dashpots_of(study, solid.tagged.dim), monitors_of(study, solid.tagged.dim))
    places = driven_places(solid, interface, pushes, others, gap_motion)
    with stages.stage("modes"):
        modes = kept_modes(solid, solver, mode_count(study, None, solver.free))
    chosen = assembled.sites, choices, interface
    operators = operators_of(solid, interface, solver)
    places = turning(study, solid, places, modes)
    moved = modal_motions(study, modes, places, operators)
    own = bent_modes(study, solid, chosen, modes, moved, solver, stages)
    with stages.stage("attachments"):
        basis = with_kinematics(study, own, lambda modes: driven_basis(modes, places, operators))
    return DrivenBody(solid, interface, basis)


def _with_coriolis(assembled: Assembled, modes: LinearModes, solver: ModalSolver) -> Array:
    """Circular frequencies of the lowest modes with Coriolis forces in rad/s; none at rest."""
    solid = assembled.solid
    if solid.state is None or solid.state.loads.rotation is None or not solid.state.loads.speed:
        return np.empty(0)
    operators = operators_of(solid, assembled.interface(evenly_spread(assembled.sites)), solver)
    count = min(max(_COUPLED, assembled.mode + 1), len(modes.omega))
    return coriolis_frequencies(solid, solid.state.loads.rotation, modes, operators, count)


def _reduced_at(
    assembled: Assembled,
    forces: BodyForces,
    solver: ModalSolver,
    modes: LinearModes,
    count: int,
    stages: Stages,
    choices: Choices,
) -> MeshLinear:
    """The reduced model with some contact points."""
    study, solid = assembled.study, assembled.solid
    with stages.stage("attachments"):
        interface = assembled.interface(choices)
        if study.reduction.method != "craig-bampton":
            _tell_expectation(study, solid, interface, solver, stages)
            reduction = massless_reduced(solid, interface, modes, solver, stages.report)
        else:
            units = _interface_forces(study, solid, interface)
            reduction = craig_bampton_reduced(solid, interface, units, count, solver)
    either = Bending(reduction, reduction, assembled.mode)
    straight = MeshLinear(
        solid, interface, modes, reduction, assembled.sites, choices, either, forces
    )
    bending = bending_of(study, straight, solver, stages)
    choice = chosen_kind(study, bending, straight, assembled.reached)
    found = in_choice(study, bending, choice, straight, assembled.reached, solver, stages)
    return replace(straight, reduction=found, bending=bending)


def _settled(reduced: Callable[[Choices], MeshLinear], choices: Choices, mode: int) -> MeshLinear:
    """The model whose contact points are those that its state of rest asks for."""
    found = reduced(choices)
    for _ in range(_MORE_CHOICES):
        better = found.better_choices(mode)
        if same_points(better, found.choices):
            break
        found = reduced(better)
    return found


def _tell_expectation(
    study: MeshStudy,
    solid: Solid,
    interface: ContactInterface,
    solver: ModalSolver,
    stages: Stages,
) -> None:
    """Tell how long many contact points are going to take, before they do."""
    if interface.count < MANY:
        return
    costs = Costs.measured(solver.static, interface.unit_forces(solid.owned))
    text = expectation(costs, interface.count, solid.owned, least_motions(study))
    if text:
        stages.tell(text)


def _modal_solver(study: MeshStudy, solid: Solid) -> ModalSolver:
    """The solver of a study; reductions other than the massless one and loads need factors."""
    chosen = study.solver.linear
    if chosen == "auto" and (study.reduction.needs_factors or study.loaded):
        chosen = "direct"
    return modal_solver(solid, chosen, study.solver.memory)


def _retained(study: MeshStudy, solid: Solid, interface: ContactInterface) -> int:
    """Number of the interface coordinates that the reduction keeps."""
    if study.reduction.all_directions:
        return _interface_forces(study, solid, interface).shape[1]
    return interface.count


def _interface_forces(study: MeshStudy, solid: Solid, interface: ContactInterface) -> Array:
    """Unit forces of the interface coordinates that the reduction keeps, shape (n_owned, i)."""
    if study.reduction.all_directions:
        return interface.unit_forces_all_directions(solid.owned)
    return interface.unit_forces(solid.owned)


def _same_rows(
    first: ContactInterface | ContactSites, second: ContactInterface | ContactSites
) -> bool:
    """Whether contact rows B of places on one mesh are equal; the same on all ranks."""
    one, other = first.weights, second.weights
    pairs = [(first.directions, second.directions)]
    pairs += [(getattr(one, name), getattr(other, name)) for name in ("indptr", "indices", "data")]
    same = one.shape == other.shape and all(np.array_equal(a, b) for a, b in pairs)
    return bool(first.comm.allreduce(same, MPI.LAND))


def _cells(solid: Solid) -> int:
    mesh = solid.tagged.mesh
    return int(mesh.topology.index_map(mesh.topology.dim).size_global)


def _box(solid: Solid) -> str:
    tagged = solid.tagged
    coordinates = tagged.mesh.geometry.x[:, : tagged.dim]
    pieces = [piece for piece in tagged.mesh.comm.allgather(coordinates) if len(piece)]
    points = np.concatenate(pieces)
    ranges = zip(points.min(axis=0), points.max(axis=0), strict=True)
    return " x ".join(f"[{low:.6g}, {high:.6g}]" for low, high in ranges)


def _contact_name(interface: ContactInterface, point: int) -> str:
    """Coordinates of a contact point, with its patch if there are several."""
    place = "(" + ", ".join(f"{x:.5g}" for x in interface.points[point]) + ") m"
    several = len(interface.names) > 1
    return f"{place} of {interface.names[interface.patch[point]]}" if several else place
