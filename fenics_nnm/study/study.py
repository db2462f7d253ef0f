"""A study as one typed record, of a mesh or of matrices."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Self

from pydantic import Field, model_validator

from fenics_nnm.errors import StudyError
from fenics_nnm.geometry import Geometry
from fenics_nnm.geometry.lengths import LengthUnit
from fenics_nnm.study.attachments import MassSection, MatrixSpringSection, SpringSection
from fenics_nnm.study.body import BodySection, Clamps
from fenics_nnm.study.contact import (
    ContactSection,
    LawSection,
    MatrixContactSection,
    PatchesSection,
)
from fenics_nnm.study.continuation import ContinuationSection, EnergySection
from fenics_nnm.study.damping import DampingSection, DashpotSection, MatrixDashpotSection
from fenics_nnm.study.driven import (
    ExcitationSection,
    MatrixExcitationSection,
    MatrixMonitorSection,
    MonitorSection,
    ResponseSection,
)
from fenics_nnm.study.groups import GroupSection
from fenics_nnm.study.loading import LoadSection, RotationSection
from fenics_nnm.study.material import Materials
from fenics_nnm.study.matrices import MatrixArchive, MatrixFiles
from fenics_nnm.study.mesh import CadFile, MeshFile
from fenics_nnm.study.output import MatrixOutputSection, MeshOutputSection, OutputSection
from fenics_nnm.study.record import Record
from fenics_nnm.study.reduction import (
    AnyReduction,
    Law,
    MasslessSection,
    MatrixMasslessSection,
    MatrixReductionSection,
    ReductionSection,
)
from fenics_nnm.study.resolution import Resolution
from fenics_nnm.study.rigid import RigidSection
from fenics_nnm.study.solution import (
    AugmentedLagrangianSection,
    ModeSection,
    SolverSection,
)

#: Relative error of the frequency that "auto" meets if none is given.
DEFAULT_TOLERANCE = 1e-3


class _AnyStudy(Record):
    title: str = ""
    length_unit: LengthUnit = Field(
        "m", description="unit of lengths without one; in [mesh] its own length_unit, if given"
    )
    contact: LawSection
    reduction: AnyReduction = MasslessSection()
    augmented_lagrangian: AugmentedLagrangianSection | None = None
    mode: ModeSection = ModeSection()
    continuation: ContinuationSection = EnergySection()
    damping: DampingSection | None = None
    response: ResponseSection | None = None
    output: OutputSection = OutputSection()

    @property
    def full_order(self) -> bool:
        """Whether the whole model is used at every harmonic, without reduction."""
        return self.reduction.full_order

    @property
    def clamped(self) -> tuple[str, ...]:
        """Groups of facets without displacement; none with matrices, which are held already."""
        return ()

    @property
    def law(self) -> Law:
        """Contact law: the one that is given, or the first that goes with the reduction."""
        return self.contact.law or self.reduction.laws[0]

    @property
    def carries_mass(self) -> bool:
        """Whether contact points carry mass, so that contact needs the augmented Lagrangian."""
        return self.law == "augmented-lagrangian"

    @property
    def automatic(self) -> tuple[str, ...]:
        """Names of the numbers that are to be found: harmonics, samples, modes."""
        given = {
            "harmonics": self.mode.harmonics,
            "samples": self.mode.samples,
            "modes": self.reduction.modes,
        }
        return tuple(name for name, value in given.items() if value == "auto")

    @property
    def tolerance(self) -> float:
        """Relative error of the frequency that numbers found must meet."""
        return self.mode.tolerance or DEFAULT_TOLERANCE

    @property
    def resolution(self) -> Resolution:
        """Harmonics, samples and modes.

        Raises:
            StudyError: if one of them is "auto" and not found yet.
        """
        numbers = self.mode.harmonics, self.mode.samples, self.reduction.modes
        if "auto" in numbers:
            raise StudyError(
                f'{self.automatic[0]} = "auto": is not found yet: '
                "see fenics_nnm.resolution.auto.choice"
            )
        return Resolution(*(int(number) for number in numbers))

    def with_resolution(self, found: Resolution) -> Self:
        """The same study with all numbers given."""
        mode = {"harmonics": found.harmonics, "samples": found.samples}
        return self.model_copy(
            update={
                "mode": self.mode.model_copy(update=mode),
                "reduction": self.reduction.model_copy(update={"modes": found.modes}),
            }
        )

    @model_validator(mode="after")
    def _tolerance_has_effect(self) -> _AnyStudy:
        if self.mode.tolerance is not None and not self.automatic:
            raise ValueError(
                f"mode.tolerance = {self.mode.tolerance:g}: has no effect: needs mode.harmonics, "
                'mode.samples or reduction.modes = "auto"'
            )
        return self

    @model_validator(mode="after")
    def _numbers_can_be_found(self) -> _AnyStudy:
        if self.automatic and (self.mode.harmonic > 1 or self.continuation.beginning):
            key = "mode.harmonic" if self.mode.harmonic > 1 else "continuation.start"
            raise ValueError(
                f'{key}: does not go with {self.automatic[0]} = "auto", which is found for the '
                "branch that begins at the linear mode: give numbers"
            )
        return self

    @model_validator(mode="after")
    def _law_fits_reduction(self) -> _AnyStudy:
        if self.law in self.reduction.laws:
            return self
        if self.carries_mass:
            raise ValueError(
                'contact.law = "augmented-lagrangian": needs contact points that carry mass: '
                'reduction.method = "craig-bampton" or "none"'
            )
        raise ValueError(
            f'contact.law = "{self.law}": does not fit reduction.method = '
            f'"{self.reduction.method}", whose contact points carry mass: must be '
            f'"{self.reduction.laws[0]}"'
        )

    @model_validator(mode="after")
    def _multipliers_fit_law(self) -> _AnyStudy:
        chosen = self.augmented_lagrangian
        if chosen and not self.carries_mass:
            raise ValueError(
                'augmented_lagrangian: needs contact.law = "augmented-lagrangian", for contact '
                'points that carry mass: reduction.method = "craig-bampton" or "none"'
            )
        if chosen and self.full_order and chosen.normalisation == "penalised":
            raise ValueError(
                'augmented_lagrangian.normalisation = "penalised": is the form of reduced models: '
                f'with reduction.method = "{self.reduction.method}" must be "exact"'
            )
        return self

    @model_validator(mode="after")
    def _parameter_fits_contact(self) -> _AnyStudy:
        stepping = self.continuation.stepping
        if self.carries_mass and stepping != "energy":
            raise ValueError(
                f"continuation: by {stepping} needs contact points without mass: with contact.law "
                '= "augmented-lagrangian" must have parameter = "energy" and internal_resonance = '
                '"skip"'
            )
        return self

    @model_validator(mode="after")
    def _harmonic_fits_continuation(self) -> _AnyStudy:
        number = self.mode.harmonic
        if number > 1 and self.mode.harmonics != "auto" and number > self.mode.harmonics:
            raise ValueError(
                f"mode.harmonic = {number}: must not be above mode.harmonics = "
                f"{self.mode.harmonics}"
            )
        self.continuation.assert_takes(number)
        return self

    @model_validator(mode="after")
    def _mode_is_kept(self) -> _AnyStudy:
        if self.reduction.modes != "auto" and self.mode.number > self.reduction.modes:
            raise ValueError(
                f"mode.number = {self.mode.number}: must not be above "
                f"reduction.modes = {self.reduction.modes}"
            )
        return self


def assert_kept(key: str, masters: tuple[int, ...] | None, modes: int | str, own: int) -> None:
    """Refuse masters that are not among the modes, or that the followed one is not among.

    Raises:
        ValueError: if there are some.
    """
    if masters and modes != "auto" and masters[-1] > int(modes):
        raise ValueError(f"{key} = {list(masters)}: must not be above reduction.modes = {modes}")
    if masters and own not in masters:
        raise ValueError(f"{key} = {list(masters)}: must have mode.number = {own} among them")


class _SprungStudy(_AnyStudy):
    """A study whose structure may have springs that are not linear, or bend far."""

    @property
    def bends(self) -> bool:
        """Whether there are terms of second-order kinematics, or these are asked for."""
        return False

    @property
    def may_bend(self) -> bool:
        """Whether there are such terms, or they may be needed."""
        return self.bends

    @property
    def cubic(self) -> bool:
        """Whether there are springs with a cubic stiffness."""
        return False

    @property
    def samples_a_harmonic(self) -> int:
        """What the number of samples over that of harmonics must be above: 4 with polynomials."""
        return 4 if self.may_bend or self.cubic else 2

    @property
    def rotates(self) -> bool:
        """Whether there is an axis that the structure rotates about, at whatever speed."""
        return False

    @property
    def coriolis(self) -> bool:
        """Whether Coriolis forces belong to the linear modes; without rotation there are none."""
        return False

    @property
    def driven_sections(self) -> tuple[str, ...]:
        """Sections that `fenics-nnm response` alone reads, of those that the study has."""
        names = ("damping", "dashpot", "excitation", "monitor", "response")
        return tuple(name for name in names if getattr(self, name, None))

    @model_validator(mode="after")
    def _cubic_springs_are_resolved(self) -> _SprungStudy:
        if not self.cubic:
            return self
        harmonics, samples = self.mode.harmonics, self.mode.samples
        if self.carries_mass or self.full_order:
            raise ValueError('spring.cubic: needs reduction.method = "massless"')
        if self.automatic:
            raise ValueError(
                f'{self.automatic[0]} = "auto": does not go with spring.cubic: must be a number'
            )
        if self.continuation.stepping == "frequency":
            raise ValueError(
                'continuation.parameter = "frequency": does not go with spring.cubic, which makes '
                'the mode nonlinear before it touches: must be "energy" or "arc-length"'
            )
        if int(samples) <= 4 * int(harmonics):
            raise ValueError(
                f"mode.samples = {samples}: must be above 4 mode.harmonics = "
                f"{4 * int(harmonics)} with cubic springs, whose force has three times as many "
                "harmonics"
            )
        return self

    @model_validator(mode="after")
    def _bending_is_resolved(self) -> _SprungStudy:
        if not self.bends:
            return self
        if self.carries_mass or self.full_order:
            raise ValueError('second-order kinematics: need reduction.method = "massless"')
        harmonics, samples = self.mode.harmonics, self.mode.samples
        if "auto" not in (harmonics, samples) and int(samples) <= 4 * int(harmonics):
            raise ValueError(
                f"mode.samples = {samples}: must be above 4 mode.harmonics = "
                f"{4 * int(harmonics)} with second-order kinematics, whose forces have three "
                "times as many harmonics"
            )
        return self


class MeshStudy(_SprungStudy):
    """All that a run of a mesh needs to know; lengths in m, in [mesh] in its length_unit."""

    mesh: MeshFile | CadFile | Geometry
    groups: Mapping[str, GroupSection] = {}
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
        needs = self.body.kinematics == "auto" and self.body.theory != "rod"
        return self.bends or (needs and not self.carries_mass and not self.full_order)

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
    def coriolis(self) -> bool:
        """Whether Coriolis forces belong to the linear modes."""
        return self.rotation is not None and self.rotation.coriolis

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
        return self

    @model_validator(mode="after")
    def _solver_fits_rigid_facets(self) -> MeshStudy:
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
    def _casings_grow_at_speed(self) -> MeshStudy:
        for key, patch in self.contact.patches.items():
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


class MatrixStudy(_SprungStudy):
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
