"""Sections of the study file about driven motions: damping, excitation, frequencies."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from fenics_nnm.arrays import Array
from fenics_nnm.errors import StudyError
from fenics_nnm.mechanics.damping import modal_rate, rayleigh_rate
from fenics_nnm.study.continuation import Range
from fenics_nnm.study.record import Count, Finite, FromList, Names, Place, Positive, Record, Vector

NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Ratios = Annotated[tuple[Positive, ...], Field(min_length=1), FromList]

_PHASE = "phase of the force in degrees: F cos(omega t + phase)"


class RatioSection(Record):
    """Modal damping by damping ratios."""

    ratio: Positive | Ratios = Field(
        description="damping ratio, positive: one for all modes, or a list with one for each of "
        "reduction.modes"
    )

    def rate(self, omega: Array, modes: int) -> Array:
        """Rate matrix C in 1/s, shape (J', J').

        Args:
            omega: Circular frequencies in rad/s of the modes, then of shapes that were added to
                them for forces at points, which take the last ratio, shape (J',).
            modes: Number of modes J.

        Raises:
            StudyError: if there is not one ratio for each mode.
        """
        ratios = self.ratio if isinstance(self.ratio, tuple) else (self.ratio,) * modes
        if len(ratios) != modes:
            raise StudyError(
                f"damping.ratio has {len(ratios)} values: must be one number, or have one for each "
                f"of reduction.modes = {modes}"
            )
        return modal_rate(omega, np.array(ratios + ratios[-1:] * (len(omega) - modes)))


class RayleighSection(Record):
    """Rayleigh damping alpha M + beta K."""

    alpha: NotNegative = Field(0.0, description="alpha of alpha M + beta K in 1/s, not negative")
    beta: NotNegative = Field(0.0, description="beta of alpha M + beta K in s, not negative")

    @model_validator(mode="after")
    def _damps(self) -> RayleighSection:
        if not self.alpha and not self.beta:
            raise ValueError("alpha = 0, beta = 0: must not both be zero")
        return self

    def rate(self, omega: Array, modes: int) -> Array:
        """Rate matrix C in 1/s of circular frequencies in rad/s, shape (J', J')."""
        return rayleigh_rate(omega, self.alpha, self.beta)


DampingSection = RatioSection | RayleighSection
"""Damping of driven motions, by whichever keys stand."""


def damping_record(values: dict[str, Any]) -> type[DampingSection]:
    """Record that a section is meant for, so that messages speak of that one alone."""
    return RayleighSection if {"alpha", "beta"} & values.keys() else RatioSection


class ExcitationSection(Record):
    """A harmonic force at a vertex, or spread evenly over facets."""

    at: Place | None = Field(None, description="coordinates in m: the nearest vertex is taken")
    facets: Names | None = Field(None, description="name of a group of facets, or a list of names")
    force: Vector = Field(
        description="[fx, fy, fz] in N, 0-peak, of all facets together; as many as dimensions"
    )
    phase_deg: Finite = Field(0.0, description=_PHASE)

    @property
    def amplitude(self) -> complex:
        """Complex amplitude along its direction in N."""
        return complex(np.linalg.norm(self.force) * np.exp(1j * np.deg2rad(self.phase_deg)))

    @model_validator(mode="after")
    def _is_a_force_at_one_place(self) -> ExcitationSection:
        if (self.at is None) == (self.facets is None):
            raise ValueError("at, facets: must have one of the two")
        if not any(self.force):
            raise ValueError(f"force = {list(self.force)}: must not be zero")
        return self


class MatrixExcitationSection(Record):
    """A harmonic force at an unknown of matrices."""

    unknown: Count = Field(description="number of the unknown: row of the stiffness, from 1")
    force: Finite = Field(description="force along the unknown in N, 0-peak, not zero")
    phase_deg: Finite = Field(0.0, description=_PHASE)

    @property
    def amplitude(self) -> complex:
        """Complex amplitude along its direction in N."""
        return complex(abs(self.force) * np.exp(1j * np.deg2rad(self.phase_deg)))

    @model_validator(mode="after")
    def _has_effect(self) -> MatrixExcitationSection:
        if not self.force:
            raise ValueError("force = 0: must not be zero")
        return self


class Hertz(Range):
    """Range of frequencies in Hz."""

    start: Positive = Field(alias="from", description="lowest frequency in Hz")
    stop: Positive = Field(alias="to", description="highest frequency in Hz")
    step: Positive = Field(description="step in Hz")

    @property
    def values(self) -> Array:
        """Equal steps of at most `step`, with both ends, shape (f,)."""
        steps = int(np.ceil((self.stop - self.start) / self.step - 1e-9))
        return np.linspace(self.start, self.stop, steps + 1)


class ResponseSection(Record):
    """At which frequencies a driven motion is found."""

    frequencies: Hertz = Field(description="range { from, to, step } in Hz")
