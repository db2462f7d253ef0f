"""Sections of the study file about the branch: which motions, and the way between them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from fenics_nnm.study.record import Count, FromList, Positive, Record

#: Most energies of a study; more are a misprint of the step.
_MOST_STEPS = 100_000


#: A ratio, or a step of it: larger ones are misprints.
Ratio = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)]


class Range(Record):
    """Equal steps from one value to another."""

    start: Ratio = Field(alias="from", description="first value")
    stop: Ratio = Field(alias="to", description="last value")
    step: Ratio = Field(description="largest step")

    @model_validator(mode="after")
    def _ascending(self) -> Range:
        if self.start >= self.stop:
            raise ValueError(f"from = {self.start:g}, to = {self.stop:g}: from must be below to")
        if self.stop - self.start > _MOST_STEPS * self.step:
            raise ValueError(f"step = {self.step:g}: must give at most {_MOST_STEPS} steps")
        return self


class Energies(Range):
    """Range of energies, as ratios of gamma to its value at grazing."""

    start: Ratio = Field(0.7, alias="from", description="first gamma ratio")
    stop: Ratio = Field(3.0, alias="to", description="last gamma ratio")
    step: Ratio = Field(0.1, description="largest step of the gamma ratio")


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


class ContinuationSection(Record):
    """Which motions of the branch to visit."""

    parameter: Literal["energy", "frequency", "arc-length"] = Field(
        "energy", description='what is stepped: "energy", "frequency" or "arc-length"'
    )
    internal_resonance: Literal["skip", "follow"] | None = Field(
        None,
        description='"skip": stay on the main branch; "follow": through it, by arc-length',
    )
    energies: Energies = Field(Energies(), description="range { from, to, step } of gamma ratios")
    frequencies: Frequencies | None = Field(
        None, description="range { from, to, step } of frequency ratios"
    )
    report_at: Annotated[tuple[Positive, ...], FromList] = Field(
        (), description="gamma ratios that get a point and ParaView files"
    )
    arc_length: ArcLengthSection | None = Field(
        None, description="{ step, smallest_step, largest_step, points, predictor }"
    )
    start: StartSection | None = Field(
        None, description="{ file, gamma_ratio or bifurcation, direction } of an earlier run"
    )
    shooting: bool = Field(
        True, description="true or false: shoot for the exact motion in time near each point"
    )

    @property
    def by_arc(self) -> bool:
        """Whether the branch is followed by its length."""
        return self.parameter == "arc-length" or self.internal_resonance == "follow"

    @model_validator(mode="after")
    def _range_fits_parameter(self) -> ContinuationSection:
        by_frequency = self.parameter == "frequency"
        if by_frequency and self.frequencies is None:
            raise ValueError('parameter = "frequency": needs frequencies = { from, to, step }')
        if by_frequency and "energies" in self.model_fields_set:
            raise ValueError('energies: does not go with parameter = "frequency"')
        if not by_frequency and self.frequencies is not None:
            raise ValueError('frequencies: needs parameter = "frequency"')
        if self.parameter == "arc-length" and "step" in self.energies.model_fields_set:
            raise ValueError(
                'energies.step: has no effect with parameter = "arc-length": '
                "steps are those of arc_length"
            )
        return self

    @model_validator(mode="after")
    def _resonances_fit_parameter(self) -> ContinuationSection:
        if self.parameter == "frequency" and self.internal_resonance == "follow":
            raise ValueError(
                'internal_resonance = "follow": does not go with parameter = "frequency", which '
                "crosses them"
            )
        if self.parameter == "arc-length" and self.internal_resonance == "skip":
            raise ValueError(
                'internal_resonance = "skip": does not go with parameter = "arc-length", which '
                "follows the branch wherever it leads"
            )
        return self

    @model_validator(mode="after")
    def _arc_keys_have_effect(self) -> ContinuationSection:
        for name in ("arc_length", "start"):
            if getattr(self, name) is not None and not self.by_arc:
                raise ValueError(
                    f'{name}: needs parameter = "arc-length" or internal_resonance = "follow"'
                )
        return self

    @model_validator(mode="after")
    def _reports_inside_range(self) -> ContinuationSection:
        for ratio in self.report_at:
            inside = self.energies.start <= ratio <= self.energies.stop
            if self.parameter != "frequency" and not inside:
                raise ValueError(
                    f"report_at = {ratio:g}: must lie between energies.from = "
                    f"{self.energies.start:g} and energies.to = {self.energies.stop:g}"
                )
        if len({f"{ratio:g}" for ratio in self.report_at}) < len(self.report_at):
            raise ValueError(
                f"report_at = {list(self.report_at)}: must differ, and in the first six digits"
            )
        return self
