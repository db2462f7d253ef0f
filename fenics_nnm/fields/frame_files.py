"""How the frames of a motion become files: one for each frame, or one for all of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Protocol

from fenics_nnm.arrays import Array
from fenics_nnm.field_names import FileFormat
from fenics_nnm.fields.frames import Frames
from fenics_nnm.fields.vtkhdf import Piece, StepsFile
from fenics_nnm.fields.vtu import GridFile, block, write_collection

VELOCITY = "velocity (m/s)"


Frame = tuple[int, Mapping[str, Array]]
"""A distinct frame: its number, and its fields of shape (nodes,) or (nodes, components)."""


class FrameFiles(Protocol):
    """Writer of the frames of motions on one grid; a motion is a name in a folder.

    Attributes:
        suffix: How the name of the file to open ends.
    """

    suffix: ClassVar[str]

    def begin(self, folder: Path, name: str, frames: Frames) -> None:
        """Prepare a motion, before its frames are put.

        Raises:
            OSError: if it cannot be written.
        """

    def together(self, batches: Sequence[range]) -> list[list[range]]:
        """Batches of frames that must be put by one rank, in their order."""

    def put(self, path: Path, frames: Frames, each: Iterable[Frame]) -> None:
        """Put distinct frames of the motion at `path`, and those that show the same.

        Raises:
            OSError: if they cannot be written.
        """

    def end(self, folder: Path, name: str, frames: Frames) -> None:
        """Complete a motion.

        Raises:
            OSError: if it cannot be written.
        """


@dataclass(frozen=True, slots=True)
class SingleFrames:
    """A folder with a .vtu file for each frame, and a .pvd file that lists them.

    Attributes:
        grid: Grid, as each file has it.
    """

    suffix: ClassVar[str] = ".pvd"

    grid: GridFile

    def begin(self, folder: Path, name: str, frames: Frames) -> None:
        """Make the folder."""
        (folder / name).mkdir()

    def together(self, batches: Sequence[range]) -> list[list[range]]:
        """Each rank may put what it likes."""
        return [[each] for each in batches]

    def put(self, path: Path, frames: Frames, each: Iterable[Frame]) -> None:
        """Write the files."""
        for number, fields in each:
            blocks = {name: block(name, values) for name, values in fields.items()}
            for frame, sign in frames.shown_by(number).items():
                if sign < 0 and VELOCITY in fields:
                    blocks[VELOCITY] = block(VELOCITY, -fields[VELOCITY])
                self.grid.write_blocks(path / _frame(frame), blocks)

    def end(self, folder: Path, name: str, frames: Frames) -> None:
        """Write the .pvd file, which lists the frames with their times."""
        files = [f"{name}/{_frame(number)}" for number in range(frames.count)]
        write_collection(folder / f"{name}{self.suffix}", files, frames.all_times)


@dataclass(frozen=True, slots=True)
class AllFrames:
    """One .vtkhdf file with all frames.

    Attributes:
        file: Grid of the file.
    """

    suffix: ClassVar[str] = ".vtkhdf"

    file: StepsFile

    def begin(self, folder: Path, name: str, frames: Frames) -> None:
        """Make the file."""
        self.file.begin(folder / f"{name}{self.suffix}", frames.all_times)

    def together(self, batches: Sequence[range]) -> list[list[range]]:
        """One rank writes the file."""
        return [list(batches)]

    def put(self, path: Path, frames: Frames, each: Iterable[Frame]) -> None:
        """Add the values, once for all frames that have them."""
        file = path.with_name(f"{path.name}{self.suffix}")
        self.file.put(file, _pieces(frames, each))

    def end(self, folder: Path, name: str, frames: Frames) -> None:
        """The file is complete."""


def frame_files(kind: FileFormat, grid: GridFile) -> FrameFiles:
    """What writes frames on a grid in a format."""
    return AllFrames(StepsFile(grid.grid)) if kind == "vtkhdf" else SingleFrames(grid)


def _pieces(frames: Frames, each: Iterable[Frame]) -> Iterator[Piece]:
    """Values of distinct frames: velocities for each frame that shows them, others once."""
    every, distinct = range(frames.count), frames.distinct_of_each
    for number, fields in each:
        for name, values in fields.items():
            if name == VELOCITY:
                for frame, sign in frames.shown_by(number).items():
                    yield Piece(name, frame, sign * values, every)
            else:
                yield Piece(name, number, values, distinct)


def _frame(number: int) -> str:
    """Name of the file of a frame."""
    return f"frame_{number:04d}.vtu"
