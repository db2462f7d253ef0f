"""What a file of results says of all its motions: study, versions, model and series in time."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import h5py
import numpy as np

from fenics_nnm.fem.blocks import Data
from fenics_nnm.mechanics.contact_points import MASSIVE, MASSLESS, ContactPoints
from fenics_nnm.mechanics.fourier import CosineSeries, FourierSeries, Series
from fenics_nnm.mechanics.kinematics import LINEAR, Kinematics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.second_order import SecondOrder
from fenics_nnm.results.stored_text import values_of
from fenics_nnm.study.resolution import Resolution

#: Bytes below which a data set is not compressed, which needs more than that itself.
_SMALL = 4096

#: How data sets that are compressed are stored: what takes little time.
_PACKING: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}


@dataclass(frozen=True, slots=True)
class BranchHeader:
    """What a branch file holds besides its points.

    Attributes:
        study: Text of the study file.
        versions: Versions of the program and its libraries.
        mode: Number of the linear mode, from 1.
        harmonics: Number of harmonics N.
        samples: Time samples of a period m.
        modes: Number of modes of the reduction; those of the model are more where it has
            constraint modes too.
        series: "time-reversible" or "general".
        model: Reduced model in SI units.
        inputs: Digests of the files that the study names, by key; none in files of earlier
            versions.
    """

    study: str
    versions: dict[str, str]
    mode: int
    harmonics: int
    samples: int
    modes: int
    series: str
    model: ReducedModel
    inputs: Mapping[str, str] = field(default_factory=dict)

    @property
    def values(self) -> Mapping[str, Any]:
        """Values of the study file."""
        return values_of(self.study)

    @property
    def resolution(self) -> Resolution:
        """Harmonics, samples and modes."""
        return Resolution(self.harmonics, self.samples, self.modes)

    @property
    def time_series(self) -> Series:
        """Series in time that the points are written in."""
        kind = FourierSeries if self.series == "general" else CosineSeries
        return kind(self.harmonics, self.samples)


def image(header: BranchHeader, data: Data, kind: str) -> bytes:
    """Bytes of a file of a format, without motions and blocks.

    HDF5 may crash where it writes to a full disk itself.
    """
    with h5py.File("results.h5", "w", driver="core", backing_store=False) as file:
        file.attrs["format"] = kind
        file.attrs["study"] = header.study
        file.attrs["versions"] = json.dumps(header.versions)
        file.attrs["inputs"] = json.dumps(dict(header.inputs))
        for name in ("omega", "Phi", "R", "gap"):
            file[f"model/{name}"] = getattr(header.model, name)
        for name, tensor in header.model.kinematics.tensors.items():
            file[f"model/kinematics/{name}"] = tensor
            file["model/kinematics"].attrs["masters"] = header.model.kinematics.masters
        file["model"].attrs["massless"] = header.model.massless
        if header.model.reference is not None:
            file["model"].attrs["reference"] = header.model.reference
        series = file.create_group("series")
        for name in ("mode", "harmonics", "samples", "modes", "series"):
            series.attrs[name] = getattr(header, name)
        for name, values in data.arrays.items():
            file[name] = values
        for name, values in data.packed.items():
            packing = _PACKING if values.nbytes > _SMALL else {}
            file.create_dataset(name, data=values, **packing)
        file.create_group("points")
        file.flush()
        return bytes(file.id.get_file_image())


def header_in(file: h5py.File) -> BranchHeader:
    """The header in a file."""
    series, model = file["series"].attrs, file["model"]
    tomllib.loads(file.attrs["study"])  # of a damaged file it may be none
    return BranchHeader(
        study=file.attrs["study"],
        versions=json.loads(file.attrs["versions"]),
        mode=int(series["mode"]),
        harmonics=int(series["harmonics"]),
        samples=int(series["samples"]),
        modes=int(series["modes"]),
        series=str(series["series"]),
        inputs=json.loads(file.attrs.get("inputs", "{}")),
        model=ReducedModel(
            omega=np.array(model["omega"]),
            Phi=np.array(model["Phi"]),
            R=np.array(model["R"]),
            gap=np.array(model["gap"]),
            reference=float(model.attrs["reference"]) if "reference" in model.attrs else None,
            contact=_contact_points(model),
            kinematics=_kinematics(model),
        ),
    )


def _kinematics(model: h5py.Group) -> Kinematics:
    """Kinematics of the model; linear where none are stored."""
    if "kinematics" not in model:
        return LINEAR
    stored = model["kinematics"]
    tensors = {name: np.array(stored[name]) for name in ("Theta", "alpha", "beta", "D")}
    return SecondOrder(masters=np.array(stored.attrs["masters"]), **tensors)


def _contact_points(model: h5py.Group) -> ContactPoints:
    """Kind of the contact points; files of earlier versions have R = 0 for points with mass."""
    massless = model.attrs["massless"] if "massless" in model.attrs else np.any(model["R"])
    return MASSLESS if massless else MASSIVE
