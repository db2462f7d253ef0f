"""Tables of temperatures: linear fields are met exactly, the edge holds outside, bad ones told."""

from __future__ import annotations

import os
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from fenics_nnm.errors import GeometryError
from fenics_nnm.geometry.scattered import ScatteredValues
from fenics_nnm.geometry.temperature import TabulatedTemperatures, read_temperatures


def written(path: Path, header: str, rows: np.ndarray) -> Path:
    lines = "\n".join(",".join(repr(float(cell)) for cell in row) for row in rows)
    path.write_text(f"{header}\n{lines}\n")
    return path


@pytest.mark.parametrize("axes", [(0,), (2,), (0, 1), (1, 2), (0, 1, 2)])
def test_linear_temperatures_between_points_and_those_of_the_edge_outside(
    axes: tuple[int, ...], tmp_path: Path
) -> None:
    """The box from 0 to 2 in each coordinate; outside the value is that at the nearest place."""
    slopes = np.array([3.0, -2.0, 5.0])[list(axes)]
    corners = np.array(list(product((0.0, 2.0), repeat=len(axes))))
    inside = np.random.default_rng(1).uniform(0, 2, (20, len(axes)))
    points = np.vstack([corners, inside])
    header = ",".join(f"{'xyz'[axis]}_cm" for axis in axes) + ",T_C"
    table = np.column_stack([100 * points, 10 + points @ slopes])
    read = read_temperatures(written(tmp_path / "t.csv", header, table))
    field = TabulatedTemperatures(read)
    assert (field.needs, field.extent) == (axes[-1] + 1, pytest.approx(2.0))
    places = np.random.default_rng(2).uniform(-1, 3, (200, 3))
    places[:8] = np.array(list(product((0.0, 2.0), repeat=3)))  # on the corners
    values, beyond = field.at(places)
    nearest = np.clip(places[:, list(axes)], 0, 2)
    assert values == pytest.approx(283.15 + nearest @ slopes, abs=1e-5)
    exact = np.abs(places[:, list(axes)] - nearest).max(axis=1)  # of the face farthest from it
    assert beyond == pytest.approx(exact, abs=1e-9)
    assert not beyond[:8].any() and field.allowed == pytest.approx(0.02)


def test_places_outside_of_slanted_faces_take_the_nearest_of_the_hull() -> None:
    """A tetrahedron: beyond its slanted face the nearest place is along its normal."""
    corners = np.vstack([np.zeros(3), np.eye(3)])
    table = ScatteredValues.of((0, 1, 2), corners, corners @ [1.0, 2.0, 3.0])
    out = np.array([[0.4, 0.4, 0.4]])
    values, beyond = table.at(out)
    assert beyond == pytest.approx([0.2 / np.sqrt(3)], rel=1e-12)
    assert values == pytest.approx([2.0], abs=1e-7)


CUBE = np.column_stack([np.array(list(product((0.0, 1.0), repeat=3))), np.full(8, 300.0)])


@pytest.mark.parametrize(
    ("header", "rows", "words"),
    [
        ("x_m,y_m,z_m,T", CUBE, "column T is unknown: must have x_m"),
        ("x_m,y_m,z_m,T_F", CUBE, "column T_F is unknown"),
        ("x,y_m,z_m,T_K", CUBE, "column x is unknown"),
        ("x_m,x_mm,z_m,T_K", CUBE, "is given 2 times"),
        ("a,b,c,T_K", CUBE, "column x_m or .* is missing"),
        ("x_m,y_m,z_m,T_K", CUBE * [1, 1, 1, -1], "line 2: T_K = -300.0: must be above absolute"),
        ("x_m,y_m,z_m,T_C", CUBE * [1, 1, 1, 1e3], "must be above absolute zero and at most 10000"),
        ("x_m,y_m,z_m,T_K", CUBE * [1, 1, np.nan, 1], 'line 2: z_m = "nan": must be a number'),
        ("x_m,y_m,z_m,T_K", CUBE[:3], "3 points: must be 4 or more for 3 coordinates"),
        ("x_m,y_m,z_m,T_K", CUBE[:4], "all points lie in a plane: must not, or leave out"),
        ("x_m,y_m,T_K", CUBE[:3, [0, 2, 3]] * [0, 1, 1], "1 points are given again"),
        ("x_m,z_m,T_K", CUBE[[0, 3, 7]][:, [1, 2, 3]], "1 points are given again"),
        ("y_m,z_m,T_K", CUBE[[0, 3]][:, [1, 2, 3]], "2 points: must be 3 or more"),
    ],
)
def test_tables_that_are_none(header: str, rows: np.ndarray, words: str, tmp_path: Path) -> None:
    with pytest.raises(GeometryError, match=words) as error:
        read_temperatures(written(tmp_path / "t.csv", header, rows))
    assert "t.csv" in str(error.value) and "\n" not in str(error.value)


def test_a_table_with_the_size_and_time_of_another_one_is_read_anew(tmp_path: Path) -> None:
    """Copies that keep the time of a file have it."""
    for kelvin in (300.0, 400.0):
        file = written(tmp_path / "t.csv", "x_m,T_K", np.array([[0.0, 300.0], [1.0, kelvin]]))
        os.utime(file, (1e9, 1e9))
        at, _ = read_temperatures(file).at(np.array([[1.0, 0.0, 0.0]]))
        assert at == pytest.approx(kelvin)
