"""Several materials on one mesh: named groups of cells."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_meshes
import ufl
from conftest import PLATE, ROD, Ended
from dolfinx import fem
from mpi4py import MPI
from ranks import on_ranks
from scipy.optimize import brentq

from fenics_nnm.fem.mesh import read_mesh
from fenics_nnm.fem.solid import stress_tensor
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import read_study

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

STEEL = {"young": 2.1e11, "density": 7800.0}
ALUMINIUM = {"young": 7e10, "density": 2700.0}
FILE = {"=": {"file": "mesh.msh", "length_unit": "m"}}


def frequencies(path: Path) -> np.ndarray:
    return linear_analysis(read_study(path), MPI.COMM_SELF).modes.frequencies


def exact_frequencies(count: int) -> np.ndarray:
    """A rod of aluminium up to 0.4 m and of steel up to 1 m, clamped at 0, in Hz.

    Force and displacement are continuous: Z1 cot(omega a / c1) = Z2 tan(omega b / c2) with the
    impedances Z = sqrt(E rho).
    """
    (E1, rho1), (E2, rho2) = ((m["young"], m["density"]) for m in (ALUMINIUM, STEEL))
    t1, t2 = 0.4 / np.sqrt(E1 / rho1), 0.6 / np.sqrt(E2 / rho2)
    Z1, Z2 = np.sqrt(E1 * rho1), np.sqrt(E2 * rho2)

    def residual(omega: float) -> float:
        return float(
            Z1 * np.cos(omega * t1) * np.cos(omega * t2)
            - Z2 * np.sin(omega * t1) * np.sin(omega * t2)
        )

    grid = np.linspace(1.0, 12 / (t1 + t2), 4000)
    values = [residual(omega) for omega in grid]
    places = np.flatnonzero(np.diff(np.sign(values)))[:count]
    return np.array([brentq(residual, grid[i], grid[i + 1]) for i in places]) / (2 * np.pi)


@pytest.mark.parametrize(("degree", "rate"), [(1, 2), (2, 4)])
def test_rod_of_two_materials_converges_to_its_transcendental_equation(
    degree: int, rate: int, study_file: StudyFile, tmp_path: Path
) -> None:
    exact, errors = exact_frequencies(3), []
    for elements in (2, 4, 8):
        small_meshes.two_segments(tmp_path / "mesh.msh", elements)
        study = study_file(
            ROD,
            mesh=FILE,
            body={"degree": degree},
            material={"=": [{"cells": "inner", **ALUMINIUM}, {"cells": "outer", **STEEL}]},
            reduction={"modes": 3},
        )
        errors.append(frequencies(study)[2] / exact[2] - 1)
    assert min(errors) > 0
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), rate, atol=0.3)


def test_named_cells_cover_their_part_of_the_mesh(tmp_path: Path) -> None:
    small_meshes.halves(tmp_path / "mesh.msh")
    tagged = read_mesh(tmp_path / "mesh.msh", "m", MPI.COMM_SELF)
    assert sorted(tagged.cells) == ["east", "west"]
    space = fem.functionspace(tagged.mesh, ("DG", 0))
    centres = space.tabulate_dof_coordinates()[:, 0]
    assert centres[tagged.cells["west"]].max() < 1 < centres[tagged.cells["east"]].min()
    assert sum(map(len, tagged.cells.values())) == len(centres)


def test_two_ranks_find_the_same_materials_masses_and_springs(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    small_meshes.halves(tmp_path / "mesh.msh")
    study = study_file(
        PLATE,
        mesh=FILE,
        material={"=": [{"cells": "west", **STEEL}, {"cells": "east", **ALUMINIUM}]},
        mass=[{"at": [1.0, 1.02], "mass": 1.0}, {"facets": "right", "mass": 2.0}],
        spring=[{"at": [2.0, 1.0], "stiffness": [0.0, 1e6]}],
    )
    alone = command("check", study)
    ended = on_ranks(2, "-m", "fenics_nnm", "check", study, folder=tmp_path)
    assert (alone.code, ended.code) == (0, 0), alone.err + ended.err
    lines = alone.out.splitlines()
    assert ended.out.splitlines() == lines  # with the frequencies of the modes
    for words in (
        "material         cells west: E 210 GPa, Poisson's ratio 0, density 7800 kg/m^3",
        "mass[1]          1 kg at the vertex (1, 1) m",
        "mass[2]          2 kg spread over right",
        "spring[1]        0, 1e+06 N/m along x, y at the vertex (2, 1) m",
    ):
        assert words in lines


def test_the_stiff_half_is_where_its_cells_are(study_file: StudyFile, tmp_path: Path) -> None:
    small_meshes.halves(tmp_path / "mesh.msh")
    first = []
    for stiff, light in (("west", "east"), ("east", "west")):
        materials = [{"cells": stiff, **STEEL}, {"cells": light, **ALUMINIUM}]
        first.append(frequencies(study_file(PLATE, mesh=FILE, material={"=": materials}))[0])
    assert first[0] > 1.5 * first[1]  # stiff near the clamp, light at the free end


CASES: list[tuple[Any, str]] = [
    ([{"cells": "inner", **STEEL}], "12 cells have no material and 0 have more than one"),
    ([{"cells": "inner", **STEEL}, {"cells": ["outer", "inner"], **STEEL}], "8 have more than one"),
    ([{"cells": "iner", **STEEL}, {"cells": "outer", **STEEL}], 'material.cells = "iner"'),
    ([{"cells": "inner", **STEEL}, STEEL], "material[2].cells: is missing"),
    ([{"cells": "inner", **STEEL}, {"cells": "outer", "young": -1.0}], "material[2].young = -1.0"),
    ([], "material = []"),
]


@pytest.mark.parametrize(("materials", "words"), CASES)
def test_every_cell_has_one_material(
    materials: Any, words: str, study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    small_meshes.two_segments(tmp_path / "mesh.msh", 4)
    study = study_file(ROD, mesh=FILE, material={"=": materials})
    command("check", study).assert_one_line(2, words)


def test_an_entity_in_two_groups_is_refused(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    small_meshes.two_segments(tmp_path / "mesh.msh", 4, overlap=True)
    materials = [{"cells": "inner", **STEEL}, {"cells": "outer", **ALUMINIUM}]
    study = study_file(ROD, mesh=FILE, material={"=": materials})
    command("check", study).assert_one_line(2, "8 have more than one", '"inner", "outer"')


def test_stress_jumps_with_the_material(study_file: StudyFile, tmp_path: Path) -> None:
    """One strain in both halves; an axis in the other half does not matter to the turning one."""
    small_meshes.halves(tmp_path / "mesh.msh")
    turning = {
        "cells": "east",
        "young": [4e10, 1e10, 1e10],
        "poisson": [0.0, 0.0, 0.0],
        "shear": [5e9, 5e9, 5e9],
        "density": 1500.0,
        "orientation": {"cylindrical": "z", "origin": [0.5, 0.5, 0.0]},
    }
    study = study_file(
        PLATE, mesh=FILE, material={"=": [{"cells": "west", "poisson": 0.0, **STEEL}, turning]}
    )
    solid = linear_analysis(read_study(study), MPI.COMM_SELF).solid
    mesh = solid.tagged.mesh
    u = fem.Function(solid.space)
    u.interpolate(lambda x: np.array([1e-3 * x[0], 1e-3 * x[1]]))
    sigma = stress_tensor(u, solid)
    x = ufl.SpatialCoordinate(mesh)
    dx = ufl.Measure("dx", domain=mesh)
    west, east = (ufl.conditional(side, 1.0, 0.0) for side in (ufl.lt(x[0], 1), ufl.gt(x[0], 1)))
    # equal strains along both axes: E1 along the radius and E2 across add to the trace
    means = [fem.assemble_scalar(fem.form(ufl.tr(sigma) * side * dx)) for side in (west, east)]
    np.testing.assert_allclose(means, [2 * 2.1e8, 5e7], rtol=1e-9)
    shears = fem.assemble_scalar(fem.form(sigma[0, 1] ** 2 * west * dx))
    assert abs(shears) < 1e-6
