"""Sections of the study file about the branch: which motions, and the way between them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from fenics_nnm.backbone.arc_continuation import ArcContinuation
from fenics_nnm.backbone.arc_start import Begin
from fenics_nnm.backbone.energy_continuation import EnergyContinuation
from fenics_nnm.backbone.frequency_continuation import FrequencyContinuation
from fenics_nnm.backbone.quantities import Sought
from fenics_nnm.continuation.trace_options import ArcLength, Predictor
from fenics_nnm.geometry.lengths import WRONG_LENGTH
from fenics_nnm.study.asked import sought_amount, with_units_apart
from fenics_nnm.study.record import Count, FromList, Length, Positive, Record, Stress
from fenics_nnm.study.tagged import tag_text, value_of

Stepping = Literal["energy", "frequency", "arc-length"]

#: From this number of samples on, more of them did not help the studies that were tried.
_ENOUGH_SAMPLES = 64

_PARAMETERS = 'what is stepped: "energy", "frequency" or "arc-length"'
_RESONANCES = '"skip": stay on the main branch; "follow": through it, by arc-length'
_ENERGIES = "range { from, to, step } of gamma ratios"

#: Most energies of a study; more are a misprint of the step.
_MOST_STEPS = 100_000


#: Where a branch over energies in J has equal steps up to: from there on it goes to these.
_UP_TO_CONTACT = 1.0


def _an_amount(text: str) -> str:
    """A text that is an amount."""
    try:
        sought_amount(text)
    except ValueError as error:
        raise PydanticCustomError(WRONG_LENGTH, "{reason}", {"reason": str(error)}) from error
    return text


Amount = Annotated[str, AfterValidator(_an_amount)]
"""A text of a number with a unit."""

#: A ratio, or a step of it: larger ones are misprints.
Ratio = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)]


class Bounds(Record):
    """From one value to another."""

    start: Ratio = Field(alias="from", description="first value")
    stop: Ratio = Field(alias="to", description="last value")

    @model_validator(mode="after")
    def _ascending(self) -> Self:
        if self.start >= self.stop:
            raise ValueError(f"from = {self.start:g}, to = {self.stop:g}: from must be below to")
        return self


class Range(Bounds):
    """Equal steps from one value to another."""

    step: Ratio = Field(description="largest step")

    @model_validator(mode="after")
    def _few_steps(self) -> Self:
        if self.stop - self.start > _MOST_STEPS * self.step:
            raise ValueError(f"step = {self.step:g}: must give at most {_MOST_STEPS} steps")
        return self


class Energies(Range):
    """Range of energies, as ratios of gamma to its value at grazing."""

    start: Ratio = Field(0.7, alias="from", description="first gamma ratio")
    stop: Ratio = Field(3.0, alias="to", description="last gamma ratio")
    step: Ratio = Field(0.1, description="largest step of the gamma ratio")


class ArcEnergies(Bounds):
    """Energies that a branch by its length lies between, as ratios of gamma to grazing."""

    absent: ClassVar[Mapping[str, str]] = {
        "step": 'has no effect with parameter = "arc-length": steps are those of arc_length'
    }

    start: Ratio = Field(0.7, alias="from", description="first gamma ratio")
    stop: Ratio = Field(3.0, alias="to", description="last gamma ratio")


class Frequencies(Range):
    """Range of frequencies, as ratios to that of the linear mode."""

    start: Ratio = Field(
        alias="from",
        description="lowest frequency ratio, above 1 where gaps are open: contact makes a "
        "structure stiffer",
    )
    stop: Ratio = Field(
        alias="to",
        description="highest frequency ratio, below 1 where a closed contact lifts off",
    )
    step: Ratio = Field(0.005, description="largest step of the frequency ratio")

    @model_validator(mode="after")
    def _on_one_side_of_the_linear_one(self) -> Frequencies:
        if self.start <= 1 <= self.stop:
            raise ValueError(
                f"from = {self.start:g}, to = {self.stop:g}: must both be above 1, where gaps are "
                "open and contact makes a structure stiffer, or both below 1, where a closed "
                "contact lifts off"
            )
        return self


class ArcLengthSection(Record):
    """Steps along the branch, as relative changes of the motion in the energy norm."""

    step: Positive = Field(0.02, description="first step")
    smallest_step: Positive = Field(1e-5, description="a step that fails is halved down to this")
    largest_step: Positive = Field(0.1, description="largest step")
    points: Count = Field(1000, description="largest number of steps")
    predictor: Literal["tangent", "secant"] = Field(
        "tangent", description='"tangent", or "secant" of the last two points'
    )

    @model_validator(mode="after")
    def _ascending(self) -> ArcLengthSection:
        if not self.smallest_step <= self.step <= self.largest_step:
            raise ValueError(
                f"step = {self.step:g}: must lie between smallest_step = {self.smallest_step:g} "
                f"and largest_step = {self.largest_step:g}"
            )
        return self


class StartSection(Record):
    """A motion of an earlier run that the branch begins at."""

    file: Annotated[Path, Field(strict=False)] = Field(
        description="branch.h5 of a run of the same structure, relative to the study"
    )
    gamma_ratio: Positive | None = Field(None, description="gamma ratio of one of its points")
    bifurcation: Count | None = Field(
        None, description="number of one of its branch points, in the order of summary.json, from 1"
    )
    direction: Literal["up", "down"] = Field(
        "up", description="towards higher or lower energies, or the two sides of a bifurcation"
    )

    @model_validator(mode="after")
    def _one_place(self) -> StartSection:
        if (self.gamma_ratio is None) == (self.bifurcation is None):
            raise ValueError("must have either gamma_ratio or bifurcation")
        return self


class _Branch(Record):
    """What every branch has.

    Attributes:
        stepping: What the branch is followed by.
        start: A motion to begin at in place of the linear mode.
    """

    stepping: ClassVar[Stepping]

    report_at: Annotated[tuple[Positive, ...], FromList] = Field(
        (), description="gamma ratios that get a point and ParaView files"
    )
    shooting: bool = Field(
        True, description="true or false: shoot for the exact motion in time near each point"
    )

    damped: bool = Field(
        True,
        description="with [damping] or [[dashpot]]: follow damped motions; false: undamped ones, "
        "with their damping to first order",
    )

    @property
    def damped_ratios(self) -> tuple[float, ...]:
        """Gamma ratios of all motions where these are damped; none where others are asked for."""
        return ()

    @property
    def beginning(self) -> StartSection | None:
        """A motion of an earlier run to begin at, None for the linear mode."""
        return None

    @property
    def sought(self) -> tuple[Sought, ...]:
        """Values of quantities that get a point."""
        return ()

    def advice(self, samples: int) -> str:
        """Keys of the study that may help where motions are missing.

        Few samples see a contact of short duration at one instant or none, so the sampled force
        jumps as the contact moves past them. With enough of them it is internal resonances that
        hide motions, and these are others in other truncations.

        Args:
            samples: Number of samples in time.
        """
        if samples < _ENOUGH_SAMPLES:
            return f"raise mode.samples = {samples}, as contact may be short: 128 are usual"
        return self._remedy

    @property
    def _remedy(self) -> str:
        """Keys that may help where samples are enough."""
        return "another number of mode.harmonics, or fewer reduction.modes, may reach more"

    @property
    def resonances(self) -> Literal["skip", "follow"]:
        """What becomes of internal resonances: they are left aside, or followed."""
        return "skip"

    def position_keys(self) -> Iterator[tuple[str, Any]]:
        """Keys and values that the positions of points along the branch depend on."""
        yield "continuation.parameter", "energy"
        yield "continuation.internal_resonance", "skip"

    def assert_takes(self, harmonic: int) -> None:
        """Refuse a mode that is written in a higher harmonic at first.

        Raises:
            ValueError: if the branch cannot begin so.
        """
        if harmonic > 1:
            raise ValueError(
                f'mode.harmonic = {harmonic}: needs continuation.parameter = "arc-length" or '
                'internal_resonance = "follow"'
            )

    @model_validator(mode="after")
    def _reports_differ(self) -> Self:
        if len({f"{ratio:g}" for ratio in self.report_at}) < len(self.report_at):
            raise ValueError(
                f"report_at = {list(self.report_at)}: must differ, and in the first six digits"
            )
        return self


class _OverEnergies(_Branch):
    """A branch between two energies."""

    energies: Bounds

    @model_validator(mode="after")
    def _reports_inside_range(self) -> Self:
        low, high = self.energies.start, self.energies.stop
        for ratio in self.report_at:
            if not low <= ratio <= high:
                raise ValueError(
                    f"report_at = {ratio:g}: must lie between energies.from = {low:g} and "
                    f"energies.to = {high:g}"
                )
        return self


class EnergySection(_OverEnergies):
    """The main branch at given energies."""

    stepping: ClassVar[Stepping] = "energy"

    parameter: Literal["energy"] = Field("energy", description=_PARAMETERS)
    internal_resonance: Literal["skip"] | None = Field(None, description=_RESONANCES)
    energies: Energies = Field(
        Energies(), description=f'{_ENERGIES}; or in J, as a range or as a list: ["1.2 J"]'
    )
    energy_values: Annotated[tuple[Positive, ...], FromList] = Field(
        (), description="energies in J that get a point: those of energies with units"
    )
    amplitudes: Annotated[tuple[Length, ...], FromList] = Field(
        (), description="largest displacements in m that get a point and ParaView files"
    )
    stresses: Annotated[tuple[Stress, ...], FromList] = Field(
        (), description="largest von Mises stresses in Pa that get a point and ParaView files"
    )
    report_values: Annotated[tuple[Amount, ...], FromList] = Field(
        (),
        description='amounts with units that get a point and ParaView files, as in ["2 mm", '
        '"300 MPa", "1.2 J", "410 Hz"]: those of report_at with units',
    )

    @model_validator(mode="before")
    @classmethod
    def _units_apart(cls, given: Any) -> Any:
        return with_units_apart(given) if isinstance(given, dict) else given

    @property
    def sought(self) -> tuple[Sought, ...]:
        """Values of quantities that get a point, each once."""
        found = [
            *(sought_amount(text) for text in self.report_values),
            *(Sought("amplitude", value) for value in self.amplitudes),
            *(Sought("stress", value) for value in self.stresses),
            *(Sought("energy", value, reported=False) for value in self.energy_values),
        ]
        return tuple(dict.fromkeys(found))

    @property
    def damped_ratios(self) -> tuple[float, ...]:
        """All ratios that are wanted."""
        return tuple(self.wanted(1).targets())

    def wanted(self, harmonic: int, begin: Begin | None = None) -> EnergyContinuation:
        """The motions of the branch that are wanted."""
        over = self.energies
        ratios_given = "energies" in self.model_fields_set or not self.energy_values
        stop = over.stop if ratios_given else max(_UP_TO_CONTACT, *self.report_at, 0)
        return EnergyContinuation(
            over.start, stop, over.step, report_at=self.report_at, sought=self.sought
        )


class FrequencySection(_Branch):
    """The branch at given frequencies."""

    stepping: ClassVar[Stepping] = "frequency"
    absent: ClassVar[Mapping[str, str]] = {
        "energies": 'does not go with parameter = "frequency", whose range is frequencies'
    }

    parameter: Literal["frequency"] = Field(description=_PARAMETERS)
    internal_resonance: Literal["skip"] | None = Field(
        None, description='with parameter = "frequency", which crosses them, only "skip"'
    )
    frequencies: Frequencies = Field(description="range { from, to, step } of frequency ratios")

    def wanted(self, harmonic: int, begin: Begin | None = None) -> FrequencyContinuation:
        """The motions of the branch that are wanted."""
        over = self.frequencies
        return FrequencyContinuation(over.start, over.stop, over.step, report_at=self.report_at)

    def advice(self, samples: int) -> str:
        """Keys of the study that may help where motions are missing, see `EnergySection`."""
        return (
            "contact may not take this mode beyond the frequencies that were found; "
            f"{super().advice(samples)}"
        )

    def position_keys(self) -> Iterator[tuple[str, Any]]:
        """Keys and values that the positions of points along the branch depend on."""
        yield "continuation.parameter", self.parameter
        yield "continuation.internal_resonance", "skip"


class _ByArc(_OverEnergies):
    """The branch wherever it leads, by its length."""

    stepping: ClassVar[Stepping] = "arc-length"

    parameter: str
    arc_length: ArcLengthSection = Field(
        ArcLengthSection(),
        description="{ step, smallest_step, largest_step, points, predictor }",
    )
    start: StartSection | None = Field(
        None, description="{ file, gamma_ratio or bifurcation, direction } of an earlier run"
    )

    @property
    def beginning(self) -> StartSection | None:
        """A motion of an earlier run to begin at, None for the linear mode."""
        return self.start

    @property
    def _remedy(self) -> str:
        return "the bounds of steps are keys of continuation.arc_length"

    @property
    def _every(self) -> float | None:
        """Energies this far apart are hit at each passing."""
        return None

    def wanted(self, harmonic: int, begin: Begin | None = None) -> ArcContinuation:
        """The motions of the branch that are wanted, and an earlier one to begin at."""
        steps = self.arc_length
        return ArcContinuation(
            self.energies.start,
            self.energies.stop,
            self._every,
            report_at=self.report_at,
            arc=ArcLength(**{**steps.model_dump(), "predictor": Predictor(steps.predictor)}),
            harmonic=harmonic,
            begin=begin,
        )

    @property
    def resonances(self) -> Literal["skip", "follow"]:
        """They are followed."""
        return "follow"

    def position_keys(self) -> Iterator[tuple[str, Any]]:
        """Keys and values that the positions, lengths from the beginning, depend on."""
        yield "continuation.parameter", self.parameter
        yield "continuation.internal_resonance", "follow"
        yield "continuation.energies.from", self.energies.start
        begins = self.start.model_dump() if self.start else {}
        yield from ((f"continuation.start.{key}", value) for key, value in begins.items())

    def assert_takes(self, harmonic: int) -> None:
        """Refuse a mode that is written in a higher harmonic where the branch begins in contact.

        Raises:
            ValueError: if the branch cannot begin so.
        """
        if harmonic > 1 and self.start is None and self.energies.start >= 1:
            raise ValueError(
                f"continuation.energies.from = {self.energies.start:g}: must be below 1 with "
                f"mode.harmonic = {harmonic}: such a branch begins without contact"
            )


class ThroughResonancesSection(_ByArc):
    """The branch at given energies, followed through internal resonances by its length."""

    parameter: Literal["energy"] = Field("energy", description=_PARAMETERS)
    internal_resonance: Literal["follow"] = Field(description=_RESONANCES)
    energies: Energies = Field(Energies(), description=_ENERGIES)

    @property
    def _every(self) -> float | None:
        return self.energies.step


class ArcSection(_ByArc):
    """The branch between two energies, at steps of its length alone."""

    parameter: Literal["arc-length"] = Field(description=_PARAMETERS)
    internal_resonance: Literal["follow"] | None = Field(
        None,
        description='with parameter = "arc-length", which follows the branch wherever it leads, '
        'only "follow"',
    )
    energies: ArcEnergies = Field(ArcEnergies(), description="range { from, to } of gamma ratios")


def _kind(section: Any) -> str:
    parameter = value_of(section, "parameter", "energy")
    if parameter == "energy" and value_of(section, "internal_resonance", "skip") == "follow":
        return 'internal_resonance = "follow"'
    return tag_text("parameter", parameter)


ContinuationSection = Annotated[
    Annotated[EnergySection, Tag('parameter = "energy"')]
    | Annotated[FrequencySection, Tag('parameter = "frequency"')]
    | Annotated[ArcSection, Tag('parameter = "arc-length"')]
    | Annotated[ThroughResonancesSection, Tag('internal_resonance = "follow"')],
    Discriminator(_kind),
]
"""Which motions of the branch to visit."""
