"""Where results are, and how large."""

from __future__ import annotations

from pathlib import Path

from fenics_nnm.files.sizes import size_of_files, size_of_folder, size_words

#: Folders of results in a folder of results; what is in others is of somebody else.
_FOLDERS = ("fields", "pictures")


def place_line(folder: Path) -> str:
    """Where results are, and how large."""
    size = size_of_files(folder) + sum(size_of_folder(folder / name) for name in _FOLDERS)
    return f"results in {folder} ({size_words(size)})"
