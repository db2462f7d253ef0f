"""Which kind of results a folder has."""

from __future__ import annotations

from pathlib import Path

import h5py

from fenics_nnm.results.response_file import NAME

#: Beginning of the format of all versions of response.h5.
_RESPONSE = "fenics_nnm response"


def is_response(path: Path) -> bool:
    """Whether a folder of results, or one file of them, is of a response, not of a branch."""
    if path.is_dir():
        return (path / NAME).exists() and not (path / "branch.h5").exists()
    try:
        with h5py.File(path, "r") as file:
            return str(file.attrs.get("format", "")).startswith(_RESPONSE)
    except (OSError, RuntimeError, KeyError, ValueError):
        return False
