"""Sections of the study file about damping."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from fenics_nnm.arrays import Array
from fenics_nnm.errors import StudyError
from fenics_nnm.mechanics.damping import modal_rate, rayleigh_rate
from fenics_nnm.study.record import (
    Count,
    FromList,
    Name,
    Names,
    NotNegative,
    Place,
    Positive,
    Record,
)

Ratios = Annotated[tuple[Positive, ...], Field(min_length=1), FromList]
Dampers = Annotated[tuple[NotNegative, ...], Field(min_length=1, max_length=3), FromList]


class _Damping(Record):
    """Damping of all modes, none of a kind unless a subclass says so."""

    def rate(self, omega: Array, modes: int) -> Array:
        """Rate matrix C in 1/s of circular frequencies in rad/s, shape (J', J')."""
        return np.zeros((len(omega), len(omega)))

    def loss(self, omega: Array, modes: int) -> Array:
        """Imaginary part of the modal stiffness in 1/s^2, shape (J', J')."""
        return np.zeros((len(omega), len(omega)))

    @property
    def place(self) -> tuple[Path, str | None] | None:
        """File of a damping matrix, and its name there."""
        return None


def _of_each_mode(key: str, given: float | tuple[float, ...], count: int, modes: int) -> Array:
    """A number for each mode, then for shapes that were added, which take the last one.

    Raises:
        StudyError: if there is not one for each mode.
    """
    values = given if isinstance(given, tuple) else (given,) * modes
    if len(values) != modes:
        raise StudyError(
            f"{key} has {len(values)} values: must be one number, or have one for each of "
            f"reduction.modes = {modes}"
        )
    return np.array(values + values[-1:] * (count - modes))


class RatioSection(_Damping):
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
        return modal_rate(omega, _of_each_mode("damping.ratio", self.ratio, len(omega), modes))


class RayleighSection(_Damping):
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


class LossSection(_Damping):
    """Structural (hysteretic) damping, harmonic by harmonic."""

    loss_factor: Positive | Ratios = Field(
        description="loss factor eta of K (1 + i eta), positive, twice a damping ratio at "
        "resonance: one for all modes, or a list with one for each of reduction.modes"
    )

    def loss(self, omega: Array, modes: int) -> Array:
        """Imaginary part of the modal stiffness in 1/s^2, eta omega^2, shape (J', J').

        Raises:
            StudyError: if there is not one factor for each mode.
        """
        eta = _of_each_mode("damping.loss_factor", self.loss_factor, len(omega), modes)
        return np.diag(eta * omega**2)


class MatrixSection(_Damping):
    """A damping matrix of another code."""

    file: Annotated[Path, Field(strict=False, description="a .mtx, .npy, .npz or .mat file")]
    name: Name | None = Field(None, description="name of the matrix in a .npz or .mat file")

    @property
    def place(self) -> tuple[Path, str | None] | None:
        """File of the damping matrix, and its name there."""
        return self.file, self.name


DampingSection = RatioSection | RayleighSection | LossSection | MatrixSection
"""Damping of driven motions, by whichever keys stand."""


def damping_record(values: dict[str, Any]) -> type[DampingSection]:
    """Record that a section is meant for, so that messages speak of that one alone."""
    if {"alpha", "beta"} & values.keys():
        return RayleighSection
    if "loss_factor" in values:
        return LossSection
    return MatrixSection if "file" in values else RatioSection


class DashpotSection(Record):
    """Dashpots to the ground at a vertex, or spread evenly over facets."""

    at: Place | None = Field(None, description="coordinates in m: the nearest vertex is taken")
    facets: Names | None = Field(None, description="name of a group of facets, or a list of names")
    damping: Dampers = Field(
        description="[cx, cy, cz] in N s/m, of all facets together; as many as dimensions"
    )

    @model_validator(mode="after")
    def _one_place(self) -> DashpotSection:
        if (self.at is None) == (self.facets is None):
            raise ValueError("at, facets: must have one of the two")
        if not any(self.damping):
            raise ValueError(f"damping = {list(self.damping)}: must not be zero")
        return self


class MatrixDashpotSection(Record):
    """A dashpot to the ground at an unknown of matrices."""

    unknown: Count = Field(description="number of the unknown: row of the stiffness, from 1")
    damping: Positive = Field(description="damping in N s/m, positive")
