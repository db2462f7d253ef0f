"""Stress fields of a motion at the nodes of a part, one row of numbers for each component."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.field_names import FieldName
from fenics_nnm.fields.frames import Frames
from fenics_nnm.fields.invariants import principal, von_mises
from fenics_nnm.fields.peak import ABOVE_LINEAR, PEAKS, above_linear, linear_reversals, peaks
from fenics_nnm.fields.shapes import MotionShapes
from fenics_nnm.fields.stress_basis import StressBasis
from fenics_nnm.results.stored_branch import PlacedMotion

VON_MISES = "von Mises stress (Pa)"
PRINCIPAL = tuple(f"{which} principal stress (Pa)" for which in ("largest", "middle", "smallest"))

#: Nodes whose stress at all instants is held in memory at once.
_NODES_AT_ONCE = 2_000


@dataclass(frozen=True, slots=True)
class StressRows:
    """Which rows there are: those of each distinct frame, then the peaks.

    Attributes:
        fields: Fields wanted.
        frames: Frames of a period.
        beside_linear: Whether peaks stand beside those of the linear mode of the same energy, as
            those of free motions do.
    """

    fields: Sequence[FieldName]
    frames: Frames
    beside_linear: bool = True

    @property
    def names(self) -> dict[str, int]:
        """Stress fields of a frame, and the number of their components."""
        names: dict[str, int] = {}
        if "von_mises" in self.fields:
            names[VON_MISES] = 1
        if "principal_stress" in self.fields:
            names.update(dict.fromkeys(PRINCIPAL, 1))
        if "stress" in self.fields:
            names["stress (Pa)"] = 6
        return names

    @property
    def of_frame(self) -> int:
        """Number of rows of a frame."""
        return sum(self.names.values())

    @property
    def peaks(self) -> slice:
        """Rows of the peaks; none if they are not wanted."""
        start = self.frames.distinct * self.of_frame
        return slice(start, start + len(self.peak_names) * ("peak_stress" in self.fields))

    @property
    def peak_names(self) -> tuple[str, ...]:
        """Fields of the peaks."""
        return (*PEAKS, *ABOVE_LINEAR) if self.beside_linear else PEAKS

    @property
    def count(self) -> int:
        """Number of all rows of a motion."""
        return self.peaks.stop

    def named(self, rows: Array) -> dict[str, Array]:
        """Fields of a frame from its rows (rows, nodes): each (nodes,) or (nodes, components)."""
        starts = accumulate(self.names.values(), initial=0)
        return {
            name: np.ascontiguousarray(rows[start : start + count].T) if count > 1 else rows[start]
            for (name, count), start in zip(self.names.items(), starts, strict=False)
        }

    def amounts(self, shapes: MotionShapes, point: PlacedMotion) -> tuple[Array, Array]:
        """Amounts of shapes, each (k, shapes): at all instants, and in the linear mode beside."""
        moved = shapes.amounts(point, 2 * np.pi * self._instants()[0])
        return moved, linear_reversals(shapes, point) if self.beside_linear else moved[:0]

    def _instants(self) -> tuple[Array, Indices]:
        """Times at which stress is sought, and where those of the frames are there."""
        if "peak_stress" in self.fields:
            return self.frames.searched()
        return self.frames.times, np.arange(self.frames.distinct)

    def at(self, basis: StressBasis, point: PlacedMotion) -> Array:
        """All rows of a motion at the nodes of a part, shape (rows, nodes)."""
        times, of_frames = self._instants()
        moved, linear = self.amounts(basis.shapes, point)
        found = np.empty((self.count, basis.stresses.shape[2]))
        for start in range(0, found.shape[1], _NODES_AT_ONCE):
            few = slice(start, start + _NODES_AT_ONCE)
            stress = basis.stress(moved, few)
            mises = von_mises(stress)
            shown = self._of_frames(stress[of_frames], mises[of_frames])
            found[: self.peaks.start, few] = shown
            if "peak_stress" in self.fields:
                found[self.peaks, few] = self._peaks(
                    times, (stress, mises), basis.stress(linear, few)
                )
        return found

    def _peaks(self, times: Array, stresses: tuple[Array, Array], linear: Array) -> Array:
        """Rows of the peaks of stresses and their von Mises stress, shape (peaks, nodes)."""
        stress, mises = stresses
        own = peaks(times, stress, mises)
        return np.vstack([own, above_linear(mises, linear)]) if self.beside_linear else own

    def _of_frames(self, stress: Array, mises: Array) -> Array:
        """Rows of frames from stresses (frames, nodes, 6), frame by frame."""
        parts: list[Array] = []
        if "von_mises" in self.fields:
            parts.append(mises[:, None])
        if "principal_stress" in self.fields:
            parts.append(np.moveaxis(principal(stress), -1, 1))
        if "stress" in self.fields:
            parts.append(np.moveaxis(stress, -1, 1))
        return np.concatenate(parts, axis=1).reshape(-1, mises.shape[1]) if parts else mises[:0]
