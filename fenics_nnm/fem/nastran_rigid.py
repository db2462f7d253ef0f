"""Rigid elements and multipoint constraints of Nastran bulk data, as linear constraints."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.constraint_builder import ALL, SHIFTS, ConstraintBuilder
from fenics_nnm.fem.constraints import Six, as_six, inertia_at
from fenics_nnm.fem.nastran_cards import BulkCard, Line
from fenics_nnm.fem.nastran_systems import Systems

#: Cards that are followed.
NAMES = ("RBE2", "RBE3", "RBAR", "RBAR1", "RROD", "MPC", "MPCADD")


#: Most GRIDs that a range may have.
_WIDEST = 1_000_000


class RigidElements:
    """Puts cards into constraints, one after the other."""

    def __init__(self, systems: Systems, builder: ConstraintBuilder[int]) -> None:
        """Prepare for the GRIDs of a file."""
        self._systems, self._builder = systems, builder
        self.notes: list[str] = []

    def take(self, card: BulkCard) -> None:
        """Take a card other than MPC and MPCADD.

        Raises:
            MeshError: if it cannot be followed.
        """
        how = {
            "RBE2": self._rbe2,
            "RBE3": self._rbe3,
            "RBAR": self._rbar,
            "RBAR1": self._rbar1,
            "RROD": self._rrod,
        }
        how[card.name](card)

    def _rbe2(self, card: BulkCard) -> None:
        reference, axes = card.whole(1), _axes(card, 2)
        fields = card.fields[3:]
        while fields and (not fields[-1] or not _is_whole(fields[-1])):
            fields = fields[:-1]  # ALPHA, a real number
        self._follow(card, reference, _grids(card, fields), axes)

    def _rbar(self, card: BulkCard) -> None:
        first, second = card.whole(1), card.whole(2)
        independent = [_axes(card, index, ()) for index in (3, 4)]
        dependent = [_axes(card, index, ()) for index in (5, 6)]
        if sorted(map(len, independent)) != [0, 6]:
            raise MeshError(
                f"{card.place}: RBAR cannot be followed: all six independent directions must be "
                "those of one GRID"
            )
        leads = 0 if independent[0] else 1
        ends = (first, second)
        self._follow(card, ends[leads], [ends[1 - leads]], dependent[1 - leads] or ALL)

    def _rbar1(self, card: BulkCard) -> None:
        self._follow(card, card.whole(1), [card.whole(2)], _axes(card, 3, ALL))

    def _rrod(self, card: BulkCard) -> None:
        self._builder.link(f"{card.place}: RROD", card.whole(1), card.whole(2))
        self.notes.append(f"RROD {card.whole(0)}: a rod of constant length")

    def _follow(
        self, card: BulkCard, reference: int, grids: list[int], axes: tuple[int, ...]
    ) -> None:
        if not set(SHIFTS) <= set(axes):
            self._assert_basic(card, grids)
        for grid in (reference, *grids):
            self._systems.place(grid, card.place)
        count = self._builder.rigid(f"{card.place}: {card.name}", reference, grids, axes)
        self.notes.append(f"{card.name} {card.whole(0)}: {count} nodes follow GRID {reference}")

    def _rbe3(self, card: BulkCard) -> None:
        """Groups of a weight, its directions and its GRIDs."""
        reference, axes = card.whole(2), _axes(card, 3)
        if "UM" in [entry.upper() for entry in card.fields]:
            raise MeshError(f"{card.place}: RBE3 cannot be followed: it has UM")
        weights: dict[int, tuple[float, ...]] = {}
        for weight, directions, grids in self._groups(card):
            if not set(SHIFTS) <= set(directions):
                self._assert_basic(card, grids)
            for grid in grids:
                before = weights.get(grid, (0.0, 0.0, 0.0))
                weights[grid] = tuple(
                    before[axis] + (weight if axis in directions else 0.0) for axis in SHIFTS
                )
        if set(axes) != set(ALL) and set(axes) != set(SHIFTS):
            self._assert_basic(card, [reference])
        self._systems.place(reference, card.place)
        self._builder.mean(f"{card.place}: RBE3", reference, weights, axes)
        self.notes.append(
            f"RBE3 {card.whole(0)}: GRID {reference} follows the mean of {len(weights)} nodes"
        )

    def _groups(self, card: BulkCard) -> Iterable[tuple[float, tuple[int, ...], list[int]]]:
        fields = card.fields
        end = next((i for i, entry in enumerate(fields) if entry.upper() == "ALPHA"), len(fields))
        filled = [i for i in range(4, end) if fields[i]]
        starts = [i for i in filled if "." in fields[i]]
        if not starts or filled[0] != starts[0]:
            raise MeshError(f"{card.place}: RBE3: its first weight must be a real number")
        for start, following in zip(starts, [*starts[1:], end], strict=True):
            own = [i for i in filled if start < i < following]
            if len(own) < 2:
                raise MeshError(f"{card.place}: RBE3: a weight must have directions and GRIDs")
            yield (
                card.real(start),
                _axes(card, own[0]),
                _grids(card, [fields[i] for i in own[1:]]),
            )

    def equations(self, card: BulkCard) -> None:
        """Take an MPC card.

        Raises:
            MeshError: if it cannot be followed.
        """
        terms = []
        starts = [i for k in range(0, len(card.fields), 8) for i in (k + 1, k + 4)]
        for start in starts:
            if card.has(start):
                (axis, *more) = _axes(card, start + 1, (0,))
                if more:
                    raise MeshError(f"{card.place}: MPC: each term must have one direction")
                terms.append((card.whole(start), axis, card.real(start + 2)))
        self._assert_basic(card, [grid for grid, _, _ in terms])
        for grid, _, _ in terms:
            self._systems.place(grid, card.place)
        self._builder.equation(f"{card.place}: MPC", terms)

    def _assert_basic(self, card: BulkCard, grids: Iterable[int]) -> None:
        """Refuse GRIDs whose directions are turned."""
        for grid in grids:
            if grid in self._systems.grids and self._systems.grids[grid].whole(5, 0):
                raise MeshError(
                    f"{card.place}: {card.name} cannot be followed: GRID {grid} has a system "
                    "of its own for displacements"
                )


def chosen_equations(cards: list[BulkCard], lines: list[Line]) -> tuple[list[BulkCard], str]:
    """The MPC cards that a case asks for, or all of one set without cases, and a note on others.

    Raises:
        MeshError: if cases ask for several sets, or several sets stand without cases.
    """
    head = []
    for line in lines:
        if re.match(r"\s*BEGIN\s+BULK", line.text.upper()):
            break
        head.append(line.text.partition("$")[0])
    else:
        head = []
    asked = {int(n) for text in head for n in re.findall(r"^\s*MPC\s*=\s*(\d+)", text.upper())}
    cased = any(re.match(r"\s*(SUBCASE|SPC|METHOD|MPC)\b", text.upper()) for text in head)
    single = [card for card in cards if card.name == "MPC"]
    sets = {card.whole(0) for card in single}
    if not cased:
        asked = sets
    if len(asked) > 1:
        raise MeshError(
            f"{cards[0].place}: MPC cannot be followed: sets {', '.join(map(str, sorted(asked)))} "
            "stand there: must be one"
        )
    for card in cards:
        if card.name == "MPCADD" and card.whole(0) in asked:
            asked = {card.whole(i) for i in range(1, len(card.fields)) if card.has(i)}
    left = sorted(sets - asked)
    note = f"not read: MPC {', '.join(map(str, left))}, which no case asks for" if left else ""
    return [card for card in single if card.whole(0) in asked], note


def point_mass(card: BulkCard) -> Six:
    """Mass and inertia of a CONM2 about its GRID.

    Raises:
        MeshError: if it is given in another system.
    """
    if card.whole(2, 0):
        raise MeshError(f"{card.place}: CONM2 cannot be followed: it has a system of its own")
    offset = np.array([card.real(index) for index in (4, 5, 6)])
    xx, yx, yy, zx, zy, zz = (card.real(index) for index in range(8, 14))
    inertia = np.array([[xx, -yx, -zx], [-yx, yy, -zy], [-zx, -zy, zz]])
    return inertia_at(card.real(3), offset, inertia)


def along(axis: int, value: float) -> Six:
    """Mass or stiffness along one axis."""
    return as_six(np.diag([value if axis == i else 0.0 for i in ALL]))


def _axes(card: BulkCard, index: int, default: tuple[int, ...] | None = None) -> tuple[int, ...]:
    """Axes of a field of directions, such as 123."""
    if not card.has(index) and default is not None:
        return default
    entry = card.fields[index] if card.has(index) else ""
    if not re.fullmatch(r"[1-6]+", entry):
        raise MeshError(f'{card.place}: {card.name}: directions "{entry}": must be of 1 to 6')
    return tuple(sorted({int(each) - 1 for each in entry}))


def _grids(card: BulkCard, fields: list[str]) -> list[int]:
    """Numbers of GRIDs, with ranges "1 THRU 9"."""
    found: list[int] = []
    entries = iter([entry for entry in fields if entry])
    for entry in entries:
        if entry.upper() != "THRU":
            found.append(_whole(card, entry))
            continue
        last = _whole(card, next(entries, ""))
        if not found or not 0 <= last - found[-1] <= _WIDEST:
            raise MeshError(
                f"{card.place}: {card.name}: THRU must stand between two GRIDs whose numbers are "
                f"at most {_WIDEST} apart"
            )
        found += range(found[-1] + 1, last + 1)
    return found


def _is_whole(entry: str) -> bool:
    return re.fullmatch(r"\d+", entry) is not None


def _whole(card: BulkCard, entry: str) -> int:
    if not _is_whole(entry):
        raise MeshError(f'{card.place}: {card.name}: "{entry}": must be the number of a GRID')
    return int(entry)
