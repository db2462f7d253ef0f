"""Whether a folder may get results: what is replaced there must be of this program."""

from __future__ import annotations

import json
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path

import h5py

from fenics_nnm.errors import StudyError
from fenics_nnm.results.own_files import foreign_files
from fenics_nnm.results.staging import RESULTS

#: Beginning of the format of all versions of branch.h5.
_FORMAT = "fenics_nnm branch"


def assert_replaceable(folder: Path, inputs: Iterable[Path]) -> None:
    """Refuse a folder in which files of somebody else would be replaced.

    Args:
        folder: Folder for results, which may not be there yet.
        inputs: The study, and files that it names.

    Raises:
        StudyError: if an input lies in it, or files with names of results that no run has written.
    """
    place = folder.resolve()
    for path in inputs:
        held = path.resolve()
        if held.parent == place or any(held.is_relative_to(place / name) for name in RESULTS):
            raise StudyError(
                f"output folder {folder}: holds {path.name}, which the study is read from: must be "
                "a folder of its own, such as results/NAME"
            )
    there = [name for name in RESULTS if _exists(folder / name)]
    if there and not (_is_branch(folder / "branch.h5") or _is_summary(folder / "summary.json")):
        raise foreign_files(folder, there)


def older_results(folder: Path) -> str:
    """The results in a folder that a run replaces, in words; empty if there are none."""
    there = [name for name in RESULTS if _exists(folder / name)]
    if not there:
        return ""
    newest = max((folder / name).stat().st_mtime for name in there)
    when = datetime.fromtimestamp(newest).strftime("%Y-%m-%d %H:%M")
    return f"{_run_in_words(folder / 'summary.json')} of {when} in {folder}: {', '.join(there)}"


def _run_in_words(path: Path) -> str:
    """What is known of a run by its summary."""
    if not _is_summary(path):
        return "the results"
    held = json.loads(path.read_bytes())
    return f'"{held.get("title") or "no title"}", {held.get("points", 0)} points,'


def _exists(path: Path) -> bool:
    """Whether there is a file; a name that no file can have is refused where it is made."""
    try:
        return path.exists()
    except OSError:
        return False


def _is_branch(path: Path) -> bool:
    try:
        with h5py.File(path, "r") as file:
            return str(file.attrs.get("format", "")).startswith(_FORMAT)
    except (OSError, RuntimeError, KeyError, ValueError):
        return False


def _is_summary(path: Path) -> bool:
    try:
        held = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(held, dict) and "fenics_nnm" in held.get("versions", {})
