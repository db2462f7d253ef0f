"""Engine orders: multiples of the speed of rotation that excite a structure which turns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array

#: Orders within this part of the range of frequencies are near it.
_NEAR = 0.03

#: More orders than this say nothing: the structure turns slowly beside its frequencies.
_MOST = 8


@dataclass(frozen=True, slots=True)
class EngineOrder:
    """A multiple of the speed.

    Attributes:
        number: Which multiple.
        frequency: In Hz.
    """

    number: int
    frequency: float

    @property
    def name(self) -> str:
        """How it is called."""
        return f"engine order {self.number}"


def turns_a_second(study: Mapping[str, Any]) -> float:
    """Turns in a second of the values of a study; 0 at rest."""
    rotation = study.get("rotation", {})
    return abs(float(rotation.get("speed", 0.0)) / (2 * np.pi) + float(rotation.get("rpm", 0)) / 60)


def orders_near(study: Mapping[str, Any], hertz: Array) -> tuple[EngineOrder, ...]:
    """The engine orders among frequencies, or little beside them.

    Args:
        study: Values of a study.
        hertz: Frequencies in Hz.

    Returns:
        None without a speed, and where there are too many.
    """
    once = turns_a_second(study)
    if not once or not len(hertz):
        return ()
    low, high = float(np.min(hertz)) * (1 - _NEAR), float(np.max(hertz)) * (1 + _NEAR)
    numbers = range(int(np.ceil(low / once)), int(np.floor(high / once)) + 1)
    if len(numbers) > _MOST:
        return ()
    return tuple(EngineOrder(number, number * once) for number in numbers if number > 0)
