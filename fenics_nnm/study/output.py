"""Section of the study file about results."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, ClassVar

from pydantic import Field

from fenics_nnm.field_names import DEFAULT_FIELDS, LEAST_FRAMES, MOST_FRAMES, FieldName, FileFormat
from fenics_nnm.study.record import FromList, Record


class OutputSection(Record):
    """Where results go."""

    folder: Annotated[Path, Field(strict=False)] | None = Field(
        None, description="folder of the results; the default is results/ and the study's name"
    )


class MeshOutputSection(OutputSection):
    """Where results go, and what is written for ParaView."""

    frames: Annotated[int, Field(ge=LEAST_FRAMES, le=MOST_FRAMES)] = Field(
        LEAST_FRAMES, description="frames of a period in the ParaView files, at least 24"
    )
    fields: Annotated[tuple[FieldName, ...], Field(min_length=1), FromList] = Field(
        DEFAULT_FIELDS, description="fields that are written for ParaView"
    )
    format: FileFormat = Field(
        "vtu",
        description='"vtu": a file for each frame, and a .pvd file that lists them; "vtkhdf": one '
        "file for all frames of a motion",
    )


class MatrixOutputSection(OutputSection):
    """Where results of matrices go, which have no ParaView files."""

    frames: ClassVar[int] = 0
    fields: ClassVar[tuple[FieldName, ...]] = ()
    format: ClassVar[FileFormat] = "vtu"

    absent: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("frames", "fields", "format"), "belongs to [mesh]: matrices have no ParaView files"
    )
