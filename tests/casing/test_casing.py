"""Distances to casing surfaces: closed forms, and root finding that shares nothing with them."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq, minimize

from fenics_nnm.arrays import Array
from fenics_nnm.casing import (
    Cone,
    Frame,
    LobedRadius,
    Plane,
    RadialSurface,
    RadiusTable,
    Reversed,
    read_radii,
)
from fenics_nnm.errors import GeometryError

COUNT = 400


def oblique_frame(chance: np.random.Generator) -> Frame:
    return Frame(*chance.normal(size=(3, 3)))


def units(chance: np.random.Generator, count: int = COUNT) -> Array:
    vectors = chance.normal(size=(count, 3))
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None])


def on_surface(frame: Frame, radius: Callable[..., Array], theta: Array, s: Array) -> Array:
    """Points of rho = radius(theta, s), by the frame's vectors."""
    first = frame.zero - (frame.zero @ frame.unit) * frame.unit
    first = first / np.linalg.norm(first)
    second = np.cross(frame.unit, first)
    around = np.cos(theta)[:, None] * first + np.sin(theta)[:, None] * second
    return np.asarray(frame.origin + s[:, None] * frame.unit + radius(theta, s)[:, None] * around)


@pytest.mark.parametrize("slope", [0.0, 0.3, -0.7])
@pytest.mark.parametrize("largest", [0.5, 1e-4])
def test_round_casings_are_exact_on_any_axis(slope: float, largest: float) -> None:
    """Points are made by going back from the surface, so that the distance is known."""
    chance = np.random.default_rng(3)
    for scale in (1.0, 1e-2):
        frame = oblique_frame(chance)
        theta, s = chance.uniform(0, 7, COUNT), chance.uniform(-0.5, 0.5, COUNT) * scale
        met = on_surface(frame, lambda theta, s: scale + slope * s, theta, s)
        normal = (met - frame.origin) / scale
        normal -= np.outer(normal @ frame.unit, frame.unit)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        normal -= slope * frame.unit
        directions = units(chance)
        directions *= np.sign(np.sum(directions * normal, axis=1))[:, None]
        leaves = np.sum(directions * normal, axis=1) > 0.2
        t = chance.uniform(-largest, largest, COUNT) * scale
        points = met - t[:, None] * directions
        cone = Cone(frame, scale, slope)
        found = cone.distance(points[leaves], directions[leaves])
        assert leaves.sum() > 200
        np.testing.assert_allclose(found, t[leaves], rtol=0, atol=1e-12 * scale)


def test_shaft_is_met_from_outside() -> None:
    shaft = Reversed(Cone(Frame(np.zeros(3), np.array([0.0, 0, 2])), 1.0))
    points = np.array([[2.0, 0, 0], [0.9, 0, 5.0]])
    towards = np.array([[-1.0, 0, 0], [-1.0, 0, 0]])
    np.testing.assert_allclose(shaft.distance(points, towards), [1.0, -0.1], atol=1e-15)
    np.testing.assert_allclose(shaft.outward(points), towards)


def test_plane_is_met_obliquely() -> None:
    plane = Plane(np.array([0.0, 0, 2]), np.array([0.0, 0, 5]))
    slanted = np.array([[0.6, 0, 0.8]])
    np.testing.assert_allclose(plane.distance(np.array([[9.0, 9, 1]]), slanted), [1.25])
    np.testing.assert_allclose(plane.distance(np.array([[9.0, 9, 2.4]]), slanted), [-0.5])


@pytest.mark.parametrize("stations", [(), (-1.0, -0.2, 0.4, 1.0)])
def test_lobed_casing_agrees_with_fine_root_finding(stations: tuple[float, ...]) -> None:
    chance = np.random.default_rng(5)
    frame = oblique_frame(chance)
    mean = (1.0, 1.1, 1.25, 1.3) if stations else (1.0,)
    radius = LobedRadius(mean, lobes=5, amplitude=0.04, phase=0.3, stations=stations)
    surface = RadialSurface(frame, radius)
    theta, s = chance.uniform(0, 7, 40), chance.uniform(-0.6, 0.6, 40)
    points = on_surface(frame, lambda theta, s: radius(theta, s)[0] - 0.05, theta, s)
    radial = Cone(frame, 1.0).outward(points)
    directions = radial + 0.4 * units(chance, 40)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    found = surface.distance(points, directions)

    def excess(t: float, point: Array, direction: Array) -> float:
        along = (point + t * direction - frame.origin) @ frame.unit
        normal = point + t * direction - frame.origin - along * frame.unit
        first = frame.zero - (frame.zero @ frame.unit) * frame.unit
        second = np.cross(frame.unit, first)
        angle = np.arctan2(normal @ second, normal @ first)
        return float(np.linalg.norm(normal) - radius(np.array([angle]), np.array([along]))[0][0])

    for point, direction, t in zip(points, directions, found, strict=True):
        places = np.linspace(0, 0.3, 301)
        values = np.array([excess(place, point, direction) for place in places])
        first = int(np.argmax(values > 0))
        exact = brentq(excess, places[first - 1], places[first], (point, direction), xtol=1e-15)
        assert t == pytest.approx(exact, abs=1e-13)


def test_nearest_point_of_a_lobed_casing() -> None:
    frame = Frame(np.zeros(3), np.array([1.0, 0, 0]), np.array([0.0, 1, 0]))
    surface = RadialSurface(frame, LobedRadius((1.0,), lobes=3, amplitude=0.03))
    theta = np.linspace(0, 6, 7)
    points = np.column_stack([theta * 0, 0.95 * np.cos(theta), 0.95 * np.sin(theta)])
    normal = surface.outward(points)
    found = surface.distance(points, normal)

    def squared(angle: Array, point: Array) -> float:
        r = 1 + 0.03 * np.cos(3 * angle[0])
        return float(
            (point[1] - r * np.cos(angle[0])) ** 2 + (point[2] - r * np.sin(angle[0])) ** 2
        )

    for angle, point, t in zip(theta, points, found, strict=True):
        best = minimize(squared, [angle], (point,), tol=1e-14)
        assert t**2 == pytest.approx(best.fun, rel=1e-9)


def sampled(angles: int, stations: int) -> RadiusTable:
    """A table of an eccentric cone: its radius about another axis is a smooth function of both."""
    theta, x = 2 * np.pi * np.arange(angles) / angles, np.linspace(-0.4, 0.5, stations)
    return RadiusTable.of(theta, x, eccentric(theta[:, None], x[None, :]))


def eccentric(theta: Array, x: Array) -> Array:
    """Radius of the cone of radius 1 + 0.2 x whose axis lies at (0.1, 0) in the plane."""
    return np.asarray(
        0.1 * np.cos(theta) + np.sqrt((1 + 0.2 * x) ** 2 - (0.1 * np.sin(theta)) ** 2)
    )


def test_table_of_a_cone_converges_with_fourth_order() -> None:
    chance = np.random.default_rng(7)
    frame = Frame(np.zeros(3), np.array([1.0, 0, 0]), np.array([0.0, 1, 0]))
    cone = Cone(Frame(np.array([0.0, 0.1, 0]), frame.axis), 1.0, 0.2)
    theta, x = chance.uniform(0, 7, 50), chance.uniform(-0.3, 0.4, 50)
    points = on_surface(frame, lambda theta, x: eccentric(theta, x) - 0.03, theta, x)
    directions = cone.outward(points) + 0.2 * units(chance, 50)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    exact = cone.distance(points, directions)
    errors = [
        np.abs(RadialSurface(frame, sampled(n, n // 2)).distance(points, directions) - exact).max()
        for n in (8, 16, 32)
    ]
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 1e-6
    assert rates.min() > 3.5


def test_table_is_smooth_where_the_turn_closes() -> None:
    table = sampled(12, 4)
    h = 1e-4
    at = np.array([-h, 0.0, h])
    r, slope, _ = table(at, np.zeros(3))
    assert (r[2] - r[0]) / (2 * h) == pytest.approx(slope[1], abs=1e-8)
    assert slope[2] - slope[1] == pytest.approx(slope[1] - slope[0], abs=1e-7)


TABLE = "theta_deg,x_mm,r_in\n" + "".join(
    f"{angle},{x},{10 + x / 100}\n" for angle in (0, 90, 180, 270) for x in (0, 50)
)


def test_table_is_read_with_its_units(tmp_path: Path) -> None:
    (tmp_path / "casing.csv").write_text("# measured cold\n" + TABLE)
    table = read_radii(tmp_path / "casing.csv")
    assert table.span == (0.0, 0.05)
    r, _, along = table(np.array([1.0]), np.array([0.025]))
    np.testing.assert_allclose(r, [0.254 * 1.025])
    np.testing.assert_allclose(along, [0.0127 / 0.05])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("r_in", "r", "column r_m or r_cm"),
        ("90,50,10.5\n", "", "7 rows for 4 angles and 2 stations"),
        ("90,50,10.5", "90,50,wide", 'line 5: r_in = "wide": must be a number'),
        ("90,50,10.5", "90,50", "line 5: 2 cells, must be 3"),
        ("90,50,10.5", "90,50,-1", "line 5: r_in = -1: must be positive"),
        ("270,0", "360,0", "must have each pair once"),
        ("theta_deg", "theta_rad", "theta_rad goes around 43 times: must be the angles of one"),
    ],
)
def test_bad_tables_are_refused(old: str, new: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "casing.csv").write_text(TABLE.replace(old, new))
    with pytest.raises(GeometryError) as error:
        read_radii(tmp_path / "casing.csv")
    assert words in str(error.value)


def test_too_few_angles_are_refused(tmp_path: Path) -> None:
    (tmp_path / "casing.csv").write_text("theta_rad,x_m,r_m\n0,0,1\n0,1,1\n2,0,1\n2,1,1\n")
    with pytest.raises(GeometryError, match=r"2 angles with up to 245\.4 degrees"):
        read_radii(tmp_path / "casing.csv")


ALONG_X = Frame(np.zeros(3), np.array([1.0, 0, 0]), np.array([0.0, 1, 0]))
RADIAL, AXIAL = [0.0, 1, 0], [1.0, 0, 0]


@pytest.mark.parametrize(
    ("surface", "point", "direction", "words"),
    [
        (Cone(ALONG_X, 1.0), [0, 0.5, 0], AXIAL, "does not meet the casing"),
        (Cone(ALONG_X, 1.0), [0, 0, 2], RADIAL, "does not meet the casing"),
        (Cone(ALONG_X, 1.0, 0.5), [-3, 0.1, 0], RADIAL, "does not meet the casing"),
        (Plane(np.zeros(3), np.array([0.0, 0, 1])), [0, 0, -1], RADIAL, "meet the plane"),
        (RadialSurface(ALONG_X, sampled(8, 4)), [0.6, 0.5, 0], RADIAL, "from -0.4 to 0.5 m"),
        (RadialSurface(ALONG_X, LobedRadius((1.0,), 3, 0.1)), [0, 0, 2], RADIAL, "does not meet"),
    ],
)
def test_lines_that_miss_are_refused(
    surface: Cone | Plane | RadialSurface, point: list[float], direction: list[float], words: str
) -> None:
    with pytest.raises(GeometryError, match="the point at") as error:
        surface.distance(np.array([point], dtype=float), np.array([direction]))
    assert words in str(error.value)


def test_point_on_the_axis_has_no_nearest_point() -> None:
    with pytest.raises(GeometryError, match="lies on the axis"):
        Cone(ALONG_X, 1.0).outward(np.zeros((1, 3)))


def test_lobes_deeper_than_the_radius_are_refused() -> None:
    with pytest.raises(GeometryError, match="must be positive all around"):
        RadialSurface(ALONG_X, LobedRadius((1.0,), 3, 1.5))
