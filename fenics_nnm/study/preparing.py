"""Raw values of a study: names in lists, paths relative to the working folder."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from pathlib import Path
from typing import Any


def prepared(values: dict[str, Any], folder: Path, listed: Iterable[str]) -> dict[str, Any]:
    """A copy with single names as lists, and with paths relative to the working folder.

    Args:
        values: Values of a study file.
        folder: Folder of that file.
        listed: Names of sections that may come several times.
    """
    values = copy.deepcopy(values)
    for part in _tables(values, ("contact", *listed)) + _picking(values):
        _prepare(part, folder)
        for patch in _tables(part, ("patch",)):
            _prepare(patch, folder)
    for load in _tables(values, ("load",)):
        _prepare_load(load, folder)
    paths = {
        "mesh": ("file", "sections", "hub", "casing"),
        "matrices": _matrix_files(values.get("matrices")),
        "damping": ("file",),
    }
    for section, keys in paths.items():
        table = values.get(section)
        for key in keys:
            if isinstance(table, dict) and isinstance(table.get(key), str):
                table[key] = str(folder / table[key])
    continuation = values.get("continuation")
    start = continuation.get("start") if isinstance(continuation, dict) else None
    if isinstance(start, dict) and isinstance(start.get("file"), str):
        values["continuation"]["start"] = {**start, "file": str(folder / start["file"])}
    return values


def _tables(values: dict[str, Any], names: tuple[str, ...]) -> list[dict[str, Any]]:
    """Sections of some names, of which there may be several each."""
    found = [values.get(name) for name in names]
    flat = [table for each in found for table in (each if isinstance(each, list) else [each])]
    return [table for table in flat if isinstance(table, dict)]


def _prepare(table: dict[str, Any], folder: Path) -> None:
    """Make single names of groups lists, and the path of a casing's table relative."""
    for key in ("against", "cells", "facets", "nodes"):
        if isinstance(table.get(key), str):
            table[key] = [table[key]]
    casing = table.get("casing")
    if isinstance(casing, dict) and isinstance(casing.get("file"), str):
        casing["file"] = str(folder / casing["file"])


def _prepare_load(load: dict[str, Any], folder: Path) -> None:
    """The same of steady loads, with the path of a table of temperatures."""
    for part in _tables(load, ("pressure", "force")):
        _prepare(part, folder)
    for part in _tables(load, ("temperature_field",)):
        if isinstance(part.get("file"), str):
            part["file"] = str(folder / part["file"])


def _picking(values: dict[str, Any]) -> list[dict[str, Any]]:
    """Tables that name groups of facets inside [groups] and mesh.refine."""
    groups, mesh = values.get("groups"), values.get("mesh")
    tables = list(groups.values()) if isinstance(groups, dict) else []
    refine = mesh.get("refine") if isinstance(mesh, dict) else None
    tables += refine if isinstance(refine, list) else []
    return [table for table in tables if isinstance(table, dict)]


def _matrix_files(matrices: Any) -> tuple[str, ...]:
    """Keys of the section of matrices that name files: the others are names in a file."""
    in_one = isinstance(matrices, dict) and "file" in matrices
    if in_one:
        return ("file",)
    further = ("speed_stiffness", "gyroscopic", "quadratic_stiffness", "cubic_stiffness")
    return ("stiffness", "mass", "contact_rows", *further, "quadratic_rows")
