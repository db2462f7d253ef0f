"""A cantilever with a tip shroud in two dimensions."""

from typing import Literal, Self

from pydantic import Field, model_validator

from fenics_nnm.geometry.lengths import LengthUnit
from fenics_nnm.geometry.parameters import GeometryRecord, GmshModel, Length
from fenics_nnm.geometry.rectangles import Rectangles


class Shroud(GeometryRecord):
    """Blade along +y from y = 0, symmetric about x = 0, under a plate across its tip.

    Groups: cells "body"; edges "root" (y = 0), "shroud left" and "shroud right" (the ends of the
    plate, which meet stops or neighbours), "shroud top", "left" and "right" (the blade's sides).
    With pads also the cells "pads" (both ends of the plate) and "metal" (all others).
    """

    model: Literal["shroud"] = "shroud"
    length_unit: LengthUnit = Field(
        default="m", description="unit of the lengths here and of the mesh"
    )
    length: Length = Field(description="length of the blade along y, in length_unit")
    width: Length = Field(description="width of the blade along x, in length_unit")
    shroud_length: Length = Field(description="length of the shroud along x, in length_unit")
    shroud_height: Length = Field(description="height of the shroud along y, in length_unit")
    pad_length: Length | None = Field(
        default=None,
        description="length along x of a pad at each end of the shroud, a part of shroud_length",
    )
    element_size: Length = Field(description="largest edge length of the elements, in length_unit")

    @model_validator(mode="after")
    def _shroud_is_wider(self) -> Self:
        if self.shroud_length <= self.width:
            raise ValueError(
                f"shroud_length = {self.shroud_length:g}: must be above width = {self.width:g}"
            )
        overhang = (self.shroud_length - self.width) / 2
        if self.pad_length is not None and self.pad_length >= overhang:
            raise ValueError(
                f"pad_length = {self.pad_length:g}: must be below {overhang:g}, as far as the "
                "shroud stands out on each side"
            )
        return self

    def build(self, gmsh_model: GmshModel) -> None:
        """Fill the current gmsh model with geometry, mesh and named groups."""
        half, wide, pad = self.width / 2, self.shroud_length / 2, self.pad_length
        ends = () if pad is None else (wide - pad,)
        lines = (half, *ends, wide)
        x = (*(-value for value in reversed(lines)), *lines)
        last, blade = len(x) - 1, len(lines) - 1  # the last line; the column of the blade
        plate = [(column, 1) for column in range(last)]
        body = Rectangles(
            x=x,
            y=(0.0, self.length, self.length + self.shroud_height),
            filled=((blade, 0), *plate),
            size=self.element_size,
        )
        pads = {"pads": [plate[0], plate[-1]], "metal": [(blade, 0), *plate[1:-1]]}
        body.build(
            gmsh_model,
            {
                "root": [("x", blade, 0)],
                "shroud left": [("y", 0, 1)],
                "shroud right": [("y", last, 1)],
                "shroud top": [("x", column, 2) for column, _ in plate],
                "left": [("y", blade, 0)],
                "right": [("y", blade + 1, 0)],
            },
            {} if pad is None else pads,
        )
