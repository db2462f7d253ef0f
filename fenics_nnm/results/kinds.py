"""Which kind of results a folder has."""

from __future__ import annotations

from pathlib import Path

import h5py

from fenics_nnm.results.response_file import NAME

#: Beginning of the format of all versions of response.h5.
_RESPONSE = "fenics_nnm response"


#: Files of results that stand for their folder.
_FILES = ("branch.h5", NAME)


def folder_of(path: Path) -> Path:
    """The results folder of a path: itself, or that of the branch.h5 or response.h5 that it is.

    A folder with both files is one of a run; its response.h5 is named for the response.
    """
    return path.parent if path.name in _FILES and path.is_file() else path


def is_response(path: Path) -> bool:
    """Whether a folder of results, or one file of them, is of a response, not of a branch."""
    if path.is_dir():
        return (path / NAME).exists() and not (path / "branch.h5").exists()
    try:
        with h5py.File(path, "r") as file:
            return str(file.attrs.get("format", "")).startswith(_RESPONSE)
    except (OSError, RuntimeError, KeyError, ValueError):
        return False
