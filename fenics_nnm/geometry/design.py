"""Blade sections from design quantities along the span: chord, stagger, camber, thickness.

Each section lies on a cylinder about the machine axis, unrolled to the plane of x and s = r theta.
Its mean line is a circular arc whose chord makes the stagger angle with the axis and whose two
tangents differ by the camber angle. Half the thickness is laid off to either side, normal to the
mean line. With the fraction xi of the arc length and thickness t, t_e at the edges:

    naca        10 t (0.2969 sqrt(xi) - 0.126 xi - 0.3516 xi^2 + 0.2843 xi^3 - 0.1036 xi^4) + t_e xi
    biconvex    t_e + 4 (t - t_e) xi (1 - xi)

The first is that of the four-digit series (NACA Report 460) with a closed trailing edge, and a
wedge that opens it to t_e.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator
from scipy.interpolate import PchipInterpolator

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.csv_table import CsvTable, Row, with_units
from fenics_nnm.geometry.lengths import METRES
from fenics_nnm.geometry.parameters import Coordinate, GeometryRecord, Length
from fenics_nnm.geometry.section_lines import SectionLines, cartesian

Profile = Literal["naca", "biconvex"]

_SPACES = 12  # along the span, at least: the loft then follows twist and taper between the sections
_LENGTHS = ("chord", "thickness", "edge_thickness", "lean", "sweep")
_NACA = np.array([-0.1260, -0.3516, 0.2843, -0.1036])  # of xi, xi^2, xi^3, xi^4
_FINE = 400  # points along the mean line for the centre of area

Angle = Annotated[float, Field(gt=-90, lt=90, strict=True)]


class DesignSection(GeometryRecord):
    """One row of a design table; lengths in the length_unit of the geometry, angles in degrees."""

    r: Length = Field(description="distance from the machine axis, in length_unit")
    chord: Length = Field(description="length of the chord, in length_unit")
    stagger: Angle = Field(
        description="angle of the chord from the machine axis in degrees, positive towards "
        "larger theta downstream"
    )
    camber: Annotated[float, Field(gt=-180, lt=180, strict=True)] = Field(
        default=0.0,
        description="angle between the mean line's ends in degrees: inlet minus outlet angle",
    )
    thickness: Length = Field(description="largest thickness, in length_unit")
    edge_thickness: Length | None = Field(
        default=None,
        description="thickness of the trailing edge, and of the leading edge if biconvex; "
        "without it a tenth of thickness",
    )
    lean: Coordinate = Field(default=0.0, description="shift towards larger theta, in length_unit")
    sweep: Coordinate = Field(default=0.0, description="shift downstream, along x, in length_unit")

    @model_validator(mode="after")
    def _edges_are_thin(self) -> Self:
        edge = self.edge_thickness
        if edge is not None and edge >= self.thickness:
            raise ValueError(f"edge_thickness = {edge:g}: must be below thickness")
        if self.thickness > 0.5 * self.chord:
            raise ValueError(f"thickness = {self.thickness:g}: must be at most half the chord")
        return self

    def values(self) -> tuple[float, ...]:
        """Chord, stagger, camber, thickness, edge thickness, lean, sweep."""
        edge = self.edge_thickness or 0.1 * self.thickness
        angles = np.radians(self.stagger), np.radians(self.camber)
        return self.chord, *angles, self.thickness, edge, self.lean, self.sweep


def is_design(table: CsvTable) -> bool:
    """Whether a table of sections holds design quantities, known by its column chord_<unit>."""
    return any(name in with_units("chord") for name in table.header)


def read_design(table: CsvTable, length_unit: str) -> tuple[DesignSection, ...]:
    """Sections of a design table, with lengths in `length_unit`.

    Columns: r_<unit>, chord_<unit>, stagger_deg, thickness_<unit>; one of camber_deg and
    camber_<unit> (largest camber) or neither; optional edge_thickness_<unit>, lean_<unit>,
    sweep_<unit>.

    Raises:
        GeometryError: A line that names the file, and the line and column, and what is wrong.
    """
    names = {"r": table.column_with_unit("r"), "stagger": table.column("stagger_deg")}
    for length in _LENGTHS:
        needed = length in ("chord", "thickness")
        if needed or any(name in with_units(length) for name in table.header):
            names[length] = table.column_with_unit(length)
    if any(name.startswith("camber") for name in table.header):
        names["camber"] = table.column("camber_deg", *with_units("camber"))
    unknown = sorted(set(table.header) - set(names.values()))
    if unknown:
        raise GeometryError(f"{table.file}: column {unknown[0]}: is not one of a design table")
    return tuple(_section(row, names, length_unit) for row in table.rows)


def design_lines(
    sections: Sequence[DesignSection], *, profile: Profile, edge_cut: float, count: int
) -> list[SectionLines]:
    """Both sides of a blade at enough radii; in between its values are monotone cubics of r.

    Args:
        sections: Sections of rising radius, two or more.
        profile: Distribution of the thickness.
        edge_cut: Fraction of the mean line left out at the round nose of "naca".
        count: Number of points along each side.
    """
    radii = np.array([section.r for section in sections])
    values = PchipInterpolator(radii, np.array([section.values() for section in sections]))
    spaces = np.maximum(1, np.ceil(_SPACES * np.diff(radii) / np.ptp(radii) - 1e-9)).astype(int)
    pieces = [
        np.linspace(inner, outer, n + 1)[:-1]
        for (inner, outer), n in zip(pairwise(radii), spaces, strict=True)
    ]
    start = edge_cut if profile == "naca" else 0.0
    return [
        _lines(radius, _Shape(*values(radius)), profile=profile, start=start, count=count)
        for radius in [*np.concatenate(pieces), radii[-1]]
    ]


def _section(row: Row, names: dict[str, str], length_unit: str) -> DesignSection:
    """One row, with lengths in `length_unit`."""
    given = {}
    for key, column in names.items():
        unit = column.rsplit("_", 1)[1]
        given[key] = (
            row.number(column)
            * METRES.get(unit, 1.0)
            / (METRES[length_unit] if unit in METRES else 1.0)
        )
    if names.get("camber", "camber_deg") != "camber_deg":  # f = chord / 2 tan(camber angle / 4)
        given["camber"] = float(np.degrees(4 * np.arctan(2 * given["camber"] / given["chord"])))
    try:
        return DesignSection(**given)
    except ValueError as error:
        raise GeometryError(f"{row.place}: {_reason(error)}") from error


def _reason(error: ValueError) -> str:
    """First message of pydantic in a line."""
    first = error.errors()[0]  # type: ignore[attr-defined]
    message = first["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    name = f"{first['loc'][-1]} = {first['input']:g}: " if first["loc"] else ""
    return f"{name}{message}"


@dataclass(frozen=True, slots=True)
class _Shape:
    """One section, with lengths in the unit of the geometry and angles in radians."""

    chord: float
    stagger: float
    camber: float
    thickness: float
    edge: float
    lean: float
    sweep: float

    def thick(self, xi: np.ndarray, profile: Profile) -> np.ndarray:
        """Thickness at fractions of the arc length."""
        if profile == "biconvex":
            return self.edge + 4 * (self.thickness - self.edge) * xi * (1 - xi)
        powers = xi[:, None] ** np.arange(1, 5)
        naca = 10 * self.thickness * (0.2969 * np.sqrt(xi) + powers @ _NACA)
        return np.asarray(naca + self.edge * xi)

    def mean(self, xi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean line from the leading edge on, shape (n, 2), and the angles of its tangents."""
        angle = self.stagger + self.camber * (0.5 - xi)
        # chord of the arc up to xi: a circular arc turns at a constant rate
        turned = xi * np.sinc(self.camber * xi / 2 / np.pi) / np.sinc(self.camber / 2 / np.pi)
        part = turned * self.chord
        towards = self.stagger + self.camber * (1 - xi) / 2
        return part[:, None] * np.stack([np.cos(towards), np.sin(towards)], axis=-1), angle

    def centre(self, profile: Profile) -> np.ndarray:
        """Centre of area."""
        fine = np.linspace(0, 1, _FINE + 1)
        weight = self.thick(fine, profile) * np.where((fine == 0) | (fine == 1), 0.5, 1.0)
        return np.asarray(weight @ self.mean(fine)[0] / weight.sum())


def _lines(
    radius: float, shape: _Shape, *, profile: Profile, start: float, count: int
) -> SectionLines:
    """Sides of one section on its cylinder, with its centre of area at (sweep, lean)."""
    parameter = 0.5 * (1 - np.cos(np.pi * np.linspace(0, 1, count)))
    xi = start + (1 - start) * parameter
    line, angle = shape.mean(xi)
    thick = shape.thick(xi, profile)
    normal = np.stack([-np.sin(angle), np.cos(angle)], axis=-1) * thick[:, None] / 2
    shifted = line - shape.centre(profile) + [shape.sweep, shape.lean]
    sides = [
        cartesian(plane[:, 0], np.full(count, radius), plane[:, 1] / radius)
        for plane in (shifted + normal, shifted - normal)
    ]
    return SectionLines(parameter, np.stack(sides))
