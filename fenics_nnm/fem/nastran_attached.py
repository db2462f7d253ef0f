"""Masses at points and springs to the ground of Nastran bulk data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.constraints import NOTHING, Six
from fenics_nnm.fem.nastran_cards import BulkCard
from fenics_nnm.fem.nastran_rigid import along, point_mass
from fenics_nnm.fem.nastran_systems import Systems

#: Cards that are followed where they hold one GRID in directions of the basic system.
NAMES = ("CONM2", "CELAS1", "CELAS2", "CMASS1", "CMASS2")


@dataclass(frozen=True, slots=True)
class _End:
    """GRID and direction from 1 to 6 that a scalar element holds."""

    grid: int
    direction: int


def grid_of(card: BulkCard) -> int:
    """GRID that a card of `NAMES` holds.

    Raises:
        MeshError: if it joins two GRIDs.
    """
    return card.whole(1) if card.name == "CONM2" else _ground_end(card).grid


def carried(
    card: BulkCard, properties: Mapping[tuple[str, int], BulkCard], systems: Systems
) -> tuple[Six, Six]:
    """Mass and stiffness of a GRID with rotations, in the unit of the file.

    Args:
        card: One of `NAMES`.
        properties: Cards of properties by name and number.
        systems: GRIDs of the file.

    Raises:
        MeshError: as `attached`, but rotations and offsets can be followed.
    """
    if card.name == "CONM2":
        return point_mass(card), NOTHING
    end = _ground_end(card)
    _assert_basic(card, end, systems)
    six = along(end.direction - 1, _not_negative(card, _value(card, properties)))
    return (NOTHING, six) if card.name.startswith("CELAS") else (six, NOTHING)


def attached(
    card: BulkCard, properties: Mapping[tuple[str, int], BulkCard], systems: Systems
) -> Attachment:
    """A mass or springs at a GRID, in the unit of the file.

    Args:
        card: One of `NAMES`.
        properties: Cards of properties by name and number.
        systems: GRIDs of the file.

    Raises:
        MeshError: if it joins two GRIDs, has an offset or acts on rotations.
    """
    if card.name == "CONM2":
        if any(card.real(index) for index in (4, 5, 6)) or card.whole(2, 0) < 0:
            raise MeshError(
                f"{card.place}: CONM2 cannot be followed: it has an offset from its GRID"
            )
        values = (card.real(3),) * 3
        return _at(card, "mass", values, card.whole(1), systems)
    end = _ground_end(card)
    if end.direction not in (1, 2, 3):
        raise MeshError(
            f"{card.place}: {card.name} cannot be followed: it acts on direction "
            f"{end.direction}: must be 1, 2 or 3"
        )
    _assert_basic(card, end, systems)
    value = _value(card, properties)
    shares = tuple(value if end.direction == axis else 0.0 for axis in (1, 2, 3))
    kind = "spring" if card.name.startswith("CELAS") else "mass"
    return _at(card, kind, shares, end.grid, systems)


def _assert_basic(card: BulkCard, end: _End, systems: Systems) -> None:
    if systems.grids[end.grid].whole(5, 0) if end.grid in systems.grids else 0:
        raise MeshError(
            f"{card.place}: {card.name} cannot be followed: GRID {end.grid} has a system of its "
            "own for displacements"
        )


def _not_negative(card: BulkCard, value: float) -> float:
    if not 0 <= value < float("inf"):
        raise MeshError(f"{card.place}: {card.name}: must not be negative")
    return value


def _at(
    card: BulkCard, kind: str, values: tuple[float, ...], grid: int, systems: Systems
) -> Attachment:
    for value in values:
        _not_negative(card, value)
    place = systems.place(grid, card.place)
    key = f"{card.place}: {card.name}"
    point = float(place[0]), float(place[1]), float(place[2])
    return Attachment(key, "mass" if kind == "mass" else "spring", values, point)


def _ground_end(card: BulkCard) -> _End:
    """The one end that a scalar element has; the other one is the ground."""
    ends = [
        _End(card.whole(grid), card.whole(grid + 1, 0))
        for grid in (2, 4)
        if card.has(grid) and card.whole(grid)
    ]
    if len(ends) != 1:
        raise MeshError(f"{card.place}: {card.name} cannot be followed: it joins two GRIDs")
    if ends[0].direction not in range(1, 7):
        raise MeshError(
            f"{card.place}: {card.name}: direction {ends[0].direction}: must be one of 1 to 6"
        )
    return ends[0]


def _value(card: BulkCard, properties: Mapping[tuple[str, int], BulkCard]) -> float:
    """Stiffness or mass: of the card, or of its property."""
    if card.name.endswith("2"):
        return card.real(1)
    name, number = "PELAS" if card.name == "CELAS1" else "PMASS", card.whole(1)
    if (name, number) not in properties:
        raise MeshError(f"{card.place}: there is no {name} {number}")
    return properties[name, number].real(1)
