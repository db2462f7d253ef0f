"""Fixtures that all tests share: a small study, the command line in process, small meshes."""

from __future__ import annotations

import copy
import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from mpi4py import MPI
from read_here import STARTERS, in_this_process

from fenics_nnm.cli import main
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.files.cache import OFF, VARIABLE
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import study_from

os.environ[VARIABLE] = OFF  # no test finds what another one, or a user, has computed

#: A rod of eight linear elements: a run takes a few tenths of a second.
ROD: dict[str, Any] = {
    "title": "Small rod",
    "mesh": {"model": "rod", "length_unit": "m", "length": 1.0, "elements": 4},
    "body": {"theory": "rod", "area": 9e-4, "degree": 1},
    "material": {"young": 2.1e11, "density": 7800.0},
    "clamp": {"facets": "left"},
    "contact": {"facets": "right", "direction": [1.0], "gap": 1e-3},
    "reduction": {"modes": 2},
    "mode": {"number": 1, "harmonics": 3, "samples": 32},
    "continuation": {"energies": {"from": 0.8, "to": 1.1, "step": 0.1}, "report_at": [1.1]},
}

#: A plate in plane stress whose lower edge can touch; the left edge is clamped.
PLATE: dict[str, Any] = {
    **ROD,
    "title": "Small plate",
    "mesh": {"model": "plate", "length": 1.0, "height": 0.25, "elements": [4, 1]},
    "body": {"theory": "plane-stress", "thickness": 0.01, "degree": 2},
    "material": {"young": 2.1e11, "poisson": 0.3, "density": 7800.0},
    "contact": {"facets": "right", "direction": [0.0, 1.0], "gap": 1e-3},
}

#: A beam of hexahedra; its free end can touch an obstacle above it.
BEAM: dict[str, Any] = {
    **PLATE,
    "title": "Small beam",
    "mesh": {"model": "beam", "length": 1.0, "width": 0.15, "height": 0.1, "elements": [3, 1, 1]},
    "body": {"theory": "solid", "degree": 2},
    "contact": {"facets": "right", "direction": [0.0, 0.0, 1.0], "gap": 1e-3},
}


@dataclass(frozen=True, slots=True)
class Ended:
    """What a call of the command line left: its exit code and what it wrote."""

    code: int
    out: str
    err: str

    def assert_one_line(self, code: int, *words: str) -> None:
        """One line on stderr that begins with the program's name and holds all the words."""
        assert self.code == code, self.err
        lines = self.err.splitlines()
        assert len(lines) == 1, self.err
        assert lines[0].startswith("fenics-nnm: "), self.err
        missing = [word for word in words if word not in lines[0]]
        assert not missing, (missing, lines[0])
        assert self.out == ""


@pytest.fixture(autouse=True)
def _reads_here(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Meshes are read in the process of a test, unless it is marked `own_process`."""
    if request.node.get_closest_marker("own_process") is None:
        for name in STARTERS:
            monkeypatch.setattr(f"fenics_nnm.{name}.in_own_process", in_this_process)


@pytest.fixture
def study_file(tmp_path: Path) -> Callable[..., Path]:
    """A function that writes `study.toml`: a base study with some keys changed.

    `study_file(material={"young": -1.0})` replaces one key of a section, `clamp=None` leaves the
    section out, `clamp={"facets": None}` the key, and `base=PLATE` begins with another study.
    """

    def write(base: dict[str, Any] = ROD, name: str = "study.toml", **changes: Any) -> Path:
        path = tmp_path / name
        path.write_text(toml(changed(base, changes)))
        return path

    return write


@pytest.fixture
def command(tmp_path: Path, monkeypatch: Any, capfd: Any) -> Callable[..., Ended]:
    """A function that calls the command line in process, in an empty folder.

    However slow the machine is, no stage reports how far it is.
    """
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fenics_nnm.progress._PATIENCE", math.inf)

    def call(*arguments: object) -> Ended:
        capfd.readouterr()
        code = main([str(argument) for argument in arguments])
        return Ended(code, *capfd.readouterr())

    return call


@pytest.fixture
def plate_analysis() -> LinearAnalysis:
    """Linear analysis of the small plate."""
    return linear_analysis(study_from(dict(PLATE), Path("study.toml")), MPI.COMM_SELF)


def contents(folder: Path) -> dict[str, bytes]:
    """All files of a folder with their bytes."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def changed(base: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """A copy of a study with some keys replaced, or left out where the change is None.

    A mesh, or any other section, that changes its kind altogether is given as `{"=": {...}}`.
    """
    study = copy.deepcopy(base)
    for key, change in changes.items():
        if isinstance(change, dict) and "=" in change:
            study[key] = change["="]
        elif isinstance(change, dict) and isinstance(study.get(key, {}), dict):
            study[key] = changed(study.get(key, {}), change)
        else:
            study[key] = change
    return {key: value for key, value in study.items() if value is not None}


def toml(study: dict[str, Any]) -> str:
    """The text of a study file."""
    plain = [f"{k} = {_value(v)}" for k, v in study.items() if not isinstance(v, dict)]
    sections = [
        "\n".join([f"\n[{name}]", *(f"{key} = {_value(item)}" for key, item in table.items())])
        for name, table in study.items()
        if isinstance(table, dict)
    ]
    return "\n".join([*plain, *sections, ""])


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_value(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return repr(value) if isinstance(value, int | float) else f'"{value}"'
