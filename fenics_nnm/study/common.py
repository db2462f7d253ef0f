"""What a study of a mesh and one of matrices have in common, and what must fit in both."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from fenics_nnm.errors import StudyError
from fenics_nnm.geometry.lengths import LengthUnit
from fenics_nnm.study.contact import (
    LawSection,
)
from fenics_nnm.study.continuation import ContinuationSection, EnergySection
from fenics_nnm.study.damping import DampingSection
from fenics_nnm.study.driven import (
    ResponseSection,
)
from fenics_nnm.study.output import OutputSection
from fenics_nnm.study.record import Record, Title
from fenics_nnm.study.reduction import (
    AnyReduction,
    Law,
    MasslessSection,
)
from fenics_nnm.study.resolution import Resolution
from fenics_nnm.study.solution import (
    AugmentedLagrangianSection,
    ModeSection,
)

#: Relative error of the frequency that "auto" meets if none is given.
DEFAULT_TOLERANCE = 1e-3


class AnyStudy(Record):
    """What every study has."""

    title: Title = Field("", description="a line of text for pictures and reports")
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
    def _tolerance_has_effect(self) -> AnyStudy:
        if self.mode.tolerance is not None and not self.automatic:
            raise ValueError(
                f"mode.tolerance = {self.mode.tolerance:g}: has no effect: needs mode.harmonics, "
                'mode.samples or reduction.modes = "auto"'
            )
        return self

    @model_validator(mode="after")
    def _numbers_can_be_found(self) -> AnyStudy:
        if self.automatic and (self.mode.harmonic > 1 or self.continuation.beginning):
            key = "mode.harmonic" if self.mode.harmonic > 1 else "continuation.start"
            raise ValueError(
                f'{key}: does not go with {self.automatic[0]} = "auto", which is found for the '
                "branch that begins at the linear mode: give numbers"
            )
        return self

    @model_validator(mode="after")
    def _law_fits_reduction(self) -> AnyStudy:
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
    def _multipliers_fit_law(self) -> AnyStudy:
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
    def _parameter_fits_contact(self) -> AnyStudy:
        stepping = self.continuation.stepping
        if self.carries_mass and stepping != "energy":
            raise ValueError(
                f"continuation: by {stepping} needs contact points without mass: with contact.law "
                '= "augmented-lagrangian" must have parameter = "energy" and internal_resonance = '
                '"skip"'
            )
        return self

    @model_validator(mode="after")
    def _harmonic_fits_continuation(self) -> AnyStudy:
        number = self.mode.harmonic
        if number > 1 and self.mode.harmonics != "auto" and number > self.mode.harmonics:
            raise ValueError(
                f"mode.harmonic = {number}: must not be above mode.harmonics = "
                f"{self.mode.harmonics}"
            )
        self.continuation.assert_takes(number)
        return self

    @model_validator(mode="after")
    def _mode_is_kept(self) -> AnyStudy:
        if self.reduction.modes != "auto" and self.mode.number > self.reduction.modes:
            raise ValueError(
                f"mode.number = {self.mode.number}: must not be above "
                f"reduction.modes = {self.reduction.modes}"
            )
        return self


class SprungStudy(AnyStudy):
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
    def coriolis(self) -> str:
        """Key that has Coriolis forces belong to the linear modes, empty where they do not."""
        return ""

    @property
    def driven_sections(self) -> tuple[str, ...]:
        """Sections that `fenics-nnm response` alone reads, of those that the study has."""
        names = ("damping", "dashpot", "excitation", "monitor", "response")
        return tuple(name for name in names if getattr(self, name, None))

    @property
    def damped(self) -> bool:
        """Whether a run is to follow damped motions, where it can."""
        given = {"damping", "dashpot"} & set(self.driven_sections) != set()
        return given and self.continuation.damped and self.reduction.method == "massless"

    @model_validator(mode="after")
    def _cubic_springs_are_resolved(self) -> SprungStudy:
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
    def _bending_is_resolved(self) -> SprungStudy:
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
