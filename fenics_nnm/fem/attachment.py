"""A mass, springs or a force at a body, as the study or a mesh file says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True)
class Attachment:
    """A mass, springs to the ground or a force, in the directions of the axes.

    Attributes:
        key: The study's section, or the line of a mesh file, for messages.
        kind: "mass", "spring" or "force".
        values: Mass in kg, stiffness in N/m or force in N along each axis, shape (dim,); per area,
            in kg/m^2 or N/m^3, if `per_area`.
        point: Coordinates in m that the nearest vertex is taken to; empty for facets.
        facets: Names of groups of facets that it is spread over evenly; empty for a point.
        per_area: Whether values are per area of the facets.
        cubic: Cubic stiffness of springs along each axis in N/m^3, that of all facets together and
            of their mean displacement, shape (dim,); empty for none.
    """

    key: str
    kind: Literal["mass", "spring", "force"]
    values: tuple[float, ...]
    point: tuple[float, ...] = ()
    facets: tuple[str, ...] = ()
    per_area: bool = False
    cubic: tuple[float, ...] = ()
