"""Sections of the study file about matrices of another code."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from fenics_nnm.study.messages import shown
from fenics_nnm.study.record import Count, Finite, FromList, Name, Record

MatrixFile = Annotated[Path, Field(strict=False)]

Place = tuple[Path, str | None]
"""A file, and the name of a matrix in it where it may hold several."""

#: Keys of arrays that a structure may have besides stiffness, mass and contact rows.
_FURTHER = (
    "speed_stiffness",
    "gyroscopic",
    "quadratic_stiffness",
    "cubic_stiffness",
    "quadratic_rows",
)

#: Those of them that are not linear.
_BENDING = ("quadratic_stiffness", "cubic_stiffness", "quadratic_rows")


class _AnyMatrices(Record):
    speed: Finite | None = Field(
        None,
        description="speed of rotation in rad/s, for speed_stiffness, gyroscopic and "
        "contact.gap_growth",
    )
    coriolis: bool = Field(
        False,
        description="whether Coriolis forces belong to linear modes and responses: true or false",
    )
    masters: Annotated[tuple[Count, ...], FromList] | None = Field(
        None,
        description="numbers of the modes that bend the structure in second order, from 1; "
        "mode.number alone without",
    )

    @property
    def bends(self) -> bool:
        """Whether there are terms that are not linear."""
        return any(name in self.further for name in _BENDING)

    @property
    def further(self) -> dict[str, Place]:
        """Places of the arrays that the structure has besides, by key."""
        return {}

    @model_validator(mode="after")
    def _speed_is_given(self) -> _AnyMatrices:
        needing = [key for key in ("speed_stiffness", "gyroscopic") if key in self.further]
        if self.speed is None and needing:
            raise ValueError(f"speed: is missing (speed of rotation in rad/s, for {needing[0]})")
        if self.coriolis and "gyroscopic" not in self.further:
            raise ValueError("coriolis = true: has no effect without gyroscopic: must be false")
        if self.coriolis and not self.speed:
            raise ValueError("coriolis = true: has no effect without speed: must be false")
        return self

    @model_validator(mode="after")
    def _masters_bend(self) -> _AnyMatrices:
        if self.masters is None:
            return self
        if not self.bends:
            raise ValueError(
                "masters: has no effect: needs quadratic_stiffness, cubic_stiffness or "
                "quadratic_rows"
            )
        if not self.masters or list(self.masters) != sorted(set(self.masters)):
            raise ValueError(
                f"masters = {list(self.masters)}: must be numbers of modes, ascending, one or more"
            )
        return self


class MatrixArchive(_AnyMatrices):
    """Matrices of another code, together in one file."""

    file: Annotated[Path, Field(strict=False, description="a .npz or .mat file")]
    stiffness: Name = Field("K", description="name of the stiffness in the file")
    mass: Name = Field("M", description="name of the mass in the file")
    contact_rows: Name = Field("B", description="name of the contact rows in the file")
    speed_stiffness: Name | None = Field(
        None, description="name of what the square of the speed adds to the stiffness"
    )
    gyroscopic: Name | None = Field(
        None, description="name of the Coriolis forces per unit speed and rate"
    )
    quadratic_stiffness: Name | None = Field(None, description="name of the quadratic stiffness")
    cubic_stiffness: Name | None = Field(None, description="name of the cubic stiffness")
    quadratic_rows: Name | None = Field(
        None, description="name of the quadratic part of the contact rows"
    )

    @model_validator(mode="after")
    def _holds_several(self) -> MatrixArchive:
        if self.file.suffix not in (".npz", ".mat"):
            raise ValueError(
                f"file = {shown(self.file)}: must be a .npz or .mat file; other files are named "
                "by stiffness, mass and contact_rows, without file"
            )
        return self

    @property
    def places(self) -> tuple[Place, ...]:
        """File and name of stiffness, mass and contact rows."""
        return tuple((self.file, name) for name in (self.stiffness, self.mass, self.contact_rows))

    @property
    def further(self) -> dict[str, Place]:
        """Places of the arrays that the structure has besides, by key."""
        names = {key: getattr(self, key) for key in _FURTHER}
        return {key: (self.file, name) for key, name in names.items() if name is not None}


class MatrixFiles(_AnyMatrices):
    """Matrices of another code, each in a file of its own."""

    stiffness: MatrixFile = Field(description="a .mtx, .npy, .npz or .mat file; or file = ...")
    mass: MatrixFile = Field(description="a .mtx, .npy, .npz or .mat file")
    contact_rows: MatrixFile = Field(description="a .mtx, .npy, .npz or .mat file")
    speed_stiffness: MatrixFile | None = Field(
        None, description="what the square of the speed adds to the stiffness, a file like these"
    )
    gyroscopic: MatrixFile | None = Field(
        None, description="Coriolis forces per unit speed and rate, a file like these"
    )
    quadratic_stiffness: MatrixFile | None = Field(None, description="a .npy, .npz or .mat file")
    cubic_stiffness: MatrixFile | None = Field(None, description="a .npy, .npz or .mat file")
    quadratic_rows: MatrixFile | None = Field(None, description="a .npy, .npz or .mat file")

    @property
    def places(self) -> tuple[Place, ...]:
        """File and name, here none, of stiffness, mass and contact rows."""
        return tuple((path, None) for path in (self.stiffness, self.mass, self.contact_rows))

    @property
    def further(self) -> dict[str, Place]:
        """Places of the arrays that the structure has besides, by key."""
        paths = {key: getattr(self, key) for key in _FURTHER}
        return {key: (path, None) for key, path in paths.items() if path is not None}
