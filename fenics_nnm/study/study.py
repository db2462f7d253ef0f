"""A study as one typed record, of a mesh or of matrices."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from pydantic import model_validator

from fenics_nnm.errors import StudyError
from fenics_nnm.geometry import Geometry
from fenics_nnm.study.attachments import MassSection, SpringSection
from fenics_nnm.study.body import BodySection, Clamps
from fenics_nnm.study.contact import (
    ContactSection,
    LawSection,
    MatrixContactSection,
    PatchesSection,
)
from fenics_nnm.study.continuation import ContinuationSection
from fenics_nnm.study.groups import GroupSection
from fenics_nnm.study.material import Materials
from fenics_nnm.study.matrices import MatrixArchive, MatrixFiles
from fenics_nnm.study.mesh import CadFile, MeshFile
from fenics_nnm.study.output import OutputSection
from fenics_nnm.study.record import Record
from fenics_nnm.study.resolution import Resolution
from fenics_nnm.study.solution import (
    AugmentedLagrangianSection,
    ModeSection,
    ReductionSection,
    SolverSection,
)

#: Relative error of the frequency that "auto" meets if none is given.
DEFAULT_TOLERANCE = 1e-3


class _AnyStudy(Record):
    title: str = ""
    contact: LawSection
    reduction: ReductionSection = ReductionSection()
    augmented_lagrangian: AugmentedLagrangianSection | None = None
    mode: ModeSection = ModeSection()
    continuation: ContinuationSection = ContinuationSection()
    output: OutputSection = OutputSection()

    @property
    def full_order(self) -> bool:
        """Whether the whole model is used at every harmonic, without reduction."""
        return self.reduction.method == "none"

    @property
    def carries_mass(self) -> bool:
        """Whether contact points carry mass, so that contact needs the augmented Lagrangian."""
        chosen = self.full_order and self.contact.law == "augmented-lagrangian"
        return chosen or self.reduction.method == "craig-bampton"

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
        if self.automatic and (self.mode.harmonic > 1 or self.continuation.start):
            key = "mode.harmonic" if self.mode.harmonic > 1 else "continuation.start"
            raise ValueError(
                f'{key}: does not go with {self.automatic[0]} = "auto", which is found for the '
                "branch that begins at the linear mode: give numbers"
            )
        return self

    @model_validator(mode="after")
    def _law_fits_reduction(self) -> _AnyStudy:
        if self.carries_mass and self.contact.law == "complementarity":
            raise ValueError(
                'contact.law = "complementarity": does not fit reduction.method = "craig-bampton", '
                'whose contact points carry mass: must be "augmented-lagrangian"'
            )
        if not self.carries_mass and self.contact.law == "augmented-lagrangian":
            raise ValueError(
                'contact.law = "augmented-lagrangian": needs contact points that carry mass: '
                'reduction.method = "craig-bampton" or "none"'
            )
        if not self.carries_mass and self.augmented_lagrangian:
            raise ValueError(
                'augmented_lagrangian: needs contact.law = "augmented-lagrangian", for contact '
                'points that carry mass: reduction.method = "craig-bampton" or "none"'
            )
        return self

    @model_validator(mode="after")
    def _normalisation_fits_reduction(self) -> _AnyStudy:
        chosen = self.augmented_lagrangian
        if self.full_order and chosen and chosen.normalisation == "penalised":
            raise ValueError(
                'augmented_lagrangian.normalisation = "penalised": is the form of reduced models: '
                'with reduction.method = "none" must be "exact"'
            )
        return self

    @model_validator(mode="after")
    def _parameter_fits_contact(self) -> _AnyStudy:
        chosen = self.continuation
        if self.carries_mass and (chosen.parameter != "energy" or chosen.by_arc):
            raise ValueError(
                f"continuation: by {'arc-length' if chosen.by_arc else 'frequency'} needs contact "
                'points without mass: with contact.law = "augmented-lagrangian" must have '
                'parameter = "energy" and internal_resonance = "skip"'
            )
        return self

    @model_validator(mode="after")
    def _harmonic_fits_continuation(self) -> _AnyStudy:
        number, chosen = self.mode.harmonic, self.continuation
        if number == 1:
            return self
        if self.mode.harmonics != "auto" and number > self.mode.harmonics:
            raise ValueError(
                f"mode.harmonic = {number}: must not be above mode.harmonics = "
                f"{self.mode.harmonics}"
            )
        if not chosen.by_arc:
            raise ValueError(
                f'mode.harmonic = {number}: needs continuation.parameter = "arc-length" or '
                'internal_resonance = "follow"'
            )
        if chosen.start is None and chosen.energies.start >= 1:
            raise ValueError(
                f"continuation.energies.from = {chosen.energies.start:g}: must be below 1 with "
                f"mode.harmonic = {number}: such a branch begins without contact"
            )
        return self

    @model_validator(mode="after")
    def _mode_is_kept(self) -> _AnyStudy:
        if self.reduction.modes != "auto" and self.mode.number > self.reduction.modes:
            raise ValueError(
                f"mode.number = {self.mode.number}: must not be above "
                f"reduction.modes = {self.reduction.modes}"
            )
        return self


class MeshStudy(_AnyStudy):
    """All that a run of a mesh needs to know; lengths in m unless a key says otherwise."""

    mesh: MeshFile | CadFile | Geometry
    groups: Mapping[str, GroupSection] = {}
    body: BodySection
    material: Materials
    mass: tuple[MassSection, ...] = ()
    spring: tuple[SpringSection, ...] = ()
    clamp: Clamps = ()
    contact: ContactSection | PatchesSection
    solver: SolverSection = SolverSection()

    @model_validator(mode="after")
    def _solver_fits_reduction(self) -> MeshStudy:
        if self.solver.linear == "iterative" and self.reduction.method != "massless":
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
    def _materials_have_cells(self) -> MeshStudy:
        for number, section in enumerate(self.material, start=1):
            if len(self.material) > 1 and section.cells is None:
                raise ValueError(
                    f"material[{number}].cells: is missing: with several materials each names its "
                    "groups of cells"
                )
        return self


class MatrixStudy(_AnyStudy):
    """All that a run of matrices of another code needs to know; SI units."""

    matrices: MatrixArchive | MatrixFiles
    contact: MatrixContactSection

    @model_validator(mode="before")
    @classmethod
    def _nothing_of_a_mesh(cls, values: Any) -> Any:
        for key in ("mesh", "groups", "body", "material", "clamp", "mass", "spring", "solver"):
            if key in values:
                raise ValueError(
                    f"{key}: does not go with [matrices], which hold the whole structure, "
                    "held by its clamp"
                )
        for key in ("frames", "fields"):
            if isinstance(values.get("output"), dict) and key in values["output"]:
                raise ValueError(
                    f"output.{key}: belongs to [mesh]: matrices have no ParaView files"
                )
        return values

    @model_validator(mode="after")
    def _reduction_fits_matrices(self) -> MatrixStudy:
        if self.full_order:
            raise ValueError(
                'reduction.method = "none": full order factorises the matrices of a mesh at every '
                'harmonic: with [matrices] must be "massless" or "craig-bampton"'
            )
        if self.reduction.interface == "all":
            raise ValueError(
                'reduction.interface = "all": needs the directions of a mesh: [matrices] have the '
                'contact directions alone, "contact"'
            )
        return self


Study = MeshStudy | MatrixStudy
"""All that a run needs to know."""
