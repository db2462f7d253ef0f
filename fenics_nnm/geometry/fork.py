"""A tuning fork in two or three dimensions."""

from typing import Literal, Self

from pydantic import Field, model_validator

from fenics_nnm.geometry.lengths import LengthUnit
from fenics_nnm.geometry.parameters import GeometryRecord, GmshModel, Length
from fenics_nnm.geometry.rectangles import Edge, Rectangles


class Pads(GeometryRecord):
    """Layers on the facing sides of the tines, at their ends."""

    length: Length = Field(description="length along y, in length_unit")
    thickness: Length = Field(description="thickness along x, in length_unit")


class Fork(GeometryRecord):
    """Two tines along +y on a foot, symmetric about x = 0; the foot's upper edge is at y = 0.

    Groups: cells "body"; "foot" (lowest facets), "left inner" and "right inner" (the tines'
    facing sides), "left outer" and "right outer", "left tip" and "right tip" (their ends).
    With pads also "left pad" and "right pad" (their facing sides), and the cells "pads" and
    "metal"; the inner sides end below the pads.
    """

    model: Literal["fork"] = "fork"
    length_unit: LengthUnit = Field(
        default="m", description="unit of the lengths here and of the mesh"
    )
    length: Length = Field(description="length of the tines along y, in length_unit")
    width: Length = Field(description="width of a tine along x, in length_unit")
    distance: Length = Field(description="distance between the tines, in length_unit")
    foot: Length = Field(description="length of the foot along y, in length_unit")
    depth: Length | None = Field(
        default=None, description="length along z, in length_unit; without it a plane body"
    )
    pads: Pads | None = Field(
        default=None, description="{ length, thickness } of pads on the facing sides"
    )
    element_size: Length = Field(description="largest edge length of the elements, in length_unit")

    @model_validator(mode="after")
    def _pads_have_room(self) -> Self:
        pads = self.pads
        if pads is not None and pads.length >= self.length:
            raise ValueError(
                f"pads.length = {pads.length:g}: must be below length = {self.length:g}"
            )
        if pads is not None and 2 * pads.thickness >= self.distance:
            raise ValueError(
                f"pads.thickness = {pads.thickness:g}: must be below {self.distance / 2:g}, half "
                "the distance"
            )
        return self

    def build(self, gmsh_model: GmshModel) -> None:
        """Fill the current gmsh model with geometry, mesh and named groups."""
        if self.pads is None:
            body, groups = self._bare()
            body.build(gmsh_model, groups)
        else:
            body, groups = self._padded(self.pads)
            pads = [(1, 2), (3, 2)]
            metal = [cell for cell in body.filled if cell not in pads]
            body.build(gmsh_model, groups, {"pads": pads, "metal": metal})

    def _bare(self) -> tuple[Rectangles, dict[str, list[Edge]]]:
        inner = self.distance / 2
        outer = inner + self.width
        body = Rectangles(
            x=(-outer, -inner, inner, outer),
            y=(-self.foot, 0.0, self.length),
            filled=((0, 0), (1, 0), (2, 0), (0, 1), (2, 1)),
            size=self.element_size,
            depth=self.depth,
        )
        return body, {
            "foot": [("x", 0, 0), ("x", 1, 0), ("x", 2, 0)],
            "left inner": [("y", 1, 1)],
            "right inner": [("y", 2, 1)],
            "left outer": [("y", 0, 1)],
            "right outer": [("y", 3, 1)],
            "left tip": [("x", 0, 2)],
            "right tip": [("x", 2, 2)],
        }

    def _padded(self, pads: Pads) -> tuple[Rectangles, dict[str, list[Edge]]]:
        inner = self.distance / 2
        outer, face = inner + self.width, inner - pads.thickness
        columns, tines = range(5), ((0, 1), (4, 1), (0, 2), (4, 2))
        body = Rectangles(
            x=(-outer, -inner, -face, face, inner, outer),
            y=(-self.foot, 0.0, self.length - pads.length, self.length),
            filled=(*((i, 0) for i in columns), *tines, (1, 2), (3, 2)),
            size=self.element_size,
            depth=self.depth,
        )
        return body, {
            "foot": [("x", i, 0) for i in columns],
            "left inner": [("y", 1, 1)],
            "right inner": [("y", 4, 1)],
            "left outer": [("y", 0, 1), ("y", 0, 2)],
            "right outer": [("y", 5, 1), ("y", 5, 2)],
            "left tip": [("x", 0, 3)],
            "right tip": [("x", 4, 3)],
            "left pad": [("y", 2, 2)],
            "right pad": [("y", 3, 2)],
        }
