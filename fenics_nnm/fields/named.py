"""Motions that files are wanted of, and how they are named in these."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.results.stored_branch import PlacedMotion


@dataclass(frozen=True, slots=True)
class NamedMotion:
    """A motion that files are wanted of.

    Attributes:
        name: Its name in those of the files.
        short: Its name in those of fields.
        words: What it is, in words.
        weight: Of several motions that of the largest is shown first.
        point: The motion.
    """

    name: str
    short: str
    words: str
    weight: float
    point: PlacedMotion


def of_branch(points: Sequence[BranchPoint]) -> list[NamedMotion]:
    """Motions of a branch by their energy; later passings of an energy get a number."""
    passed: Counter[float] = Counter()
    named = []
    for point in points:
        passed[point.gamma_ratio] += 1
        again, ratio = passed[point.gamma_ratio], f"{point.gamma_ratio:g}"
        passing = f"passing{again}" if again > 1 else ""
        named.append(
            NamedMotion(
                name="_".join(part for part in (ratio, passing) if part),
                short=" ".join(part for part in ("gamma", ratio, passing) if part),
                words=f"gamma ratio {ratio}",
                weight=point.gamma_ratio,
                point=point,
            )
        )
    return named
