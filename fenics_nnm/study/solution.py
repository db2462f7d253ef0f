"""Sections of the study file about linear equations, multipliers and motions in time."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Tag, model_validator

from fenics_nnm.study.record import Auto, Count, Positive, Record
from fenics_nnm.study.tagged import by_key

_NORMALISATIONS = '"exact": h = 0 is a row; "penalised": the literal form of the paper'


class SolverSection(Record):
    """How the linear equations of a mesh are solved."""

    linear: Literal["auto", "direct", "iterative"] = Field(
        "auto",
        description='"direct": by factors of the stiffness; "iterative"; or "auto": direct if the '
        "factors fit in memory",
    )
    memory: Positive | None = Field(
        None, description="GiB that factors may take on a machine (default: 80 % of what is free)"
    )


class _AugmentedLagrangian(Record):
    """Multipliers of contact points that carry mass."""

    penalty: Positive = Field(10.0, description="first penalty over the static contact stiffness")
    alpha: Annotated[float, Field(gt=1, allow_inf_nan=False)] = Field(
        4.0, description="factor by which a measure must fall, above 1"
    )
    beta: Annotated[float, Field(gt=1, allow_inf_nan=False)] = Field(
        10.0, description="growth of a penalty, above 1"
    )
    tolerance: Positive = Field(1e-10, description="penetration and tension over the gap")
    iterations: Count = Field(60, description="largest number of outer steps")


class ExactSection(_AugmentedLagrangian):
    """The energy is a row of the equations."""

    normalisation: Literal["exact"] = Field("exact", description=_NORMALISATIONS)


class PenalisedSection(_AugmentedLagrangian):
    """The energy is penalised, which is the literal form of the paper."""

    normalisation: Literal["penalised"] = Field("penalised", description=_NORMALISATIONS)
    algorithm: Literal["simultaneous", "sequential"] = Field(
        "simultaneous", description="base of the penalised form: Algorithm 1 or 2 of the paper"
    )


AugmentedLagrangianSection = Annotated[
    Annotated[ExactSection, Tag('normalisation = "exact"')]
    | Annotated[PenalisedSection, Tag('normalisation = "penalised"')],
    by_key("normalisation", "exact"),
]
"""Multipliers of contact points that carry mass."""


class ModeSection(Record):
    """Which nonlinear mode, and its series in time."""

    number: Count = Field(1, description="number of the linear mode, from 1")
    harmonic: Count = Field(
        1, description="harmonic that the linear mode is written in at first, from 1"
    )
    harmonics: Count | Auto = Field(10, description='a positive integer, N, or "auto"')
    samples: Count | Auto = Field(
        128, description='an integer, time samples of a period, at least 2 N + 1, or "auto"'
    )
    tolerance: Annotated[float, Field(gt=0, lt=0.1)] | None = Field(
        None, description='relative error of the frequency that "auto" meets, below 0.1'
    )
    series: Literal["time-reversible", "general"] = Field(
        "time-reversible", description='"time-reversible": cosines; "general": sines too'
    )

    @model_validator(mode="after")
    def _samples_resolve_harmonics(self) -> ModeSection:
        if self.harmonics == "auto" or self.samples == "auto":
            return self
        least = 2 * self.harmonics + 1
        if self.samples < least:
            raise ValueError(
                f"samples = {self.samples} with harmonics = {self.harmonics}: "
                f"must be at least 2 harmonics + 1 = {least}"
            )
        return self
