"""Mesh files that are one of several, whose digest says nothing of the others."""

from __future__ import annotations

import re
from pathlib import Path

#: Files that include or merge files, by what stands in them, and those that have a second one.
_NAMES_OTHERS = re.compile(rb"(?i)\b(include|merge|\w*fromfile|systemcall)\b|\binput\s*=")
_MAY_NAME_OTHERS = (".inp", ".bdf", ".dat", ".nas", ".fem", ".geo")
_OF_SEVERAL = (".xdmf", ".xmf")


def names_others(path: Path) -> bool:
    """Whether a mesh file may be one of several."""
    suffix = path.suffix.lower()
    if suffix in _OF_SEVERAL:
        return True
    return suffix in _MAY_NAME_OTHERS and bool(_NAMES_OTHERS.search(path.read_bytes()))
