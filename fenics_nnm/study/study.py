"""A study as one typed record, of a mesh or of matrices."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import AfterValidator, model_validator

from fenics_nnm.geometry import Geometry
from fenics_nnm.study.attachments import MassSection, MatrixSpringSection, SpringSection
from fenics_nnm.study.body import BodySection, Clamps, assert_kept
from fenics_nnm.study.common import SprungStudy
from fenics_nnm.study.contact import (
    ContactSection,
    MatrixContactSection,
    PatchesSection,
)
from fenics_nnm.study.damping import DashpotSection, MatrixDashpotSection
from fenics_nnm.study.driven import (
    ExcitationSection,
    MatrixExcitationSection,
    MatrixMonitorSection,
    MonitorSection,
)
from fenics_nnm.study.groups import GroupSection, of_the_mesh
from fenics_nnm.study.loading import LoadSection, RotationSection
from fenics_nnm.study.material import Materials
from fenics_nnm.study.matrices import MatrixArchive, MatrixFiles
from fenics_nnm.study.mesh import CadFile, MeshFile
from fenics_nnm.study.output import MatrixOutputSection, MeshOutputSection
from fenics_nnm.study.reduction import (
    MasslessSection,
    MatrixMasslessSection,
    MatrixReductionSection,
    ReductionSection,
)
from fenics_nnm.study.rigid import RigidSection
from fenics_nnm.study.solution import (
    SolverSection,
)


class MeshStudy(SprungStudy):
    """All that a run of a mesh needs to know; lengths in m, in [mesh] in its length_unit."""

    mesh: MeshFile | CadFile | Geometry
    groups: Annotated[Mapping[str, GroupSection], AfterValidator(of_the_mesh)] = {}
    body: BodySection
    material: Materials
    mass: tuple[MassSection, ...] = ()
    spring: tuple[SpringSection, ...] = ()
    rigid: tuple[RigidSection, ...] = ()
    dashpot: tuple[DashpotSection, ...] = ()
    excitation: tuple[ExcitationSection, ...] = ()
    monitor: tuple[MonitorSection, ...] = ()
    rotation: RotationSection | None = None
    load: LoadSection | None = None
    clamp: Clamps = ()
    contact: ContactSection | PatchesSection
    reduction: ReductionSection = MasslessSection()
    solver: SolverSection = SolverSection()
    output: MeshOutputSection = MeshOutputSection()

    @property
    def cubic(self) -> bool:
        """Whether there are springs with a cubic stiffness."""
        return any(each.cubic for each in self.spring)

    @property
    def bends(self) -> bool:
        """Whether second-order kinematics are asked for."""
        return self.body.kinematics == "second-order"

    @property
    def may_bend(self) -> bool:
        """Whether second-order kinematics are asked for, or may be needed and can be had."""
        return self.bends or (self.body.may_bend and not (self.carries_mass or self.full_order))

    @model_validator(mode="after")
    def _masters_are_kept(self) -> MeshStudy:
        assert_kept("body.masters", self.body.masters, self.reduction.modes, self.mode.number)
        return self

    @property
    def loaded(self) -> bool:
        """Whether something loads the body steadily."""
        return self.load is not None or self.speed != 0

    @property
    def rotates(self) -> bool:
        """Whether there is an axis that the structure rotates about, at whatever speed."""
        return self.rotation is not None

    @property
    def coriolis(self) -> str:
        """Key that has Coriolis forces belong to the linear modes, empty where they do not."""
        return "rotation.coriolis" if self.rotation and self.rotation.coriolis else ""

    @property
    def speed(self) -> float:
        """Speed of rotation in rad/s."""
        return self.rotation.omega if self.rotation else 0.0

    @property
    def clamped(self) -> tuple[str, ...]:
        """Groups of facets that are held, in all directions or some."""
        return tuple(name for clamp in self.clamp for name in clamp.facets or ())

    @model_validator(mode="after")
    def _solver_fits_reduction(self) -> MeshStudy:
        if self.solver.linear == "iterative" and self.reduction.needs_factors:
            raise ValueError(
                f'solver.linear = "iterative": does not go with reduction.method = '
                f'"{self.reduction.method}", which needs factors: must be "direct" or "auto"'
            )
        if self.solver.linear == "iterative" and self.body.degree < 2:
            raise ValueError(
                f'solver.linear = "iterative": needs quadratic elements: body.degree = '
                f"{self.body.degree} must be 2"
            )
        if self.solver.linear == "iterative" and self.rigid:
            raise ValueError(
                'solver.linear = "iterative": does not go with rigid, whose constraints need '
                'factors: must be "direct" or "auto"'
            )
        return self

    @model_validator(mode="after")
    def _rigid_facets_can_move(self) -> MeshStudy:
        held = {name for each in self.clamp if not each.directions for name in each.facets or ()}
        for number, section in enumerate(self.rigid, start=1):
            if held.issuperset(section.facets):
                raise ValueError(
                    f"rigid[{number}].facets = {list(section.facets)}: has no effect on what "
                    "[clamp] holds in all directions: must be other facets"
                )
        return self

    @model_validator(mode="after")
    def _casings_have_a_speed(self) -> MeshStudy:
        for key, patch in self.contact.patches.items():
            if patch.casing and patch.casing.passing_order and not self.speed:
                raise ValueError(
                    f'{key}.casing.frame = "fixed": the body turns past the casing: needs '
                    "rotation.speed or rotation.rpm, not zero"
                )
            growth = getattr(patch.casing, "growth", 0.0)
            if growth and not self.speed:
                raise ValueError(
                    f"{key}.casing.growth = {growth:g}: is that at the speed of [rotation]: needs "
                    "rotation.speed or rotation.rpm, not zero"
                )
        return self

    @model_validator(mode="after")
    def _total_displacement_differs(self) -> MeshStudy:
        if "total_displacement" in self.output.fields and not self.loaded:
            raise ValueError(
                'output.fields: "total_displacement" is that with steady loads: needs [rotation] '
                'or [load]; "displacement" is all of it without'
            )
        return self

    @model_validator(mode="after")
    def _loads_fit(self) -> MeshStudy:
        key = "rotation" if self.rotation else "load"
        if self.rotation is None and self.load is None:
            return self
        if not self.clamp and not self.spring:
            raise ValueError(
                f"{key}: needs a body that is held: [clamp] or [[spring]] must hold it, or the "
                "loads carry it away"
            )
        if self.cubic:
            raise ValueError(f"{key}: does not go with spring.cubic: springs must be linear")
        if self.solver.linear == "iterative":
            raise ValueError(
                f'{key}: needs factors of the stiffness: solver.linear must be "direct" or "auto"'
            )
        return self

    @model_validator(mode="after")
    def _materials_have_cells(self) -> MeshStudy:
        for number, section in enumerate(self.material, start=1):
            if len(self.material) > 1 and section.cells is None:
                raise ValueError(
                    f"material[{number}].cells: is missing: with several materials each names its "
                    "groups of cells"
                )
        return self


class MatrixStudy(SprungStudy):
    """All that a run of matrices of another code needs to know; SI units."""

    absent: ClassVar[Mapping[str, str]] = dict.fromkeys(
        (
            "mesh",
            "groups",
            "body",
            "material",
            "clamp",
            "mass",
            "rigid",
            "solver",
            "rotation",
            "load",
        ),
        "does not go with [matrices], which hold the whole structure, held by its clamp",
    )

    matrices: MatrixArchive | MatrixFiles
    spring: tuple[MatrixSpringSection, ...] = ()
    dashpot: tuple[MatrixDashpotSection, ...] = ()
    excitation: tuple[MatrixExcitationSection, ...] = ()
    monitor: tuple[MatrixMonitorSection, ...] = ()
    contact: MatrixContactSection
    reduction: MatrixReductionSection = MatrixMasslessSection()
    output: MatrixOutputSection = MatrixOutputSection()

    @property
    def cubic(self) -> bool:
        """Whether there are springs with a cubic stiffness."""
        return bool(self.spring)

    @model_validator(mode="after")
    def _gap_grows_with_speed(self) -> MatrixStudy:
        if self.contact.gap_growth is not None and self.matrices.speed is None:
            raise ValueError("contact.gap_growth: has no effect without matrices.speed")
        return self

    @property
    def speed(self) -> float:
        """Speed of rotation in rad/s."""
        return self.matrices.speed or 0.0

    @property
    def coriolis(self) -> str:
        """Key that has Coriolis forces belong to the linear modes, empty where they do not."""
        return "matrices.coriolis" if self.matrices.coriolis else ""

    @property
    def bends(self) -> bool:
        """Whether there are terms that are not linear."""
        return self.matrices.bends

    @model_validator(mode="after")
    def _masters_are_kept(self) -> MatrixStudy:
        assert_kept(
            "matrices.masters", self.matrices.masters, self.reduction.modes, self.mode.number
        )
        return self


Study = MeshStudy | MatrixStudy
"""All that a run needs to know."""
