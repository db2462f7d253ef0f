"""From a TOML file to a study: the only place that knows TOML."""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from fenics_nnm.errors import StudyError
from fenics_nnm.geometry import Beam, Blade, Fork, Plate, Rod, Shroud
from fenics_nnm.study.body import MeshFile
from fenics_nnm.study.matrices import MatrixArchive, MatrixFiles
from fenics_nnm.study.messages import first_error, plain, shown
from fenics_nnm.study.study import MatrixStudy, MeshStudy, Study

_MODELS: dict[str, type[BaseModel]] = {
    str(record.model_fields["model"].default): record
    for record in (Rod, Beam, Plate, Fork, Shroud, Blade)
}


def read_study(path: Path) -> Study:
    """Read and check a study file.

    Paths in it are taken relative to its folder, but for `output.folder`.

    Raises:
        StudyError: with one line that names the key, its value and what would be right.
    """
    try:
        text = path.read_bytes().decode()
    except (OSError, UnicodeDecodeError) as error:
        raise StudyError(f"{path}: cannot be read: {plain(error)}") from error
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise StudyError(f"{path}: is not TOML: {error}") from error
    return study_from(values, path)


def study_from(values: dict[str, Any], path: Path) -> Study:
    """Make a study of the values of a study file at `path`.

    Raises:
        StudyError: with one line that names the key, its value and what would be right.
    """
    values = _prepared(values, path.parent)
    kind = _kind(values, path)
    part = _matrices_record(values, path) or _mesh_record(values, path)
    try:
        if part is not None:
            name, record = part
            values = {**values, name: _checked(record, values[name], (name,), path)}
        return _checked(kind, values, (), path)
    except ValidationError as error:
        raise StudyError(f"{path}: {error}") from error


def _kind(values: dict[str, Any], path: Path) -> type[Study]:
    """Whether a study is one of a mesh or of matrices."""
    known = {*MeshStudy.model_fields, *MatrixStudy.model_fields}
    if not {"mesh", "matrices"} & values.keys() and values.keys() <= known:
        raise StudyError(f"{path}: mesh: is missing, or [matrices] of another code in its place")
    misprints = difflib.get_close_matches("matrices", values.keys() - known)
    if "matrices" in values or (misprints and "mesh" not in values):
        return MatrixStudy
    return MeshStudy


def _checked(record: type[BaseModel], values: Any, place: tuple[str, ...], path: Path) -> Any:
    try:
        return record.model_validate(values)
    except ValidationError as error:
        raise StudyError(f"{path}: {first_error(error, record, values, place)}") from error


def _matrices_record(
    values: dict[str, Any], path: Path
) -> tuple[str, type[MatrixArchive | MatrixFiles]] | None:
    """Record that the section of matrices is meant for: all in one file, or three files."""
    matrices = values.get("matrices")
    if matrices is None or "mesh" in values:
        return None
    if not isinstance(matrices, dict):
        raise StudyError(f"{path}: matrices = {shown(matrices)}: must be a section with keys")
    return "matrices", MatrixArchive if "file" in matrices else MatrixFiles


def _mesh_record(values: dict[str, Any], path: Path) -> tuple[str, type[BaseModel]] | None:
    """Record that the mesh section is meant for, so that messages speak of that one alone."""
    mesh = values.get("mesh")
    if mesh is None or "matrices" in values:
        return None
    if not isinstance(mesh, dict):
        raise StudyError(f"{path}: mesh = {shown(mesh)}: must be a section with keys")
    if "file" in mesh:
        return "mesh", MeshFile
    model = mesh.get("model")
    if not isinstance(model, str) or model not in _MODELS:
        known = ", ".join(f'"{name}"' for name in _MODELS)
        given = f"mesh.model = {shown(model)}:" if "model" in mesh else "mesh.model: is missing,"
        raise StudyError(
            f"{path}: {given} must be one of {known}, or mesh.file the name of a .msh file"
        )
    return "mesh", _MODELS[model]


def _prepared(values: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Single names as lists, and paths made relative to the working folder."""
    values = {key: dict(item) if isinstance(item, dict) else item for key, item in values.items()}
    for section in ("clamp", "contact"):
        table = values.get(section)
        if isinstance(table, dict) and isinstance(table.get("facets"), str):
            table["facets"] = [table["facets"]]
    paths = {
        "mesh": ("file", "sections", "hub", "casing"),
        "matrices": _matrix_files(values.get("matrices")),
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


def _matrix_files(matrices: Any) -> tuple[str, ...]:
    """Keys of the section of matrices that name files: the others are names in a file."""
    in_one = isinstance(matrices, dict) and "file" in matrices
    return ("file",) if in_one else ("stiffness", "mass", "contact_rows")
