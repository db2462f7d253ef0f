"""Files of one motion: its frames, the contact surface, and where the stress is largest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Array, Indices, in_space
from fenics_nnm.fields.body import FieldBody
from fenics_nnm.fields.frame_files import VELOCITY, Frame, FrameFiles
from fenics_nnm.fields.frames import Frames
from fenics_nnm.fields.kept_bases import KeptBases
from fenics_nnm.fields.named import NamedMotion
from fenics_nnm.fields.shapes import MotionShapes
from fenics_nnm.fields.stress_basis import stress_basis, used_shapes
from fenics_nnm.fields.stress_rows import StressRows
from fenics_nnm.fields.surface import ContactSurface
from fenics_nnm.fields.table import PartTable
from fenics_nnm.results.stored_branch import PlacedMotion

DISPLACEMENT = "displacement (m)"
TOTAL = "displacement from the unloaded body (m)"
PRESSURE = "contact pressure (Pa)"
GAP = "gap (m)"

_OF_BODY = {
    "displacement",
    "total_displacement",
    "velocity",
    "von_mises",
    "principal_stress",
    "stress",
}
_OF_SURFACE = {"contact_pressure", "gap"}

#: Frames that are computed at once.
_AT_ONCE = 4


@dataclass(frozen=True, slots=True)
class Motion:
    """A motion that files are wanted of.

    Attributes:
        named: The motion and its names.
        first: First row of its stresses in the table.
    """

    named: NamedMotion
    first: int

    @property
    def name(self) -> str:
        """Its name in those of the files."""
        return self.named.name

    @property
    def point(self) -> PlacedMotion:
        """The motion itself."""
        return self.named.point

    @property
    def of_body(self) -> str:
        """Folder of the frames of the body."""
        return f"motion_{self.name}"

    @property
    def of_surface(self) -> str:
        """Folder of the frames of the contact surface."""
        return f"motion_{self.name}_contact"


@dataclass(frozen=True, slots=True)
class MotionFiles:
    """Writer of the motions of one branch: first stresses of all parts, then files in any order.

    Attributes:
        folder: Folder of the files.
        shapes: What the motions are made of.
        body: The body.
        surface: Its contact surface.
        rows: The fields wanted, and which rows the table has of a motion.
        table: Stresses, one motion after the other.
        body_frames: Writes frames of the body.
        surface_frames: Writes those of the contact surface.
        bases: Stresses of the shapes that are known already.
    """

    folder: Path
    shapes: MotionShapes
    body: FieldBody
    surface: ContactSurface
    rows: StressRows
    table: PartTable
    body_frames: FrameFiles
    surface_frames: FrameFiles
    bases: KeptBases = field(default_factory=KeptBases)

    @property
    def has_body(self) -> bool:
        """Whether frames of the body are wanted."""
        return bool(_OF_BODY & set(self.rows.fields))

    @property
    def has_surface(self) -> bool:
        """Whether frames of the contact surface are wanted."""
        return bool(_OF_SURFACE & set(self.rows.fields))

    def begin(self, motions: Sequence[Motion]) -> None:
        """Prepare the files and the table.

        Raises:
            OSError: if they cannot be made.
        """
        for name, files in self._listed(motions):
            files.begin(self.folder, name, self.rows.frames)
        self.table.make()

    def end(self, motions: Sequence[Motion]) -> None:
        """Complete the files; remove the table.

        Raises:
            OSError: if they cannot be written.
        """
        for name, files in self._listed(motions):
            files.end(self.folder, name, self.rows.frames)
        self.table.path.unlink()

    def used(self, motions: Sequence[Motion]) -> Indices:
        """Numbers of the shapes whose stresses make those of motions."""
        every = [self.rows.amounts(self.shapes, motion.point) for motion in motions]
        return used_shapes(self.shapes, chain.from_iterable(every))

    def keep_stresses(self, part: int, used: Indices, motions: Sequence[Motion]) -> None:
        """Put the stresses of motions, of some shapes, at the nodes of a part into the table.

        Raises:
            OSError: if they cannot be written.
        """
        make = partial(stress_basis, self.body, self.shapes, self.table.parts[part], used)
        basis = self.bases.get(part, used, make)
        for motion in motions:
            self.table.put(part, motion.first, self.rows.at(basis, motion.point))

    def write_body(self, motion: Motion, batches: Sequence[range]) -> None:
        """Write some distinct frames of the body and those that show the same.

        Raises:
            OSError: if they cannot be written.
        """
        made = (frame for few in batches for frame in self._frames_of_body(motion, few))
        self.body_frames.put(self.folder / motion.of_body, self.rows.frames, made)

    def _frames_of_body(self, motion: Motion, few: range) -> Iterator[Frame]:
        """Distinct frames that are computed at once."""
        of_frame = self.rows.of_frame
        moved = self._moved(motion.point, 2 * np.pi * self.rows.frames.times[few])
        for number, fields in zip(few, moved, strict=True):
            first = motion.first + number * of_frame
            yield number, fields | self.rows.named(self.table.read(slice(first, first + of_frame)))

    def _moved(self, point: PlacedMotion, phase: Array) -> Iterator[dict[str, Array]]:
        """Displacement and velocity on the grid at phases, if they are wanted."""
        ways = {
            "displacement": (DISPLACEMENT, self.shapes.amounts),
            "total_displacement": (TOTAL, self.shapes.amounts),
            "velocity": (VELOCITY, self.shapes.rates),
        }
        chosen = dict(way for field, way in ways.items() if field in self.rows.fields)
        amounts = [way(point, phase) for way in chosen.values()]
        moved = [self.shapes.fields(np.concatenate(amounts))] if amounts else []
        for place in range(len(phase)):
            own = (field for each in moved for field in each[place :: len(phase)])
            found = {name: self._on_grid(u) for name, u in zip(chosen, own, strict=True)}
            if TOTAL in found and self.shapes.branch.state is not None:
                found[TOTAL] = found[TOTAL] + self._on_grid(self.shapes.branch.state.displacement)
            yield found

    def _on_grid(self, values: Array) -> Array:
        """Vectors at the nodes of the branch's mesh, in space at those of the grid."""
        return in_space(self.body.on_grid(values))

    def write_surface(self, motion: Motion) -> None:
        """Write all frames of the contact surface.

        Raises:
            OSError: if they cannot be written.
        """
        made = self._frames_of_surface(motion)
        self.surface_frames.put(self.folder / motion.of_surface, self.rows.frames, made)

    def _frames_of_surface(self, motion: Motion) -> Iterator[Frame]:
        branch, frames = self.shapes.branch, self.rows.frames
        phase = 2 * np.pi * frames.times
        amounts = self.shapes.amounts(motion.point, phase)
        moved = np.tensordot(amounts, self.shapes.at(self.surface.nodes), 1)
        forces, gaps = branch.forces(motion.point, phase), branch.gap(motion.point, phase)
        for number in range(frames.distinct):
            fields: dict[str, Array] = {DISPLACEMENT: in_space(moved[number])}
            if "contact_pressure" in self.rows.fields:
                fields[PRESSURE] = self.surface.pressure(forces[number])
            if "gap" in self.rows.fields:
                fields[GAP] = self.surface.gap(gaps[number])
            yield number, fields

    def write_peaks(self, motion: Motion) -> None:
        """Write the peaks of the stress.

        Raises:
            OSError: if they cannot be written.
        """
        rows = slice(motion.first + self.rows.peaks.start, motion.first + self.rows.peaks.stop)
        peaks: dict[str, Array] = dict(
            zip(self.rows.peak_names, self.table.read(rows), strict=True)
        )
        self.body.grid.write(self.folder / f"peak_stress_{motion.name}.vtu", peaks)

    def _listed(self, motions: Sequence[Motion]) -> list[tuple[str, FrameFiles]]:
        """Names of the sequences of frames, and what writes them."""
        bodies = [(motion.of_body, self.body_frames) for motion in motions if self.has_body]
        surfaces = [(motion.of_surface, self.surface_frames) for motion in motions]
        return bodies + (surfaces if self.has_surface else [])


def batches(frames: Frames) -> list[range]:
    """Distinct frames that are computed at once; they do not depend on the number of ranks."""
    size = -(-frames.distinct // -(-frames.distinct // _AT_ONCE))
    starts = range(0, frames.distinct, size)
    return [range(start, min(start + size, frames.distinct)) for start in starts]
