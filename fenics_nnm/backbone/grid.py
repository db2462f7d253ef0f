"""Ratios to visit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fenics_nnm.errors import ModelError


def grid(start: float, stop: float, step: float, among: Sequence[float] = ()) -> list[float]:
    """Equal steps no larger than `step` from `start` to `stop`, and the values `among` them."""
    count = int(np.ceil((stop - start) / step - 1e-9))
    even = start + (stop - start) * np.arange(count + 1) / count
    free = [value for value in even if all(abs(value - other) > 1e-9 * other for other in among)]
    return sorted({*(float(value) for value in free), *among})


def assert_ascending(start: float, stop: float) -> None:
    """Refuse energies that do not ascend.

    Raises:
        ModelError: unless 0 < start < stop.
    """
    if not 0 < start < stop:
        raise ModelError(f"energies from {start:g} to {stop:g}: must be 0 < from < to")
