"""From a TOML file to a study: the only place that knows TOML."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from fenics_nnm.errors import StudyError
from fenics_nnm.geometry import Beam, Blade, Fork, Plate, Rod, Shroud
from fenics_nnm.geometry.lengths import KNOWN, METRES, Units
from fenics_nnm.study.attachments import MassSection, MatrixSpringSection, SpringSection
from fenics_nnm.study.body import ClampSection
from fenics_nnm.study.contact import ContactSection, PatchesSection
from fenics_nnm.study.damping import (
    DampingSection,
    DashpotSection,
    MatrixDashpotSection,
    damping_record,
)
from fenics_nnm.study.driven import (
    ExcitationSection,
    MatrixExcitationSection,
    MatrixMonitorSection,
    MonitorSection,
)
from fenics_nnm.study.groups import GroupSection
from fenics_nnm.study.material import material_record
from fenics_nnm.study.matrices import MatrixArchive, MatrixFiles
from fenics_nnm.study.mesh import CAD_ENDINGS, CadFile, MeshFile
from fenics_nnm.study.messages import first_error, plain, shown
from fenics_nnm.study.preparing import prepared
from fenics_nnm.study.rigid import RigidSection
from fenics_nnm.study.study import MatrixStudy, MeshStudy, Study

#: Record of each section that may come several times, by its values.
_LISTED: dict[str, Callable[[dict[str, Any]], type[BaseModel]]] = {
    "clamp": lambda values: ClampSection,
    "material": material_record,
    "mass": lambda values: MassSection,
    "spring": lambda values: SpringSection,
    "rigid": lambda values: RigidSection,
    "dashpot": lambda values: DashpotSection,
    "excitation": lambda values: ExcitationSection,
    "monitor": lambda values: MonitorSection,
}

#: The same with matrices of another code.
_LISTED_WITH_MATRICES: dict[str, Callable[[dict[str, Any]], type[BaseModel]]] = {
    "spring": lambda values: MatrixSpringSection,
    "dashpot": lambda values: MatrixDashpotSection,
    "excitation": lambda values: MatrixExcitationSection,
    "monitor": lambda values: MatrixMonitorSection,
}

#: Records of the built-in geometries by their name.
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
    return study_from(read_values(path), path)


def read_values(path: Path) -> dict[str, Any]:
    """Read the values of a study file, which are not checked yet.

    Raises:
        StudyError: if it cannot be read or is not TOML.
    """
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise StudyError(f"{path}: cannot be read: {plain(error)}") from error
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise StudyError(f"{path}: is not TOML: {error}") from error
    except RecursionError as error:
        raise StudyError(f"{path}: is not a study: its lists or sections lie too deep") from error


def study_from(values: dict[str, Any], path: Path) -> Study:
    """Make a study of the values of a study file at `path`.

    Raises:
        StudyError: with one line that names the key, its value and what would be right.
    """
    values = _with_unit_of_mesh(prepared(values, path.parent, _LISTED))
    kind = _kind(values, path)
    check = _Check(path, _units(values, path))
    parts = [
        _matrices_record(values, path) or _mesh_record(values, path),
        _contact_record(values, path) if kind is MeshStudy else None,
        _damping_record(values),
    ]
    try:
        for name, record in filter(None, parts):
            values = {**values, name: check(record, values[name], (name,))}
        if kind is MeshStudy:
            values = {**values, **_listed(values, _LISTED, check), **_groups(values, check)}
        else:
            values = {**values, **_listed(values, _LISTED_WITH_MATRICES, check)}
        found: Study = check(kind, values, ())
        return found
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


@dataclass(frozen=True, slots=True)
class _Check:
    """Makes records of values of a study file.

    Attributes:
        path: The study file, for messages.
        units: Units of lengths without one.
    """

    path: Path
    units: Units

    def __call__(self, record: type[BaseModel], values: Any, place: tuple[str, ...]) -> Any:
        """The record of the values at a place of the study file.

        Raises:
            StudyError: if a value is wrong.
        """
        try:
            return record.model_validate(values, context=self.units)
        except ValidationError as error:
            line = first_error(error, record, values, place, self.units.study)
            raise StudyError(f"{self.path}: {line}") from error


def _with_unit_of_mesh(values: dict[str, Any]) -> dict[str, Any]:
    """The values with the length unit of the study in [mesh], where that has none."""
    mesh = values.get("mesh")
    if "length_unit" not in values or not isinstance(mesh, dict):
        return values
    return {**values, "mesh": {"length_unit": values["length_unit"], **mesh}}


def _units(values: dict[str, Any], path: Path) -> Units:
    """Units of lengths without one.

    Raises:
        StudyError: if that of the study is unknown; that of its mesh is checked with the mesh.
    """
    unit, mesh = values.get("length_unit", "m"), values.get("mesh")
    if not _is_unit(unit):
        raise StudyError(f"{path}: length_unit = {shown(unit)}: must be {KNOWN}")
    given: Any = mesh.get("length_unit") if isinstance(mesh, dict) else None
    return Units(unit, given if _is_unit(given) else unit)


def _is_unit(value: Any) -> bool:
    return isinstance(value, str) and value in METRES


def _groups(values: dict[str, Any], check: _Check) -> dict[str, Any]:
    """Picked groups, checked one by one, as their names may be any."""
    if "groups" not in values:
        return {}
    groups = values["groups"]
    if not isinstance(groups, dict):
        raise StudyError(f"{check.path}: groups = {shown(groups)}: must be a section with keys")
    for name, group in groups.items():
        if not isinstance(group, dict):
            raise StudyError(
                f"{check.path}: groups.{name} = {shown(group)}: must be a section with conditions"
            )
    return {
        "groups": {
            name: check(GroupSection, group, ("groups", name)) for name, group in groups.items()
        }
    }


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
        cad = isinstance(mesh["file"], str) and Path(mesh["file"]).suffix.lower() in CAD_ENDINGS
        return "mesh", CadFile if cad else MeshFile
    model = mesh.get("model")
    if not isinstance(model, str) or model not in _MODELS:
        known = ", ".join(f'"{name}"' for name in _MODELS)
        given = f"mesh.model = {shown(model)}:" if "model" in mesh else "mesh.model: is missing,"
        raise StudyError(
            f"{path}: {given} must be one of {known}, or mesh.file the name of a mesh or CAD file"
        )
    return "mesh", _MODELS[model]


def _listed(
    values: dict[str, Any],
    listed: Mapping[str, Callable[[dict[str, Any]], type[BaseModel]]],
    check: _Check,
) -> dict[str, Any]:
    """Sections that may come several times, each checked as the record that it is meant for."""
    checked = {}
    for name, record in listed.items():
        given = values.get(name, [])
        if given == []:
            continue
        sections = [given] if isinstance(given, dict) else given
        if not isinstance(sections, list) or not all(isinstance(s, dict) for s in sections):
            raise StudyError(f"{check.path}: {name} = {shown(given)}: must be a section with keys")
        checked[name] = tuple(
            check(record(section), section, (_numbered(name, number, given),))
            for number, section in enumerate(sections, start=1)
        )
    return checked


def _numbered(name: str, number: int, given: Any) -> str:
    """Name of one of several sections, counted from 1."""
    return name if isinstance(given, dict) else f"{name}[{number}]"


def _damping_record(values: dict[str, Any]) -> tuple[str, type[DampingSection]] | None:
    """Record that the section about damping is meant for."""
    damping = values.get("damping")
    return ("damping", damping_record(damping)) if isinstance(damping, dict) else None


def _contact_record(
    values: dict[str, Any], path: Path
) -> tuple[str, type[ContactSection | PatchesSection]] | None:
    """Record that the contact section of a mesh is meant for: one patch, or several."""
    contact = values.get("contact")
    if isinstance(contact, list):
        raise StudyError(
            f"{path}: contact: is a list of sections: several patches must be written "
            "[[contact.patch]]"
        )
    if not isinstance(contact, dict):
        return None
    return "contact", PatchesSection if "patch" in contact else ContactSection
