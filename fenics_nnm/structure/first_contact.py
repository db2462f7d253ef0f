"""At which energy contact begins: of the contact points, and of all vertices of the patches."""

from __future__ import annotations

from dataclasses import dataclass

#: Energies of first contact that differ by more than this part are warned about.
_APART = 0.01

#: Those that differ by less are the same.
_ROUND_OFF = 1e-9


@dataclass(frozen=True, slots=True)
class FirstContact:
    """First contact of the followed mode.

    Attributes:
        points: Number of contact points.
        vertices: Number of vertices of the patches, or of other places where contact can be.
        energy: Energy in J at which the first contact point touches, or lifts off.
        over_all: Energy in J at which the first vertex touches, or a contact point lifts off.
        place: Which contact point comes first: where it is, or its number.
    """

    points: int
    vertices: int
    energy: float
    over_all: float
    place: str = ""

    @property
    def excess(self) -> float:
        """By which part the energy of the contact points is above that of all vertices.

        It is 0 where they differ by round-off, and where gaps are so small that energies underflow.
        """
        part = self.energy / self.over_all - 1 if self.over_all else 0.0
        return part if abs(part) > _ROUND_OFF else 0.0

    @property
    def limited(self) -> bool:
        """Whether some vertices are no contact points."""
        return self.points < self.vertices

    def __str__(self) -> str:
        """What it is over all vertices, and how far the contact points are from that."""
        if not self.limited:
            return f"all {self.vertices} vertices are contact points"
        return (
            f"with all {self.vertices} vertices it is at {self.over_all:.6g} J; "
            f"the {self.points} contact points are {100 * self.excess:.2g} % above that"
        )

    @property
    def warning(self) -> str:
        """What is wrong if the contact points are far from all vertices; nothing if near."""
        if self.excess <= _APART:
            return ""
        return (
            f"contact begins at {self.energy:.6g} J at the {self.points} contact points, "
            f"{100 * self.excess:.3g} % above the {self.over_all:.6g} J of all {self.vertices} "
            "vertices of the patches: raise contact.points"
        )
