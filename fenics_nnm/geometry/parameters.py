"""What all built-in geometries share: number types, length units, the frozen record."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field

GmshModel = Any
"""`gmsh.model`: a class that gmsh uses as a name space, so it has no type of its own."""

LengthUnit = Literal["m", "cm", "mm", "in", "ft"]

METRES: dict[str, float] = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "ft": 0.3048}
"""Metres in one length unit."""

Length = Annotated[float, Field(gt=0, le=1e9, allow_inf_nan=False, strict=True)]
Coordinate = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False, strict=True)]
Count = Annotated[int, Field(gt=0, le=1_000_000, strict=True)]


#: More elements than this are a misprint.
MOST_ELEMENTS = 5_000_000


def check_count(key: str, count: float) -> None:
    """Refuse a number of elements that nobody means.

    Raises:
        ValueError: if there are too many.
    """
    if count > MOST_ELEMENTS:
        raise ValueError(
            f"{key}: gives about {count:.3g} elements: must give at most {MOST_ELEMENTS}"
        )


class GeometryRecord(BaseModel):
    """Frozen parameters of a geometry; an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    #: Whether OpenCASCADE makes it, which may crash and gets a process of its own.
    native: ClassVar[bool] = False
