"""A cantilever with a tip shroud in two dimensions."""

from typing import Literal, Self

from pydantic import Field, model_validator

from fenics_nnm.geometry.parameters import GeometryRecord, GmshModel, Length, LengthUnit
from fenics_nnm.geometry.rectangles import Rectangles


class Shroud(GeometryRecord):
    """Blade along +y from y = 0, symmetric about x = 0, under a plate across its tip.

    Groups: cells "body"; edges "root" (y = 0), "shroud left" and "shroud right" (the ends of the
    plate, which meet stops or neighbours), "shroud top", "left" and "right" (the blade's sides).
    """

    model: Literal["shroud"] = "shroud"
    length_unit: LengthUnit = Field(
        default="m", description="unit of the lengths here and of the mesh"
    )
    length: Length = Field(description="length of the blade along y, in length_unit")
    width: Length = Field(description="width of the blade along x, in length_unit")
    shroud_length: Length = Field(description="length of the shroud along x, in length_unit")
    shroud_height: Length = Field(description="height of the shroud along y, in length_unit")
    element_size: Length = Field(description="largest edge length of the elements, in length_unit")

    @model_validator(mode="after")
    def _shroud_is_wider(self) -> Self:
        if self.shroud_length <= self.width:
            raise ValueError(
                f"shroud_length = {self.shroud_length:g}: must be above width = {self.width:g}"
            )
        return self

    def build(self, gmsh_model: GmshModel) -> None:
        """Fill the current gmsh model with geometry, mesh and named groups."""
        half, wide = self.width / 2, self.shroud_length / 2
        body = Rectangles(
            x=(-wide, -half, half, wide),
            y=(0.0, self.length, self.length + self.shroud_height),
            filled=((1, 0), (0, 1), (1, 1), (2, 1)),
            size=self.element_size,
        )
        body.build(
            gmsh_model,
            {
                "root": [("x", 1, 0)],
                "shroud left": [("y", 0, 1)],
                "shroud right": [("y", 3, 1)],
                "shroud top": [("x", 0, 2), ("x", 1, 2), ("x", 2, 2)],
                "left": [("y", 1, 0)],
                "right": [("y", 2, 0)],
            },
        )
