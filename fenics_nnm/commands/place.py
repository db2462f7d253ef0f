"""Where results are, and how large."""

from __future__ import annotations

from pathlib import Path

from fenics_nnm.files.sizes import size_of_folder, size_words


def place_line(folder: Path) -> str:
    """Where results are, and how large."""
    return f"results in {folder} ({size_words(size_of_folder(folder))})"
