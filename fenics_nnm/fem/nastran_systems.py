"""Systems of coordinates of Nastran bulk data, and GRIDs given in them."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, radians, sin

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import MeshError
from fenics_nnm.fem.nastran_cards import BulkCard

#: Cards of systems: by three points of another system, or by three GRIDs.
BY_POINTS = ("CORD2R", "CORD2C", "CORD2S")
BY_GRIDS = ("CORD1R", "CORD1C", "CORD1S")


@dataclass(frozen=True, slots=True)
class _System:
    """Origin, axes as columns, and R, C or S."""

    origin: Array
    axes: Array
    kind: str

    def place(self, x: Array) -> Array:
        """Point in the basic system; angles are in degrees, that of S from the z axis first."""
        a, b = radians(x[1]), radians(x[2])
        own = {
            "R": np.asarray(x),
            "C": np.array([x[0] * cos(a), x[0] * sin(a), x[2]]),
            "S": x[0] * np.array([sin(a) * cos(b), sin(a) * sin(b), cos(a)]),
        }[self.kind]
        return np.asarray(self.origin + self.axes @ own)


@dataclass(slots=True)
class Systems:
    """All systems and GRIDs of a file; each is found when it is asked for.

    Attributes:
        cards: Card of each system, and for CORD1 the first of its fields there.
        grids: Card of each GRID.
        default: System of GRIDs that name none, of GRDSET.
    """

    cards: dict[int, tuple[BulkCard, int]] = field(default_factory=dict)
    grids: dict[int, BulkCard] = field(default_factory=dict)
    default: int = 0
    _systems: dict[int, _System] = field(default_factory=dict)
    _places: dict[int, Array] = field(default_factory=dict)
    _open: set[int] = field(default_factory=set)

    def take(self, card: BulkCard) -> bool:
        """Take a card of a system or GRID; whether it is one.

        Raises:
            MeshError: if a number stands twice with other fields.
        """
        if card.name == "GRID":
            known = self.grids.setdefault(card.whole(0), card)
            if known.fields[1:6] != card.fields[1:6]:
                raise MeshError(f"{card.place}: GRID {card.whole(0)} stands twice")
        elif card.name == "GRDSET":
            self.default = card.whole(1, 0)
        elif card.name in BY_POINTS:
            self.cards[card.whole(0)] = card, 0
        elif card.name in BY_GRIDS:
            for start in (0, 4):
                if card.has(start):
                    self.cards[card.whole(start)] = card, start
        else:
            return False
        return True

    def place(self, grid: int, where: str) -> Array:
        """Coordinates of a GRID in the basic system.

        Args:
            grid: Its number.
            where: What names it, for messages.

        Raises:
            MeshError: if there is no such GRID, or no such system.
        """
        if grid not in self.grids:
            raise MeshError(f"{where}: there is no GRID {grid}")
        if grid not in self._places:
            card = self.grids[grid]
            x = np.array([card.real(index) for index in (2, 3, 4)])
            self._places[grid] = self._system(card.whole(1, self.default), card.place).place(x)
        return self._places[grid]

    def _system(self, number: int, where: str) -> _System:
        if number == 0:
            return _System(np.zeros(3), np.eye(3), "R")
        if number not in self.cards:
            raise MeshError(
                f"{where}: there is no system of coordinates {number}: must be one of CORD2R, "
                "CORD2C, CORD2S, CORD1R, CORD1C, CORD1S"
            )
        if number not in self._systems:
            if number in self._open:
                raise MeshError(f"{where}: the system of coordinates {number} is made of itself")
            self._open.add(number)
            self._systems[number] = self._made(*self.cards[number])
            self._open.remove(number)
        return self._systems[number]

    def _made(self, card: BulkCard, start: int) -> _System:
        """Origin, a point on the z axis, and one in the x-z plane."""
        if card.name in BY_GRIDS:
            corners = [self.place(card.whole(start + i), card.place) for i in (1, 2, 3)]
        else:
            base = self._system(card.whole(1, 0), card.place)
            rows = [[card.real(i + j) for j in range(3)] for i in (2, 5, 8)]
            corners = [base.place(np.array(row)) for row in rows]
        origin, z, x = corners[0], corners[1] - corners[0], corners[2] - corners[0]
        y = np.cross(z, x)
        if not np.linalg.norm(y) > 1e-9 * np.linalg.norm(z) * np.linalg.norm(x):
            raise MeshError(f"{card.place}: {card.name}: its three points must not lie on a line")
        axes = [np.cross(y, z), y, z]
        columns = np.column_stack([axis / np.linalg.norm(axis) for axis in axes])
        return _System(origin, columns, card.name[-1])
