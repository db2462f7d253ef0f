"""A mass, springs, dashpots or a force at a body, as the study or a mesh file says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True)
class Attachment:
    """A mass, springs or dashpots to the ground, a force or a monitor, along the axes.

    Attributes:
        key: The study's section, or the line of a mesh file, for messages.
        kind: What it is.
        values: Mass in kg, stiffness in N/m, damping in N s/m, force in N or the direction of a
            monitor, along each axis, shape (dim,); per area of facets, if `per_area`.
        point: Coordinates in m that the nearest vertex is taken to; empty for facets.
        facets: Names of groups of facets that it is spread over evenly; empty for a point.
        per_area: Whether values are per area of the facets.
        cubic: Cubic stiffness of springs along each axis in N/m^3, that of all facets together and
            of their mean displacement, shape (dim,); empty for none.
    """

    key: str
    kind: Literal["mass", "spring", "dashpot", "force", "monitor"]
    values: tuple[float, ...]
    point: tuple[float, ...] = ()
    facets: tuple[str, ...] = ()
    per_area: bool = False
    cubic: tuple[float, ...] = ()
