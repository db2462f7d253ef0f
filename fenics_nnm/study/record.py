"""What all sections of a study file share: types of numbers and lengths, the frozen record."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

from fenics_nnm.errors import ModelError
from fenics_nnm.geometry.amounts import InPascal
from fenics_nnm.geometry.lengths import WRONG_LENGTH, InMetres

#: Numbers beyond these, in SI units, are misprints, and their squares cannot be computed with.
LARGEST, SMALLEST, MOST = 1e30, 1e-30, 1_000_000


def _not_tiny(value: float) -> float:
    """A number that is 0, or whose square can be computed with."""
    if 0 < value < SMALLEST:
        raise PydanticCustomError("too_small", f"must be {SMALLEST:g} or more")
    return value


def _zero_if_tiny(value: float) -> float:
    """0 for a number whose square cannot be computed with."""
    return value if abs(value) >= SMALLEST else 0.0


def _no_word(value: Any) -> Any:
    """A value that true and false do not pass for 1 and 0 in."""
    return str(value).lower() if isinstance(value, bool) else value


Positive = Annotated[float, Field(gt=0, le=LARGEST, allow_inf_nan=False), AfterValidator(_not_tiny)]
NotNegative = Annotated[
    float, Field(ge=0, le=LARGEST, allow_inf_nan=False), AfterValidator(_not_tiny)
]
OneOrTwo = Annotated[Literal[1, 2], BeforeValidator(_no_word)]
Finite = Annotated[
    float, Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False), AfterValidator(_zero_if_tiny)
]
Count = Annotated[int, Field(gt=0, le=MOST)]
Auto = Literal["auto"]
FromList = BeforeValidator(lambda value: tuple(value) if isinstance(value, list) else value)
Vector = Annotated[
    tuple[Finite, ...],
    Field(min_length=1, max_length=3),
    FromList,
]

#: Lengths in m, or as texts with a unit: positive ones, others, not negative ones, points.
Length = Annotated[Positive, InMetres]
Coordinate = Annotated[Finite, InMetres]
Distance = Annotated[float, Field(ge=0, le=LARGEST, allow_inf_nan=False), InMetres]
Place = Annotated[
    tuple[Coordinate, ...],
    Field(min_length=1, max_length=3),
    FromList,
]

#: A stress in Pa, or as a text with a unit.
Stress = Annotated[Positive, InPascal]

Name = Annotated[str, Field(min_length=1)]


#: Letters of a text that fits into a picture.
_LETTERS = 200


def _drawn(text: str) -> str:
    """A text of one line that can be drawn."""
    if not text.isprintable():
        raise PydanticCustomError(WRONG_LENGTH, "must be one line of text")
    if len(text) > _LETTERS:
        raise PydanticCustomError(WRONG_LENGTH, f"must be {_LETTERS} letters at most")
    return text


def _one_line(text: str) -> str:
    """A text of one line that can be read."""
    if not text.strip() or not text.isprintable():
        raise PydanticCustomError(WRONG_LENGTH, "must be one line of text, not empty")
    return text


#: A line of text that is drawn into pictures, which may be empty.
Title = Annotated[str, AfterValidator(_drawn)]

#: A name that is shown in tables and pictures.
Label = Annotated[str, AfterValidator(_one_line), AfterValidator(_drawn)]

Names = Annotated[tuple[str, ...], Field(min_length=1), FromList]

#: Directions along an axis, either way.
Along = Literal["x", "-x", "y", "-y", "z", "-z"]

_AXES: dict[str, tuple[float, ...]] = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-x": (-1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "-z": (0.0, 0.0, -1.0),
}


def axis_vector(axis: str | tuple[float, ...] | None) -> tuple[float, ...]:
    """The vector of "x", "-x", "y" ... or of a vector, empty for none."""
    return _AXES[axis] if isinstance(axis, str) else axis or ()


class Record(BaseModel):
    """A section of a study file: frozen, without unknown keys.

    Attributes:
        absent: Keys that one may look for here in vain, with what is to be known of them.
    """

    absent: ClassVar[Mapping[str, str]] = {}

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, defer_build=True)


def fitted(given: str | tuple[float, ...], dim: int, name: str) -> tuple[float, ...]:
    """A vector, or a direction such as "-y", with as many components as the mesh has dimensions.

    Raises:
        ModelError: if it has fewer, or others that are not zero.
    """
    vector = axis_vector(given)
    if isinstance(given, str) and any(vector[dim:]):
        raise ModelError(f'{name} = "{given}": must be along one of the {dim} axes of the mesh')
    if len(vector) < dim or any(vector[dim:]):
        raise ModelError(f"{name} = {list(vector)}: must have {dim} components as the mesh has")
    return vector[:dim]
