"""Whether a folder may get tables of a command: what is replaced there must be of this program."""

from __future__ import annotations

import csv
import json
import zipfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryFile

from fenics_nnm.errors import StudyError

#: How files of HDF5 begin.
_HDF5 = b"\x89HDF"

Sign = Callable[[Path], bool]
"""Whether a file that is there is of this program."""


@dataclass(frozen=True, slots=True)
class OwnFiles:
    """Files that a command replaces.

    Attributes:
        signs: How each file that shows its writer is known, by its name.
        pictures: Files that show nothing: they are ours if one of the others is there, and ours.
    """

    signs: Mapping[str, Sign]
    pictures: tuple[str, ...] = ()

    def foreign(self, folder: Path) -> list[str]:
        """Names of files in a folder that this program has not written."""
        there = [name for name in self.signs if _is_there(folder / name)]
        others = [name for name in there if not self.signs[name](folder / name)]
        ours = len(there) > len(others)
        pictures = [name for name in self.pictures if _is_there(folder / name)]
        return others if ours else [*others, *pictures]


def assert_writable(folder: Path, files: OwnFiles) -> None:
    """Refuse a folder that cannot be written to, or in which files of somebody else would go.

    The folder is not there afterwards if it was not before.

    Raises:
        StudyError: in both cases.
    """
    try:
        _try(folder)
    except (OSError, ValueError) as error:  # a null character is a ValueError
        reason = getattr(error, "strerror", None) or error
        raise StudyError(f"output folder {folder}: cannot be written: {reason}") from error
    assert_own(folder, files)


def assert_own(folder: Path, files: OwnFiles) -> None:
    """Refuse a folder in which files of somebody else would go.

    Raises:
        StudyError: if there are any.
    """
    if others := files.foreign(folder):
        raise foreign_files(folder, others)


def foreign_files(folder: Path, names: Sequence[str]) -> StudyError:
    """What refuses a folder with files of somebody else."""
    return StudyError(
        f"output folder {folder}: has {', '.join(names)} that no run of this program has "
        "written: must be another folder, or these be moved away"
    )


def _try(folder: Path) -> None:
    """Make a folder and a file in it, and take both away again."""
    made = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            pass
    finally:
        with suppress(OSError):  # one of them was not made, or somebody else uses it by now
            for path in made:
                path.rmdir()


def _is_there(path: Path) -> bool:
    """Whether there is something that can be lost."""
    return path.is_symlink() or path.is_dir() or (path.exists() and path.stat().st_size > 0)


def _has_columns(columns: frozenset[str], path: Path) -> bool:
    """Whether the first line of a table names these columns, among others."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return columns <= set(next(csv.reader(file), []))
    except (OSError, ValueError, csv.Error):
        return False


def _table(*columns: str) -> Sign:
    return partial(_has_columns, frozenset(columns))


def _is_state(path: Path) -> bool:
    """Whether a file is the last state of a simulation."""
    try:
        with zipfile.ZipFile(path) as file:
            return {"q.npy", "velocity.npy", "omega.npy"} <= set(file.namelist())
    except (OSError, ValueError, zipfile.BadZipFile):
        return False


def _is_hdf5(path: Path) -> bool:
    """Whether a file begins as HDF5 does; the names of such files are those of this program."""
    try:
        with path.open("rb") as file:
            return file.read(len(_HDF5)) == _HDF5
    except OSError:
        return False


def _is_journal(path: Path) -> bool:
    """Whether the first line that is not empty is a speed with its motions, or was cut off."""
    try:
        with path.open(encoding="utf-8") as file:
            first = next((line for line in file if line.strip()), "")
        held = json.loads(first) if first.endswith("\n") else {"key": "", "motions": []}
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(held, dict) and {"key", "motions"} <= held.keys()


#: Files of `fenics-nnm convergence`.
CONVERGENCE = OwnFiles(
    {"convergence.csv": _table("varied", "number", "gamma_ratio")}, ("convergence.png",)
)

#: Files of `fenics-nnm simulate`.
SIMULATION = OwnFiles(
    {"simulation.csv": _table("way", "period", "monitor"), "state.npz": _is_state},
    ("simulation.png",),
)

#: Files of `fenics-nnm campbell`.
CAMPBELL = OwnFiles(
    {
        "campbell.csv": _table("speed_rad_s", "rpm", "mode"),
        "crossings.csv": _table("engine_order", "mode", "speed_rad_s"),
        "motions.jsonl": _is_journal,
    },
    ("campbell.png", "campbell.svg"),
)

#: Files of `fenics-nnm response`, besides the fields.
RESPONSE = OwnFiles(
    {
        "response.h5": _is_hdf5,
        "response.csv": _table("branch", "point", "monitor"),
    },
    ("response.png", "resonance.csv"),
)

#: Files of `fenics-nnm sweep`, beside the folders of its studies.
SWEEP = OwnFiles(
    {"sweep.csv": _table("study", "status", "folder", "message")},
    ("sweep.png", "sweep.svg", "sweep_values.png", "sweep_values.svg"),
)
