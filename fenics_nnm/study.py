"""The study file as typed records: the only place that knows TOML."""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path
from typing import Any, Self

from pydantic import BaseModel, ValidationError, model_validator

from fenics_nnm.errors import StudyError
from fenics_nnm.geometry import Beam, Blade, Geometry, Plate, Rod
from fenics_nnm.resolution.resolution import Resolution
from fenics_nnm.study_continuation import ContinuationSection
from fenics_nnm.study_messages import first_error, plain, shown
from fenics_nnm.study_sections import (
    AugmentedLagrangianSection,
    BodySection,
    ClampSection,
    ContactSection,
    LawSection,
    MaterialSection,
    MatrixArchive,
    MatrixContactSection,
    MatrixFiles,
    MeshFile,
    ModeSection,
    OutputSection,
    Record,
    ReductionSection,
)

#: Relative error of the frequency that "auto" meets if none is given.
DEFAULT_TOLERANCE = 1e-3


class _AnyStudy(Record):
    title: str = ""
    contact: LawSection
    reduction: ReductionSection = ReductionSection()
    augmented_lagrangian: AugmentedLagrangianSection | None = None
    mode: ModeSection = ModeSection()
    continuation: ContinuationSection = ContinuationSection()
    output: OutputSection = OutputSection()

    @property
    def full_order(self) -> bool:
        """Whether the whole model is used at every harmonic, without reduction."""
        return self.reduction.method == "none"

    @property
    def carries_mass(self) -> bool:
        """Whether contact points carry mass, so that contact needs the augmented Lagrangian."""
        chosen = self.full_order and self.contact.law == "augmented-lagrangian"
        return chosen or self.reduction.method == "craig-bampton"

    @property
    def automatic(self) -> tuple[str, ...]:
        """Names of the numbers that are to be found: harmonics, samples, modes."""
        given = {
            "harmonics": self.mode.harmonics,
            "samples": self.mode.samples,
            "modes": self.reduction.modes,
        }
        return tuple(name for name, value in given.items() if value == "auto")

    @property
    def tolerance(self) -> float:
        """Relative error of the frequency that numbers found must meet."""
        return self.mode.tolerance or DEFAULT_TOLERANCE

    @property
    def resolution(self) -> Resolution:
        """Harmonics, samples and modes.

        Raises:
            StudyError: if one of them is "auto" and not found yet.
        """
        numbers = self.mode.harmonics, self.mode.samples, self.reduction.modes
        if "auto" in numbers:
            raise StudyError(
                f'{self.automatic[0]} = "auto": is not found yet: '
                "see fenics_nnm.resolution.auto.choice"
            )
        return Resolution(*(int(number) for number in numbers))

    def with_resolution(self, found: Resolution) -> Self:
        """The same study with all numbers given."""
        mode = {"harmonics": found.harmonics, "samples": found.samples}
        return self.model_copy(
            update={
                "mode": self.mode.model_copy(update=mode),
                "reduction": self.reduction.model_copy(update={"modes": found.modes}),
            }
        )

    @model_validator(mode="after")
    def _tolerance_has_effect(self) -> _AnyStudy:
        if self.mode.tolerance is not None and not self.automatic:
            raise ValueError(
                f"mode.tolerance = {self.mode.tolerance:g}: has no effect: needs mode.harmonics, "
                'mode.samples or reduction.modes = "auto"'
            )
        return self

    @model_validator(mode="after")
    def _numbers_can_be_found(self) -> _AnyStudy:
        if self.automatic and (self.mode.harmonic > 1 or self.continuation.start):
            key = "mode.harmonic" if self.mode.harmonic > 1 else "continuation.start"
            raise ValueError(
                f'{key}: does not go with {self.automatic[0]} = "auto", which is found for the '
                "branch that begins at the linear mode: give numbers"
            )
        return self

    @model_validator(mode="after")
    def _law_fits_reduction(self) -> _AnyStudy:
        if self.carries_mass and self.contact.law == "complementarity":
            raise ValueError(
                'contact.law = "complementarity": does not fit reduction.method = "craig-bampton", '
                'whose contact points carry mass: must be "augmented-lagrangian"'
            )
        if not self.carries_mass and self.contact.law == "augmented-lagrangian":
            raise ValueError(
                'contact.law = "augmented-lagrangian": needs contact points that carry mass: '
                'reduction.method = "craig-bampton" or "none"'
            )
        if not self.carries_mass and self.augmented_lagrangian:
            raise ValueError(
                'augmented_lagrangian: needs contact.law = "augmented-lagrangian", for contact '
                'points that carry mass: reduction.method = "craig-bampton" or "none"'
            )
        return self

    @model_validator(mode="after")
    def _normalisation_fits_reduction(self) -> _AnyStudy:
        chosen = self.augmented_lagrangian
        if self.full_order and chosen and chosen.normalisation == "penalised":
            raise ValueError(
                'augmented_lagrangian.normalisation = "penalised": is the form of reduced models: '
                'with reduction.method = "none" must be "exact"'
            )
        return self

    @model_validator(mode="after")
    def _parameter_fits_contact(self) -> _AnyStudy:
        chosen = self.continuation
        if self.carries_mass and (chosen.parameter != "energy" or chosen.by_arc):
            raise ValueError(
                f"continuation: by {'arc-length' if chosen.by_arc else 'frequency'} needs contact "
                'points without mass: with contact.law = "augmented-lagrangian" must have '
                'parameter = "energy" and internal_resonance = "skip"'
            )
        return self

    @model_validator(mode="after")
    def _harmonic_fits_continuation(self) -> _AnyStudy:
        number, chosen = self.mode.harmonic, self.continuation
        if number == 1:
            return self
        if self.mode.harmonics != "auto" and number > self.mode.harmonics:
            raise ValueError(
                f"mode.harmonic = {number}: must not be above mode.harmonics = "
                f"{self.mode.harmonics}"
            )
        if not chosen.by_arc:
            raise ValueError(
                f'mode.harmonic = {number}: needs continuation.parameter = "arc-length" or '
                'internal_resonance = "follow"'
            )
        if chosen.start is None and chosen.energies.start >= 1:
            raise ValueError(
                f"continuation.energies.from = {chosen.energies.start:g}: must be below 1 with "
                f"mode.harmonic = {number}: such a branch begins without contact"
            )
        return self

    @model_validator(mode="after")
    def _mode_is_kept(self) -> _AnyStudy:
        if self.reduction.modes != "auto" and self.mode.number > self.reduction.modes:
            raise ValueError(
                f"mode.number = {self.mode.number}: must not be above "
                f"reduction.modes = {self.reduction.modes}"
            )
        return self


class MeshStudy(_AnyStudy):
    """All that a run of a mesh needs to know; lengths in m unless a key says otherwise."""

    mesh: MeshFile | Geometry
    body: BodySection
    material: MaterialSection
    clamp: ClampSection | None = None
    contact: ContactSection


class MatrixStudy(_AnyStudy):
    """All that a run of matrices of another code needs to know; SI units."""

    matrices: MatrixArchive | MatrixFiles
    contact: MatrixContactSection

    @model_validator(mode="before")
    @classmethod
    def _nothing_of_a_mesh(cls, values: Any) -> Any:
        for key in ("mesh", "body", "material", "clamp"):
            if key in values:
                raise ValueError(
                    f"{key}: does not go with [matrices], which hold the whole structure, "
                    "held by its clamp"
                )
        if isinstance(values.get("output"), dict) and "frames" in values["output"]:
            raise ValueError("output.frames: belongs to [mesh]: matrices have no ParaView files")
        return values

    @model_validator(mode="after")
    def _reduction_fits_matrices(self) -> MatrixStudy:
        if self.full_order:
            raise ValueError(
                'reduction.method = "none": full order factorises the matrices of a mesh at every '
                'harmonic: with [matrices] must be "massless" or "craig-bampton"'
            )
        if self.reduction.interface == "all":
            raise ValueError(
                'reduction.interface = "all": needs the directions of a mesh: [matrices] have the '
                'contact directions alone, "contact"'
            )
        return self


Study = MeshStudy | MatrixStudy
"""All that a run needs to know."""


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
    models: dict[str, type[BaseModel]] = {"rod": Rod, "beam": Beam, "plate": Plate, "blade": Blade}
    model = mesh.get("model")
    if not isinstance(model, str) or model not in models:
        known = ", ".join(f'"{name}"' for name in models)
        given = f"mesh.model = {shown(model)}:" if "model" in mesh else "mesh.model: is missing,"
        raise StudyError(
            f"{path}: {given} must be one of {known}, or mesh.file the name of a .msh file"
        )
    return "mesh", models[model]


def _prepared(values: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Single names as lists, and paths made relative to the working folder."""
    values = {key: dict(item) if isinstance(item, dict) else item for key, item in values.items()}
    for section in ("clamp", "contact"):
        table = values.get(section)
        if isinstance(table, dict) and isinstance(table.get("facets"), str):
            table["facets"] = [table["facets"]]
    paths = {"mesh": ("file", "sections"), "matrices": _matrix_files(values.get("matrices"))}
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
