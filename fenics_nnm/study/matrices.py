"""Sections of the study file about matrices of another code."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from fenics_nnm.study.messages import shown
from fenics_nnm.study.record import Name, Record

MatrixFile = Annotated[Path, Field(strict=False)]


class MatrixArchive(Record):
    """Matrices of another code, together in one file."""

    file: Annotated[Path, Field(strict=False, description="a .npz or .mat file")]
    stiffness: Name = Field("K", description="name of the stiffness in the file")
    mass: Name = Field("M", description="name of the mass in the file")
    contact_rows: Name = Field("B", description="name of the contact rows in the file")

    @model_validator(mode="after")
    def _holds_several(self) -> MatrixArchive:
        if self.file.suffix not in (".npz", ".mat"):
            raise ValueError(
                f"file = {shown(self.file)}: must be a .npz or .mat file; other files are named "
                "by stiffness, mass and contact_rows, without file"
            )
        return self

    @property
    def places(self) -> tuple[tuple[Path, str | None], ...]:
        """File and name of stiffness, mass and contact rows."""
        return tuple((self.file, name) for name in (self.stiffness, self.mass, self.contact_rows))


class MatrixFiles(Record):
    """Matrices of another code, each in a file of its own."""

    stiffness: MatrixFile = Field(description="a .mtx, .npy, .npz or .mat file; or file = ...")
    mass: MatrixFile = Field(description="a .mtx, .npy, .npz or .mat file")
    contact_rows: MatrixFile = Field(description="a .mtx, .npy, .npz or .mat file")

    @property
    def places(self) -> tuple[tuple[Path, str | None], ...]:
        """File and name, here none, of stiffness, mass and contact rows."""
        return tuple((path, None) for path in (self.stiffness, self.mass, self.contact_rows))
