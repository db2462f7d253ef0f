"""The largest displacement, stress and contact force of a point over its period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array

_NAN = float("nan")

#: A coordinate below this part of the largest one is zero.
_ROUND_OFF = 1e-12

#: Where stress grows without bound as a mesh gets finer; nothing elsewhere.
REGULAR, CORNER, CLAMP_EDGE, CONTACT = "", "corner", "clamp edge", "contact"
KINDS = (REGULAR, CORNER, CLAMP_EDGE, CONTACT)


@dataclass(frozen=True, slots=True)
class Spot:
    """An extreme value and its node; nan and -1 where there is none.

    Attributes:
        value: The value.
        node: Number of the node in the mesh of branch.h5, or of the unknown of matrices, from 0.
        place: Where it is in m.
    """

    value: float = _NAN
    node: int = -1
    place: tuple[float, float, float] = (_NAN, _NAN, _NAN)

    @property
    def known(self) -> bool:
        """Whether there is a value."""
        return not np.isnan(self.value)

    @property
    def at(self) -> str:
        """Its place in m as a text of three numbers; empty where it is not known."""
        if np.isnan(self.place[0]):
            return ""
        least = _ROUND_OFF * max(map(abs, self.place))
        return " ".join(f"{x if abs(x) > least else 0.0:.6g}" for x in self.place)


#: Where there is none.
NOWHERE = Spot()


@dataclass(frozen=True, slots=True)
class StressPeak:
    """Largest stress in Pa over the period.

    Attributes:
        away: Largest one away from contact points, the clamp's edge and sharp corners.
        anywhere: Largest one of all nodes, which is that of peak_stress_RATIO.vtu.
        kind: What is there, one of `KINDS`.
        quantile: The 99.9 % quantile over all nodes.
    """

    away: Spot = NOWHERE
    anywhere: Spot = NOWHERE
    kind: str = REGULAR
    quantile: float = _NAN


#: Stress that is not known.
NO_STRESS = StressPeak()


@dataclass(frozen=True, slots=True)
class PatchExtremes:
    """What a contact patch sees of a period.

    Attributes:
        displacement: Largest displacement of its nodes in m.
        force: Largest sum of its contact forces in N.
        impulse: Integral of this sum over the period in N s.
    """

    displacement: float
    force: float
    impulse: float


@dataclass(frozen=True, slots=True)
class Extremes:
    """Extremes of a motion over its period.

    Attributes:
        displacement: Largest displacement in m from the state of rest.
        patches: What each contact patch sees.
        force: Largest sum of all contact forces in N.
        impulse: Integral of this sum over the period in N s.
        von_mises: Largest von Mises stress.
        principal: Largest principal stress.
        yield_margin: Smallest yield strength over von Mises stress, away from singular places.
        goodman_margin: Smallest safety factor of Goodman's line there, see `fields.strength`.
    """

    displacement: Spot = NOWHERE
    patches: tuple[PatchExtremes, ...] = ()
    force: float = _NAN
    impulse: float = _NAN
    von_mises: StressPeak = NO_STRESS
    principal: StressPeak = NO_STRESS
    yield_margin: Spot = NOWHERE
    goodman_margin: Spot = NOWHERE

    @property
    def patch_displacement(self) -> float:
        """Largest displacement of any patch in m."""
        return max((patch.displacement for patch in self.patches), default=_NAN)

    @property
    def beyond(self) -> str:
        """Which strength is passed: "yield", "fatigue", or nothing."""
        if self.yield_margin.value < 1:
            return "yield"
        return "fatigue" if self.goodman_margin.value < 1 else ""


#: What is known of a point that was not measured, also as arrays.
UNKNOWN = Extremes()
_NO_SPOTS, _NO_NUMBERS, _NO_ROWS = np.empty((0, 5)), np.empty(0), np.empty((0, 3))


def packed(extremes: Extremes) -> dict[str, Array]:
    """Extremes as arrays, as branch.h5 has them: spots, numbers and patches; empty if unknown."""
    if not extremes.displacement.known:
        return {"extremes": _NO_SPOTS, "extreme_numbers": _NO_NUMBERS, "extreme_patches": _NO_ROWS}
    mises, principal = extremes.von_mises, extremes.principal
    spots = (
        extremes.displacement,
        *(mises.away, mises.anywhere, principal.away, principal.anywhere),
        *(extremes.yield_margin, extremes.goodman_margin),
    )
    numbers = [extremes.force, extremes.impulse, mises.quantile, principal.quantile]
    numbers += [KINDS.index(mises.kind), KINDS.index(principal.kind)]
    patches = [(each.displacement, each.force, each.impulse) for each in extremes.patches]
    return {
        "extremes": np.array([(each.value, each.node, *each.place) for each in spots]),
        "extreme_numbers": np.array(numbers, dtype=float),
        "extreme_patches": np.array(patches, dtype=float).reshape(-1, 3),
    }


def unpacked(spots: Array, numbers: Array, patches: Array) -> Extremes:
    """The extremes of such arrays; empty ones are of a point that was not measured."""
    if not len(spots):
        return UNKNOWN
    moved, mises, mises_anywhere, tension, tension_anywhere, yields, goodman = (
        Spot(float(value), int(node), (float(x), float(y), float(z)))
        for value, node, x, y, z in spots
    )
    force, impulse, *quantiles, first, second = (float(each) for each in numbers)
    return Extremes(
        displacement=moved,
        patches=tuple(PatchExtremes(*map(float, row)) for row in patches),
        force=force,
        impulse=impulse,
        von_mises=StressPeak(mises, mises_anywhere, KINDS[int(first)], quantiles[0]),
        principal=StressPeak(tension, tension_anywhere, KINDS[int(second)], quantiles[1]),
        yield_margin=yields,
        goodman_margin=goodman,
    )
