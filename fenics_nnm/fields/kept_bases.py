"""Stress bases of the parts of a body, kept from the measuring of a branch for its files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.arrays import Indices
from fenics_nnm.fields.stress_basis import StressBasis

#: Most bytes that are kept.
_MOST = 2**29


@dataclass(slots=True)
class KeptBases:
    """Bases by the number of their part; none of a body that is too large."""

    _kept: dict[int, StressBasis] = field(default_factory=dict)

    def forget(self) -> None:
        """Begin anew, with another branch."""
        self._kept.clear()

    def get(self, part: int, used: Indices, make: Callable[[], StressBasis]) -> StressBasis:
        """The basis of a part that knows some shapes, made if it is not kept."""
        kept = self._kept.pop(part, None)
        basis = kept if kept is not None and np.isin(used, kept.used).all() else make()
        size = sum(each.stresses.nbytes for each in self._kept.values())
        if size + basis.stresses.nbytes <= _MOST:
            self._kept[part] = basis
        return basis
