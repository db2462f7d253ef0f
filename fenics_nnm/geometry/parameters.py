"""What all built-in geometries share: number types, the frozen record."""

from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field

from fenics_nnm.geometry.lengths import InUnitOfMesh

GmshModel = Any
"""`gmsh.model`: a class that gmsh uses as a name space, so it has no type of its own."""

Factor = Annotated[float, Field(gt=0, le=1e9, allow_inf_nan=False, strict=True)]
Length = Annotated[Factor, InUnitOfMesh]
Coordinate = Annotated[
    float, Field(ge=-1e9, le=1e9, allow_inf_nan=False, strict=True), InUnitOfMesh
]
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

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    #: Whether OpenCASCADE makes it, which may crash and gets a process of its own.
    native: ClassVar[bool] = False
