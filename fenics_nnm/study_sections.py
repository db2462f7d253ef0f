"""Sections of the study file as typed records."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from fenics_nnm.geometry.parameters import LengthUnit
from fenics_nnm.study_messages import shown

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Count = Annotated[int, Field(gt=0)]
Auto = Literal["auto"]
FromList = BeforeValidator(lambda value: tuple(value) if isinstance(value, list) else value)
Vector = Annotated[
    tuple[Annotated[float, Field(allow_inf_nan=False)], ...],
    Field(min_length=1, max_length=3),
    FromList,
]
Gaps = Annotated[tuple[Positive, ...], Field(min_length=1), FromList]
Name = Annotated[str, Field(min_length=1)]
MatrixFile = Annotated[Path, Field(strict=False)]
Names = Annotated[tuple[str, ...], Field(min_length=1), FromList]

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class Record(BaseModel):
    """A section of a study file: frozen, without unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class MeshFile(Record):
    """A mesh made elsewhere, with named physical groups."""

    file: Annotated[Path, Field(strict=False, description="a .msh file, relative to the study")]
    length_unit: LengthUnit = Field(description="the unit of the file's coordinates")


class BodySection(Record):
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


class MaterialSection(Record):
    """Homogeneous isotropic linear elasticity."""

    young: Positive = Field(description="Young's modulus in Pa")
    poisson: float = Field(0.0, gt=-1, lt=0.5, description="Poisson's ratio, above -1, below 0.5")
    density: Positive = Field(description="mass density in kg/m^3")


class ClampSection(Record):
    """Facets without displacement."""

    facets: Names = Field(description="name of a group of facets, or a list of names")


class MatrixArchive(Record):
    """Matrices of another code, together in one file."""

    file: Annotated[Path, Field(strict=False, description="a .npz or .mat file")]
    stiffness: Name = Field("K", description="name of the stiffness in the file")
    mass: Name = Field("M", description="name of the mass in the file")
    contact_rows: Name = Field("B", description="name of the contact rows in the file")

    @model_validator(mode="after")
    def _holds_several(self) -> MatrixArchive:
        if self.file.suffix not in (".npz", ".mat"):
            raise ValueError(
                f"file = {shown(self.file)}: must be a .npz or .mat file; other files are named "
                "by stiffness, mass and contact_rows, without file"
            )
        return self

    @property
    def places(self) -> tuple[tuple[Path, str | None], ...]:
        """File and name of stiffness, mass and contact rows."""
        return tuple((self.file, name) for name in (self.stiffness, self.mass, self.contact_rows))


class MatrixFiles(Record):
    """Matrices of another code, each in a file of its own."""

    stiffness: MatrixFile = Field(description="a .mtx, .npy, .npz or .mat file; or file = ...")
    mass: MatrixFile = Field(description="a .mtx, .npy, .npz or .mat file")
    contact_rows: MatrixFile = Field(description="a .mtx, .npy, .npz or .mat file")

    @property
    def places(self) -> tuple[tuple[Path, str | None], ...]:
        """File and name, here none, of stiffness, mass and contact rows."""
        return tuple((path, None) for path in (self.stiffness, self.mass, self.contact_rows))


class LawSection(Record):
    """Contact law, of a mesh and of matrices alike."""

    law: Literal["complementarity", "augmented-lagrangian"] | None = Field(
        None, description="by default the one that fits reduction.method"
    )


class MatrixContactSection(LawSection):
    """Gaps of the contact rows of [matrices]."""

    gap: Positive | Gaps = Field(
        description="initial gap in m, positive: one number, or a list with one a contact row"
    )

    @model_validator(mode="before")
    @classmethod
    def _nothing_of_a_mesh(cls, values: Any) -> Any:
        for key in ("facets", "direction", "axis", "origin", "points"):
            if isinstance(values, dict) and key in values:
                raise ValueError(
                    f"{key}: belongs to [mesh]: with [matrices] each contact row is a contact "
                    "point, with its direction"
                )
        return values


class ContactSection(LawSection):
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
    points: Count | Literal["all"] = Field(
        "all", description='positive number of points spread over the facets, or "all" vertices'
    )

    @model_validator(mode="before")
    @classmethod
    def _one_gap(cls, values: Any) -> Any:
        if isinstance(values, dict) and isinstance(values.get("gap"), list):
            raise ValueError(
                f"gap = {shown(values['gap'])}: must be one number in m: a list, with one gap a "
                "contact row, belongs to [matrices]"
            )
        return values

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


class ReductionSection(Record):
    """From the mesh to a few coordinates."""

    method: Literal["massless", "craig-bampton", "none"] = Field(
        "massless",
        description='"massless" (free modes, residual flexibility), "craig-bampton", or "none"',
    )
    modes: Count | Auto = Field(
        40,
        description="a positive integer, the number of free, fixed-interface or explicit modes, "
        'or "auto"',
    )
    interface: Literal["all", "contact"] | None = Field(
        None, description='retained directions of craig-bampton: "all" (default) or "contact"'
    )

    @model_validator(mode="after")
    def _interface_fits_method(self) -> ReductionSection:
        if self.method != "craig-bampton" and self.interface is not None:
            raise ValueError('interface belongs to method = "craig-bampton"')
        return self

    @model_validator(mode="after")
    def _modes_fit_method(self) -> ReductionSection:
        if self.method == "none" and self.modes == "auto":
            raise ValueError(
                'modes = "auto": at full order no mode is left out: must be the number of modes '
                "that stay explicit"
            )
        return self


class AugmentedLagrangianSection(Record):
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


class ModeSection(Record):
    """Which nonlinear mode, and its series in time."""

    number: Count = Field(1, description="number of the linear mode, from 1")
    harmonic: Count = Field(
        1, description="harmonic that the linear mode is written in at first, from 1"
    )
    harmonics: Count | Auto = Field(10, description='a positive integer, N, or "auto"')
    samples: Count | Auto = Field(
        128, description='an integer, time samples of a period, at least 2 N + 1, or "auto"'
    )
    tolerance: Annotated[float, Field(gt=0, lt=0.1)] | None = Field(
        None, description='relative error of the frequency that "auto" meets, below 0.1'
    )
    series: Literal["time-reversible", "general"] = Field(
        "time-reversible", description='"time-reversible": cosines; "general": sines too'
    )

    @model_validator(mode="after")
    def _samples_resolve_harmonics(self) -> ModeSection:
        if self.harmonics == "auto" or self.samples == "auto":
            return self
        least = 2 * self.harmonics + 1
        if self.samples < least:
            raise ValueError(
                f"samples = {self.samples} with harmonics = {self.harmonics}: "
                f"must be at least 2 harmonics + 1 = {least}"
            )
        return self


class OutputSection(Record):
    """Where results go."""

    folder: Annotated[Path, Field(strict=False)] | None = Field(
        None, description="folder of the results; the default is results/ and the study's name"
    )
    frames: Annotated[int, Field(ge=24)] = Field(
        24, description="frames of a period in the ParaView files, at least 24"
    )
