"""The study file as typed records: the only place that knows TOML."""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from fenics_nnm.errors import StudyError
from fenics_nnm.geometry import Beam, Blade, Geometry, Plate, Rod
from fenics_nnm.geometry.parameters import LengthUnit

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Count = Annotated[int, Field(gt=0)]
FromList = BeforeValidator(lambda value: tuple(value) if isinstance(value, list) else value)
Vector = Annotated[
    tuple[Annotated[float, Field(allow_inf_nan=False)], ...],
    Field(min_length=1, max_length=3),
    FromList,
]
Names = Annotated[tuple[str, ...], Field(min_length=1), FromList]

#: Most energies of a study; more are a misprint of the step.
_MOST_STEPS = 100_000

#: Characters of a value that a message shows.
_LONGEST = 80

#: What pydantic says of programs, said of study files.
_WORDS = {
    "int_type": "must be an integer",
    "missing": "has too few items",
    "model_attributes_type": "must be a section with keys",
    "model_type": "must be a section with keys",
    "path_type": "must be a name in quotes",
    "too_long": "has too many items",
    "too_short": "has too few items",
    "tuple_type": "must be a list",
}

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class MeshFile(_Record):
    """A mesh made elsewhere, with named physical groups."""

    file: Annotated[Path, Field(strict=False, description="a .msh file, relative to the study")]
    length_unit: LengthUnit = Field(description="the unit of the file's coordinates")


class BodySection(_Record):
    """Theory of the body, and what a mesh of lower dimension lacks."""

    theory: Literal["rod", "plane-stress", "plane-strain", "solid"] = Field(
        description="rod in 1-D, plane-stress or plane-strain in 2-D, solid in 3-D"
    )
    area: Positive | None = Field(None, description="cross-section of a rod in m^2")
    thickness: Positive | None = Field(None, description="thickness of a plane body in m")
    degree: Literal[1, 2] = Field(2, description="polynomial degree of the displacement")

    @model_validator(mode="after")
    def _extent_fits_theory(self) -> BodySection:
        wanted = {"rod": "area", "plane-stress": "thickness", "plane-strain": "thickness"}
        needed = wanted.get(self.theory)
        for key in ("area", "thickness"):
            given = getattr(self, key) is not None
            if given != (key == needed):
                verb = "needs" if key == needed else "has no"
                raise ValueError(f'theory = "{self.theory}" {verb} {key}')
        return self

    @property
    def extent(self) -> float:
        """Area of a rod in m^2, thickness of a plane body in m, 1 for a solid."""
        return self.area or self.thickness or 1.0


class MaterialSection(_Record):
    """Homogeneous isotropic linear elasticity."""

    young: Positive = Field(description="Young's modulus in Pa")
    poisson: float = Field(0.0, gt=-1, lt=0.5, description="Poisson's ratio, above -1, below 0.5")
    density: Positive = Field(description="mass density in kg/m^3")


class ClampSection(_Record):
    """Facets without displacement."""

    facets: Names = Field(description="name of a group of facets, or a list of names")


class ContactSection(_Record):
    """Facets that can meet a rigid obstacle."""

    facets: Names = Field(description="name of a group of facets, or a list of names")
    direction: Literal["normal", "radial"] | Vector = Field(
        "normal",
        description='towards the obstacle: "normal", "radial", or a vector of finite numbers',
    )
    axis: Literal["x", "y", "z"] | Vector | None = Field(
        None, description='axis of a radial direction: "x", "y", "z" or a vector of finite numbers'
    )
    origin: Vector | None = Field(None, description="a point on the axis in m; the default is 0")
    gap: Positive = Field(description="initial gap in m, positive")
    law: Literal["complementarity", "augmented-lagrangian"] | None = Field(
        None, description="by default the one that fits reduction.method"
    )
    points: Count | Literal["all"] = Field(
        "all", description='positive number of points spread over the facets, or "all" vertices'
    )

    @model_validator(mode="after")
    def _axis_fits_direction(self) -> ContactSection:
        radial = self.direction == "radial"
        if radial and self.axis is None:
            raise ValueError('direction = "radial" needs axis = "x", "y", "z" or a vector')
        if not radial and (self.axis is not None or self.origin is not None):
            raise ValueError('axis and origin belong to direction = "radial"')
        for name in ("direction", "axis"):
            vector = getattr(self, name)
            if isinstance(vector, tuple) and not any(vector):
                raise ValueError(f"{name} = {list(vector)}: must not be zero")
        return self

    @property
    def axis_vector(self) -> tuple[float, ...]:
        """The axis as a vector, empty without one."""
        return _AXES[self.axis] if isinstance(self.axis, str) else self.axis or ()


class ReductionSection(_Record):
    """From the mesh to a few coordinates."""

    method: Literal["massless", "craig-bampton"] = Field(
        "massless", description='"massless" (free modes, residual flexibility) or "craig-bampton"'
    )
    modes: Count = Field(40, description="number of free modes, or of fixed-interface modes")
    interface: Literal["all", "contact"] | None = Field(
        None, description='retained directions of craig-bampton: "all" (default) or "contact"'
    )

    @model_validator(mode="after")
    def _interface_fits_method(self) -> ReductionSection:
        if self.method == "massless" and self.interface is not None:
            raise ValueError('interface belongs to method = "craig-bampton"')
        return self


class AugmentedLagrangianSection(_Record):
    """Multipliers of contact points that carry mass."""

    penalty: Positive = Field(10.0, description="first penalty over the static contact stiffness")
    alpha: Annotated[float, Field(gt=1, allow_inf_nan=False)] = Field(
        4.0, description="factor by which a measure must fall, above 1"
    )
    beta: Annotated[float, Field(gt=1, allow_inf_nan=False)] = Field(
        10.0, description="growth of a penalty, above 1"
    )
    tolerance: Positive = Field(1e-10, description="penetration and tension over the gap")
    iterations: Count = Field(60, description="largest number of outer steps")
    normalisation: Literal["exact", "penalised"] = Field(
        "exact", description='"exact": h = 0 is a row; "penalised": the literal form of the paper'
    )
    algorithm: Literal["simultaneous", "sequential"] = Field(
        "simultaneous", description="base of the penalised form: Algorithm 1 or 2 of the paper"
    )

    @model_validator(mode="after")
    def _algorithm_has_effect(self) -> AugmentedLagrangianSection:
        if self.normalisation == "exact" and "algorithm" in self.model_fields_set:
            raise ValueError('algorithm belongs to normalisation = "penalised"')
        return self


class ModeSection(_Record):
    """Which nonlinear mode, and its series in time."""

    number: Count = Field(1, description="number of the linear mode, from 1")
    harmonics: Count = Field(10, description="number of harmonics, N")
    samples: Count = Field(128, description="time samples of a period, at least 2 N + 1")
    series: Literal["time-reversible", "general"] = Field(
        "time-reversible", description='"time-reversible": cosines; "general": sines too'
    )

    @model_validator(mode="after")
    def _samples_resolve_harmonics(self) -> ModeSection:
        least = 2 * self.harmonics + 1
        if self.samples < least:
            raise ValueError(
                f"samples = {self.samples} with harmonics = {self.harmonics}: "
                f"must be at least 2 harmonics + 1 = {least}"
            )
        return self


class Energies(_Record):
    """Range of energies, as ratios of gamma to its value at grazing."""

    start: Positive = Field(0.7, alias="from", description="first gamma ratio")
    stop: Positive = Field(3.0, alias="to", description="last gamma ratio")
    step: Positive = Field(0.1, description="largest step of the gamma ratio")

    @model_validator(mode="after")
    def _ascending(self) -> Energies:
        if self.start >= self.stop:
            raise ValueError(f"from = {self.start:g}, to = {self.stop:g}: from must be below to")
        if self.stop - self.start > _MOST_STEPS * self.step:
            raise ValueError(f"step = {self.step:g}: must give at most {_MOST_STEPS} steps")
        return self


class ContinuationSection(_Record):
    """Which energies to visit."""

    energies: Energies = Field(Energies(), description="range { from, to, step } of gamma ratios")
    report_at: Annotated[tuple[Positive, ...], FromList] = Field(
        (), description="gamma ratios that get a point and ParaView files"
    )

    @model_validator(mode="after")
    def _inside_range(self) -> ContinuationSection:
        for ratio in self.report_at:
            if not self.energies.start <= ratio <= self.energies.stop:
                raise ValueError(
                    f"report_at = {ratio:g}: must lie between energies.from = "
                    f"{self.energies.start:g} and energies.to = {self.energies.stop:g}"
                )
        if len({f"{ratio:g}" for ratio in self.report_at}) < len(self.report_at):
            raise ValueError(
                f"report_at = {list(self.report_at)}: must differ, and in the first six digits"
            )
        return self


class OutputSection(_Record):
    """Where results go."""

    folder: Annotated[Path, Field(strict=False)] | None = Field(
        None, description="folder of the results; the default is results/ and the study's name"
    )
    frames: Annotated[int, Field(ge=24)] = Field(
        24, description="frames of a period in the ParaView files, at least 24"
    )


class Study(_Record):
    """All that a run needs to know; lengths in m unless a key says otherwise."""

    title: str = ""
    mesh: MeshFile | Geometry
    body: BodySection
    material: MaterialSection
    clamp: ClampSection | None = None
    contact: ContactSection
    reduction: ReductionSection = ReductionSection()
    augmented_lagrangian: AugmentedLagrangianSection | None = None
    mode: ModeSection = ModeSection()
    continuation: ContinuationSection = ContinuationSection()
    output: OutputSection = OutputSection()

    @model_validator(mode="after")
    def _law_fits_reduction(self) -> Study:
        carries_mass = self.reduction.method == "craig-bampton"
        law = self.contact.law
        if carries_mass and law == "complementarity":
            raise ValueError(
                'contact.law = "complementarity": does not fit reduction.method = "craig-bampton", '
                'whose contact points carry mass: must be "augmented-lagrangian"'
            )
        if not carries_mass and (law == "augmented-lagrangian" or self.augmented_lagrangian):
            raise ValueError(
                'contact.law = "augmented-lagrangian": needs contact points that carry mass: '
                'reduction.method = "craig-bampton"'
            )
        return self

    @model_validator(mode="after")
    def _mode_is_kept(self) -> Study:
        if self.mode.number > self.reduction.modes:
            raise ValueError(
                f"mode.number = {self.mode.number}: must not be above "
                f"reduction.modes = {self.reduction.modes}"
            )
        return self


def read_study(path: Path) -> Study:
    """Read and check a study file.

    Paths in it are taken relative to its folder, but for `output.folder`.

    Raises:
        StudyError: with one line that names the key, its value and what would be right.
    """
    try:
        text = path.read_bytes().decode()
    except (OSError, UnicodeDecodeError) as error:
        raise StudyError(f"{path}: cannot be read: {_plain(error)}") from error
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
    section = _mesh_record(values, path)
    try:
        if section is not None:
            mesh = _checked(section, values["mesh"], ("mesh",), path)
            values = {**values, "mesh": mesh}
        return _checked(Study, values, (), path)
    except ValidationError as error:
        raise StudyError(f"{path}: {error}") from error


def _checked(record: type[BaseModel], values: Any, place: tuple[str, ...], path: Path) -> Any:
    try:
        return record.model_validate(values)
    except ValidationError as error:
        raise StudyError(f"{path}: {_first_error(error, record, values, place)}") from error


def _mesh_record(values: dict[str, Any], path: Path) -> type[BaseModel] | None:
    """Record that the mesh section is meant for, so that messages speak of that one alone."""
    mesh = values.get("mesh")
    if mesh is None:
        return None
    if not isinstance(mesh, dict):
        raise StudyError(f"{path}: mesh = {_shown(mesh)}: must be a section with keys")
    if "file" in mesh:
        return MeshFile
    models: dict[str, type[BaseModel]] = {"rod": Rod, "beam": Beam, "plate": Plate, "blade": Blade}
    model = mesh.get("model")
    if not isinstance(model, str) or model not in models:
        known = ", ".join(f'"{name}"' for name in models)
        given = f"mesh.model = {_shown(model)}:" if "model" in mesh else "mesh.model: is missing,"
        raise StudyError(
            f"{path}: {given} must be one of {known}, or mesh.file the name of a .msh file"
        )
    return models[model]


def _prepared(values: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Single names as lists, and paths made relative to the working folder."""
    values = {key: dict(item) if isinstance(item, dict) else item for key, item in values.items()}
    for section in ("clamp", "contact"):
        table = values.get(section)
        if isinstance(table, dict) and isinstance(table.get("facets"), str):
            table["facets"] = [table["facets"]]
    mesh = values.get("mesh")
    for key in ("file", "sections"):
        if isinstance(mesh, dict) and isinstance(mesh.get(key), str):
            mesh[key] = str(folder / mesh[key])
    return values


def _first_error(
    error: ValidationError, record: type[BaseModel], values: Any, place: tuple[str, ...]
) -> str:
    """One line for the first error; unknown keys come first, since they cause others."""
    errors = sorted(error.errors(), key=lambda item: item["type"] != "extra_forbidden")
    first = errors[0]
    location = tuple(str(part) for part in first["loc"] if _is_key(part))
    name = ".".join((*place, *location))
    if first["type"] == "extra_forbidden":
        return f"{name}: unknown key{_suggestion(record, location)}"
    if first["type"] == "missing" and _is_key(first["loc"][-1]):
        return f"{name}: is missing{_wanted(record, location)}"
    if first["type"] == "value_error":
        message = first["msg"].removeprefix("Value error, ")
        return f"{name}.{message}" if name else message
    message = "is not allowed" if _has_alternatives(first["loc"]) else _plain_message(first)
    value = _shown(_value_at(values, location))
    return f"{name} = {value}: {message}{_wanted(record, location)}"


def _plain_message(error: Any) -> str:
    message = _WORDS.get(error["type"], error["msg"])
    return message.replace("Input should be", "must be").replace(" valid", "")


def _value_at(values: Any, location: tuple[str, ...]) -> Any:
    for key in location:
        values = values[key]
    return values


def _has_alternatives(place: tuple[Any, ...]) -> bool:
    """Whether pydantic's location names one alternative of several for a value."""
    return any(isinstance(part, str) and not _is_key(part) for part in place)


def _is_key(part: Any) -> bool:
    """Whether part of pydantic's location is a key of the file, not the name of an alternative."""
    return (
        isinstance(part, str)
        and part.isidentifier()
        and part.islower()
        and part not in ("float", "int", "str", "tuple")
    )


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    text = f'"{value}"' if isinstance(value, str | Path) else f"{value}"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _record_at(record: type[BaseModel], location: tuple[str, ...]) -> type[BaseModel] | None:
    """Record that holds the last key of a location."""
    for key in location[:-1]:
        field = _fields(record).get(key)
        options = [field.annotation, *getattr(field.annotation, "__args__", ())] if field else []
        records = [o for o in options if isinstance(o, type) and issubclass(o, BaseModel)]
        if not records:
            return None
        record = records[0]
    return record


def _fields(record: type[BaseModel]) -> dict[str, Any]:
    return {field.alias or name: field for name, field in record.model_fields.items()}


def _suggestion(record: type[BaseModel], location: tuple[str, ...]) -> str:
    holder = _record_at(record, location)
    known = list(_fields(holder)) if holder else []
    close = difflib.get_close_matches(location[-1], known, n=1)
    if close:
        return f': did you mean "{close[0]}"?'
    return f": the keys here are {', '.join(known)}" if known else ""


def _wanted(record: type[BaseModel], location: tuple[str, ...]) -> str:
    holder = _record_at(record, location)
    field = _fields(holder).get(location[-1]) if holder and location else None
    return f" ({field.description})" if field is not None and field.description else ""


def _plain(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
