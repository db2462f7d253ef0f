"""Static states under rotation, temperature, pressures and forces, against exact solutions."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, changed
from mpi4py import MPI
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

from fenics_nnm.errors import ConvergenceError
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.loaded_residual import LoadedResidual
from fenics_nnm.fem.loads import Loads, Pressure
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.state_stress import state_stress_at
from fenics_nnm.fem.static_state import loaded
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.load_lines import load_lines
from fenics_nnm.structure.loading import loads_of
from fenics_nnm.structure.mesh_structure import MeshStructure
from fenics_nnm.structure.point_choice import evenly_spread
from fenics_nnm.study import MeshStudy, study_from

COMM = MPI.COMM_SELF

#: Wave speed of the rods in m/s, and their stiffness E A in N.
SPEED, EA = np.sqrt(2.1e11 / 7800.0), 2.1e11 * 9e-4

#: A cube of one element that three of its sides hold along their normals.
CUBE: dict[str, Any] = changed(
    BEAM,
    {
        "mesh": {"length": 0.3, "width": 0.2, "height": 0.1, "elements": [1, 1, 1]},
        "clamp": [
            {"facets": name, "directions": [axis]}
            for name, axis in (("left", "x"), ("front", "y"), ("bottom", "z"))
        ],
        "contact": {"facets": "right", "direction": [1.0, 0.0, 0.0]},
    },
)


def analysis(base: dict[str, Any], **changes: Any) -> LinearAnalysis:
    found: Any = linear_analysis(study_from(changed(base, changes), Path("study.toml")), COMM)
    return found


def body_and_contact(base: dict[str, Any], **changes: Any) -> tuple[Solid, ContactInterface]:
    """A body about its static state, and its contact points."""
    study = study_from(changed(base, changes), Path("study.toml"))
    assert isinstance(study, MeshStudy)
    found = MeshStructure(study).assembled(COMM, Stages())
    return found.solid, found.interface(evenly_spread(found.sites))


def solid_of(base: dict[str, Any], **changes: Any) -> Solid:
    return body_and_contact(base, **changes)[0]


def moved(solid: Solid) -> tuple[np.ndarray, np.ndarray]:
    """Places and displacements of the nodes of a loaded body, (n, dim) each."""
    assert solid.state is not None
    x = solid.space.tabulate_dof_coordinates()[:, : solid.tagged.dim]
    return x, solid.state.owned(solid.owned).reshape(x.shape)


def difference(first: Any, second: Any) -> float:
    """Frobenius norm of the difference of two matrices, over that of the second."""
    matrix = first.copy()
    matrix.axpy(-1.0, second)
    return float(matrix.norm() / second.norm())


def rotating_rod(k: float, elements: int) -> float:
    """Tip displacement over k^2 of a rod from 1 to 2 m about z, Omega = k c; degree 2."""
    rotation = {"axis": "z", "origin": [-1.0, 0.0, 0.0], "speed": k * SPEED}
    body = solid_of(ROD, mesh={"elements": elements}, body={"degree": 2}, rotation=rotation)
    x, u = moved(body)
    return float(u[np.argmax(x[:, 0]), 0]) / k**2


def exact_rotating_rod(k: float) -> float:
    """The same of St. Venant and Kirchhoff's rod, E A (F (F^2 - 1) / 2)' + k^2 E A (x + u) = 0."""

    def slopes(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        u, F = y
        return np.array([F - 1, -(k**2) * (x + u) / ((3 * F**2 - 1) / 2)])

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.array([a[0], b[1] - 1])

    x = np.linspace(1, 2, 50)
    found = solve_bvp(slopes, ends, x, np.array([0 * x, 1 + 0 * x]), tol=1e-10)
    return float(found.y[0, -1]) / k**2


def test_a_slowly_rotating_rod_has_the_linear_closed_form() -> None:
    """u(R + L) = k^2 (R L^2 / 2 + L^3 / 3) without softening, R = L = 1."""
    assert rotating_rod(1e-4, 1) == pytest.approx(5 / 6, rel=1e-6)


def test_a_rotating_rod_of_large_strain() -> None:
    errors = np.array([rotating_rod(0.3, n) / exact_rotating_rod(0.3) - 1 for n in (4, 8)])
    assert abs(errors[1]) < 1e-6
    assert abs(errors[0] / errors[1]) > 12  # order 4 at the tip
    assert exact_rotating_rod(0.3) * 0.09 < 0.0778724 - 0.005  # a stretched rod of his is stiffer


def test_a_motion_along_the_axis_does_not_soften() -> None:
    """A body on springs: omega^2 = k/m along the axis, k/m - Omega^2 normal to it."""
    spring, speed = 1e4, 3.0
    mass = 7800.0 * 0.15 * 0.1
    body = analysis(
        BEAM,
        clamp=None,
        mesh={"elements": [1, 1, 1]},
        spring=[{"facets": name, "stiffness": [spring / 2] * 3} for name in ("left", "right")],
        rotation={"axis": "z", "origin": [0.5, 0.075, 0.05], "speed": speed},
        reduction={"modes": 3},
        contact={"facets": "top"},
    )
    soft = np.sqrt(spring / mass - speed**2)
    expected = [soft, soft, np.sqrt(spring / mass)]
    assert body.modes.omega == pytest.approx(expected, rel=1e-4)


def test_flapping_and_lagging_differ_by_the_speed() -> None:
    """omega_flap^2 - omega_lag^2 = Omega^2 for a slender beam of square section (Southwell)."""
    body = analysis(
        BEAM,
        mesh={"width": 0.04, "height": 0.04, "elements": [4, 1, 1]},
        rotation={"axis": "z", "origin": [0.0, 0.02, 0.02], "speed": 150.0},
        reduction={"modes": 2},
    )
    lag, flap = body.modes.omega
    assert flap**2 - lag**2 == pytest.approx(150.0**2, rel=3e-3)


@pytest.mark.parametrize(
    ("material", "expansion"),
    [
        ({"expansion": 1e-3}, (1e-3, 1e-3, 1e-3)),
        (
            {
                "=": {
                    "young": [126e9, 11e9, 9e9],
                    "poisson": [0.28, 0.40, 0.28],
                    "shear": [6.6e9, 3.9e9, 6.6e9],
                    "density": 1600.0,
                    "expansion": [-5e-4, 2e-3, 1e-3],
                    "orientation": {"axes": [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]},
                }
            },
            (1e-3, -5e-4, 2e-3),
        ),
    ],
)
def test_warming_expands_without_stress(
    material: dict[str, Any], expansion: tuple[float, ...]
) -> None:
    """E = alpha dT along each axis, so that it is longer by sqrt(1 + 2 alpha dT)."""
    load = {"temperature": 333.15}
    body = solid_of(CUBE, material=material, load=load)
    x, u = moved(body)
    assert u == pytest.approx(x * (np.sqrt(1 + 2 * 40 * np.array(expansion)) - 1), abs=1e-12)
    stress = load_lines(body)[-1].split("stress ")[1].split(" MPa")[0]
    assert float(stress) < 1e-5


def test_warming_a_body_in_plane_strain_presses_it_along_z() -> None:
    """In-plane strains are (1 + nu) alpha dT, and sigma_zz = -E alpha dT."""
    body = solid_of(
        PLATE,
        body={"theory": "plane-strain"},
        material={"expansion": 1e-6},
        clamp=[
            {"facets": "left", "directions": ["x"]},
            {"facets": "bottom", "directions": ["y"]},
        ],
        contact={"direction": [1.0, 0.0]},
        load={"temperature": 303.15},
    )
    x, u = moved(body)
    assert u == pytest.approx(x * 1.3e-5, rel=1e-4, abs=1e-15)
    assert "von Mises stress 2.1 MPa" in load_lines(body)[-1]


@pytest.mark.parametrize("follower", [False, True])
def test_pressure_from_all_sides(follower: bool) -> None:
    """The stretch s has 3 K (s^2 - 1) / 2 = -p s if pressure follows, and -p / s if it is dead."""
    p, bulk = 2e10, 2.1e11 / (3 * 0.4)
    pressure = Pressure("pressure", ("right", "back", "top"), p, follower)
    body = loaded(solid_of(CUBE), Loads(pressures=(pressure,)))
    power = 1 if follower else -1
    stretch = brentq(lambda s: 1.5 * bulk * (s**2 - 1) + p * s**power, 0.8, 1)
    x, u = moved(body)
    assert u == pytest.approx(x * (stretch - 1), rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("follower", [False, True])
def test_pressures_of_several_sections_add_up(follower: bool) -> None:
    """Facets may be under one of them, or under several."""
    p = 1e10
    parts = ((("right", "back"), 0.75), (("top",), 1.0), (("right",), 0.25), (("back",), 0.25))
    several = tuple(Pressure("pressure", names, part * p, follower) for names, part in parts)
    _, u = moved(loaded(solid_of(CUBE), Loads(pressures=several)))
    alone = Pressure("pressure", ("right", "back", "top"), p, follower)
    expected = moved(loaded(solid_of(CUBE), Loads(pressures=(alone,))))[1]
    assert u == pytest.approx(expected, rel=1e-9, abs=1e-15)
    assert np.abs(u).max() > 1e-4


def test_elastica() -> None:
    """P L^2 / EI = 1: the tip comes in by 0.056433 L and moves by 0.301721 L (J. H. Jenkins)."""
    length, height = 1.0, 0.01
    force = 2.1e11 * 0.01 * height**3 / 12
    body = solid_of(
        PLATE,
        mesh={"length": length, "height": height, "elements": [40, 1]},
        material={"poisson": 0.0},
        load={"force": [{"facets": "right", "force": [0.0, force]}]},
    )
    x, u = moved(body)
    tip = u[np.isclose(x[:, 0], length)].mean(axis=0)
    assert tip == pytest.approx([-0.056433, 0.301721], rel=3e-3)


@pytest.mark.parametrize("made", [solid_of, analysis])
def test_a_column_buckles_at_its_load(made: Callable[..., Any]) -> None:
    """Euler: pi^2 E I / (4 L^2) of a cantilever is two thirds of the load; no modes are made."""
    height = 0.02
    euler = np.pi**2 * 2.1e11 * 0.01 * height**3 / 12 / 4
    with pytest.raises(ConvergenceError, match=r"66\.\d% of the steady loads .*buckles"):
        made(
            PLATE,
            mesh={"height": height, "elements": [16, 1]},
            load={"force": [{"facets": "right", "force": [-1.5 * euler, 0.0]}]},
        )


@pytest.mark.parametrize("times", [600, 3e4])
def test_a_load_far_beyond_the_buckling_load_is_refused(times: float) -> None:
    """There are stable states beyond it, whose cells are turned inside out."""
    euler = np.pi**2 * 2.1e11 * 0.01 * 0.1**3 / 12 / 4
    force = {"facets": "right", "force": [-times * euler, 0.0]}
    with pytest.raises(ConvergenceError, match=r"static state: 0\.\d% of the steady loads"):
        solid_of(PLATE, mesh={"height": 0.1}, load={"force": [force]})


def test_a_speed_far_beyond_the_critical_one_is_refused() -> None:
    """A rod would lie stretched on the other side of the axis, at 12.99 m."""
    rotation = {"axis": "z", "origin": [2.0, 0.0, 0.0], "speed": 1e5}
    with pytest.raises(ConvergenceError, match=r"static state: 0\.\d% of the steady loads"):
        solid_of(ROD, body={"degree": 2}, rotation=rotation)


def test_an_attached_mass_is_pulled_outwards() -> None:
    """m Omega^2 r / (E A) at the tip, besides the rod's own part."""
    speed, mass = 1e-4 * SPEED, 3.0
    rotation = {"axis": "z", "origin": [-1.0, 0.0, 0.0], "speed": speed}
    for place in ({"at": [1.0]}, {"facets": "right"}):
        x, u = moved(solid_of(ROD, mass=[{**place, "mass": mass}], rotation=rotation))
        own = 5 / 6 * 1e-8
        tip = float(u[np.argmax(x[:, 0]), 0])
        assert tip - own == pytest.approx(mass * speed**2 * 2 / EA, rel=1e-6)


def residual(base: dict[str, Any], **changes: Any) -> LoadedResidual:
    study = study_from(changed(base, changes), Path("study.toml"))
    assert isinstance(study, MeshStudy)
    bare = study.model_copy(update={"rotation": None, "load": None})
    plain = MeshStructure(bare).assembled(COMM, Stages()).solid
    return LoadedResidual(plain, loads_of(study, plain))


def test_the_tangent_stiffness_is_the_derivative_of_the_residual() -> None:
    loads = residual(
        BEAM,
        material={"expansion": 1e-5},
        mass=[{"facets": "right", "mass": 3.0}, {"at": [1.0, 0.0, 0.0], "mass": 2.0}],
        rotation={"axis": [1.0, 2.0, 2.0], "origin": [0.1, 0.2, -0.3], "speed": 300.0},
        load={
            "temperature": 400.0,
            "pressure": [{"facets": "top", "pressure": 1e7}],
            "force": [{"at": [1.0, 0.0, 0.0], "force": [1e4, 2e4, 3e4]}],
        },
    )
    rng = np.random.default_rng(3)
    loads.apply(0.7)
    at, along = (rng.normal(size=len(loads.owned)) * 1e-3 for _ in range(2))
    loads.move(at)
    tangent = loads.assemble()
    right, left = tangent.createVecs()
    free = loads.value() != 0
    along[~free] = 0.0
    right.array[:] = along
    tangent.mult(right, left)
    values = []
    for step in (1e-3, -1e-3):
        loads.move(at + step * along)
        values.append(loads.value())
    found = (values[0] - values[1]) / 2e-3
    assert found[free] == pytest.approx(left.array[free], rel=1e-6, abs=1e-6 * np.abs(found).max())


def test_without_loads_the_tangent_stiffness_is_the_stiffness() -> None:
    plain = solid_of(BEAM)
    state = loaded(plain, Loads())
    assert difference(state.stiffness, plain.stiffness) < 1e-15
    assert state.state is not None and not np.any(state.state.owned(state.owned))


@pytest.mark.parametrize(
    ("contact", "closing"),
    [
        ({"direction": [1.0]}, 1.0),
        ({"direction": "normal"}, 1.0),
        (
            {
                "gap": None,
                "direction": [1.0],
                "casing": {"shape": "plane", "origin": [1.001], "normal": [1.0]},
            },
            1.0,
        ),
    ],
)
def test_gap_at_speed_of_a_rod(contact: dict[str, Any], closing: float) -> None:
    rotation = {"axis": "z", "speed": 1e-2 * SPEED}
    body, interface = body_and_contact(ROD, rotation=rotation, contact=contact)
    x, u = moved(body)
    tip = float(u[np.argmax(x[:, 0]), 0])
    assert interface.gap == pytest.approx([1e-3 - closing * tip], rel=1e-12)


def hottest(body: Solid) -> float:
    """Largest von Mises stress in MPa, as it is told."""
    return float(load_lines(body)[-1].split("stress ")[1].split(" MPa")[0])


def test_a_linear_temperature_bends_a_free_body_without_stress() -> None:
    """u = alpha g (x y, (y^2 - x^2 - z^2) / 2, y z) of a temperature g y above the reference.

    B. A. Boley and J. H. Weiner, Theory of Thermal Stresses, 1960, section 9.5: of small strains.
    """
    alpha, gradient = 1e-5, 1e-2
    body = solid_of(
        CUBE,
        mesh={"elements": [2, 1, 1]},
        material={"expansion": alpha},
        clamp=[
            {"facets": "left", "directions": ["x"]},
            {"facets": "bottom", "directions": ["z"]},
        ],
        spring=[{"at": [0.0, 0.0, 0.0], "stiffness": [0.0, 1e9, 0.0]}],
        load={
            "temperature_field": {
                "shape": "linear",
                "temperature": 293.15,
                "gradient": [0.0, gradient, 0.0],
            }
        },
    )
    assert "temperature      +0 to +0.002 K from the state free of stress, linear" in (
        "\n".join(load_lines(body))
    )
    (x, y, z), u = (found.T for found in moved(body))
    exact = alpha * gradient * np.array([x * y, (y**2 - x**2 - z**2) / 2, y * z])
    assert u == pytest.approx(exact, abs=1e-6 * np.abs(exact).max())
    assert hottest(body) < 1e-6 * 2.1e11 * alpha * gradient * 0.2 / 1e6


def test_a_bar_between_walls_is_pressed_by_its_mean_warming(tmp_path: Path) -> None:
    """sigma = -E alpha mean(T) and u = alpha int (T - mean(T)) dx; from a table in mm and C."""
    alpha, x = 1e-7, np.linspace(0.0, 1000.0, 5)
    warm = np.array([0.0, 10.0, 40.0, 20.0, 5.0])
    rows = "\n".join(f"{a},{t}" for a, t in zip(x, 20.0 + warm, strict=True))
    (tmp_path / "t.csv").write_text(f"# measured\nx_mm,T_C\n{rows}\n")
    bar = changed(
        PLATE,
        {
            "material": {
                "=": {
                    "young": [2.1e11] * 3,
                    "poisson": [0.0] * 3,
                    "shear": [1.05e11] * 3,
                    "density": 7800.0,
                    "expansion": [alpha, 0.0, 0.0],
                }
            },
            "clamp": [
                {"facets": ["left", "right"], "directions": ["x"]},
                {"facets": "bottom", "directions": ["y"]},
            ],
            "contact": {"facets": "top"},
            "load": {"temperature_field": {"shape": "table", "file": "t.csv"}},
        },
    )
    study = study_from(bar, tmp_path / "study.toml")
    assert isinstance(study, MeshStudy)
    body = MeshStructure(study).assembled(COMM, Stages()).solid
    mean = np.trapezoid(warm, x) / 1000
    at, u = moved(body)
    held = np.concatenate([[0.0], np.cumsum((warm[1:] + warm[:-1]) / 2 - mean) * 0.25])
    ends = np.isin(at[:, 0], x / 1000)
    exact = alpha * np.interp(at[ends, 0], x / 1000, held)
    assert u[ends, 0] == pytest.approx(exact, abs=1e-4 * exact.max())
    stress = state_stress_at(body, np.array([[0.5, 0.5]]))[:, 0]
    assert stress[:, 0] == pytest.approx(np.full(4, -2.1e11 * alpha * mean), rel=1e-4)
