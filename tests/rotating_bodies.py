"""Rotating bodies against closed forms, published values and another program.

    python3 tests/rotating_bodies.py        # a few minutes

prints the tables of docs/verification_bodies.md, and asserts what they show.
"""

from __future__ import annotations

import csv
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import ufl
from cell_boxes import box, write_inp
from dolfinx import fem
from dolfinx.fem.petsc import assemble_matrix
from mpi4py import MPI
from small_meshes import saved_model

from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.gyroscopic import coriolis_frequencies
from fenics_nnm.fem.linear import operators_of
from fenics_nnm.fem.modes import DirectModalSolver
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.state_stress import state_stress_at
from fenics_nnm.fem.system import FreeSystem
from fenics_nnm.stages import Stages
from fenics_nnm.structure.mesh_structure import MeshStructure
from fenics_nnm.structure.point_choice import evenly_spread
from fenics_nnm.study import MeshStudy, study_from

REFERENCE = Path(__file__).parent / "reference"
SECTIONS = Path(__file__).parent.parent / "meshes" / "rotor37_blade_sections.csv"


#: The blade of demos/rotor37 on a mesh of 6 mm.
ROTOR37: dict[str, Any] = {
    "mesh": {
        "model": "blade",
        "sections": str(SECTIONS),
        "length_unit": "m",
        "first_section": 1,
        "last_section": 12,
        "element_size": 0.006,
    },
    "body": {"theory": "solid"},
    "material": {"young": 108e9, "poisson": 0.34, "density": 4400.0},
    "clamp": {"facets": "root"},
}


def reference(name: str) -> list[dict[str, Any]]:
    """Rows of a reference file, numbers as such."""
    lines = (REFERENCE / name).read_text().splitlines()
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return [{key: _number(value) for key, value in row.items()} for row in rows]


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def body(values: Mapping[str, Any], rotation: Mapping[str, Any]) -> tuple[Solid, ContactInterface]:
    """A body about its state at speed."""
    energies = {"from": 1, "to": 2, "step": 1}
    common = {"reduction": {"modes": 1}, "continuation": {"energies": energies}}
    study = study_from({**common, **values, "rotation": dict(rotation)}, Path("study.toml"))
    assert isinstance(study, MeshStudy)
    found = MeshStructure(study).assembled(MPI.COMM_WORLD, Stages())
    return found.solid, found.interface(evenly_spread(found.sites))


def frequencies(
    solid: Solid, interface: ContactInterface, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies in Hz without and with Coriolis forces of so many modes, shape (count,) each."""
    with DirectModalSolver(solid) as solver:
        modes = solver.modes(count)
        if solid.state is None or solid.state.loads.rotation is None:
            return modes.frequencies, modes.frequencies
        operators = operators_of(solid, interface, solver)
        coupled = coriolis_frequencies(solid, solid.state.loads.rotation, modes, operators)
    return modes.frequencies, coupled / (2 * np.pi)


def say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def begin(name: str, *columns: str) -> None:
    """Print the head of a table of the report."""
    say(f"{name}\n| {' | '.join(columns)} |\n|{'---|' * len(columns)}")


def displacement_at(solid: Solid, points: np.ndarray) -> np.ndarray:
    """Displacement in m of the static state at the nodes nearest to points, (n, dim)."""
    assert solid.state is not None
    dim = solid.tagged.dim
    x = solid.space.tabulate_dof_coordinates()[:, :dim]
    nearest = [int(np.argmin(np.linalg.norm(x - point, axis=1))) for point in points]
    return solid.state.owned(solid.owned).reshape(-1, dim)[nearest]


# Annular disc.


def quarter_annulus(path: Path, rings: int) -> None:
    """A quarter of an annulus 0.1 to 0.3 m of curved quadrangles."""
    with saved_model(path):
        geo = gmsh.model.geo
        a, b = 0.1, 0.3
        centre = geo.addPoint(0, 0, 0)
        inner, outer = ([geo.addPoint(r, 0, 0), geo.addPoint(0, r, 0)] for r in (a, b))
        arcs = [geo.addCircleArc(ends[0], centre, ends[1]) for ends in (inner, outer)]
        sides = [geo.addLine(inner[i], outer[i]) for i in (0, 1)]
        face = geo.addPlaneSurface([geo.addCurveLoop([sides[0], arcs[1], -sides[1], -arcs[0]])])
        geo.synchronize()
        for curve in gmsh.model.getEntities(1):
            gmsh.model.mesh.setTransfiniteCurve(curve[1], rings + 1)
        gmsh.model.mesh.setTransfiniteSurface(face)
        gmsh.model.mesh.setRecombine(2, face)
        gmsh.model.addPhysicalGroup(2, [face], name="disc")
        names = {"inner": arcs[0], "outer": arcs[1], "below": sides[0], "beside": sides[1]}
        for name, curve in names.items():
            gmsh.model.addPhysicalGroup(1, [curve], name=name)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(2)


def annular_disc(folder: Path) -> None:
    """Growth of the rim: clamped at the hole and free, in closed form."""
    speed, found = 10.0, {}
    symmetry = [
        {"facets": "below", "directions": ["y"]},
        {"facets": "beside", "directions": ["x"]},
    ]
    for rings in (4, 8, 16):
        quarter_annulus(folder / f"disc{rings}.msh", rings)
        for name, hole in (("clamped", [{"facets": "inner"}]), ("free", [])):
            values = {
                "mesh": {"file": str(folder / f"disc{rings}.msh"), "length_unit": "m"},
                "body": {"theory": "plane-stress", "thickness": 0.01},
                "material": {"young": 2.1e11, "poisson": 0.3, "density": 7850.0},
                "clamp": [*symmetry, *hole],
                "contact": {"facets": "outer", "direction": [1.0, 1.0], "gap": 1.0},
            }
            solid, _ = body(values, {"axis": "z", "speed": speed})
            (u,) = displacement_at(solid, np.array([[0.3, 0.0]]))
            found[rings, name] = float(u[0]) * (1000.0 / speed) ** 2
    exact = {"clamped": 131.677e-6, "free": 269.143e-6}
    shown = ("growth of the disc clamped at its hole (um)", "growth of the free disc (um)")
    begin("docs: rotating_disc", "rings of elements", *shown)
    for rings in (4, 8, 16):
        row = " | ".join(
            f"{1e6 * found[rings, name]:.3f} ({found[rings, name] / exact[name] - 1:+.1e})"
            for name in exact
        )
        say(f"| {rings} | {row} |")
    say("| closed form | 131.677 | 269.143 |\n")
    assert all(abs(found[16, name] / exact[name] - 1) < 1e-4 for name in exact)


def warm_disc(folder: Path) -> None:
    """A free annular disc whose temperature is that of a table, 100 K times (r / b)^2.

    Timoshenko and Goodier, Theory of Elasticity, 3rd ed. 1970, section 150: with
    I = int_a^b T r dr the rim grows by 2 alpha b I / (b^2 - a^2), and the stress along the hole is
    alpha E (2 I / (b^2 - a^2) - T(a)).
    """
    a, b, alpha, E, hot = 0.1, 0.3, 1e-7, 2.1e11, 100.0
    r, angle = np.meshgrid(np.linspace(a, b, 81), np.linspace(0, np.pi / 2, 81))
    x, y, T = (r * np.cos(angle)).ravel(), (r * np.sin(angle)).ravel(), hot * (r.ravel() / b) ** 2
    table = folder / "warm.csv"
    table.write_text(
        "x_m,y_m,T_C\n"
        + "".join(
            f"{p!r},{q!r},{20 + t!r}\n"
            for p, q, t in zip(x.tolist(), y.tolist(), T.tolist(), strict=True)
        )
    )
    whole = hot * (b**4 - a**4) / (4 * b**2) / (b**2 - a**2)
    exact = (2 * alpha * b * whole, alpha * E * (2 * whole - hot * a**2 / b**2))
    shown = ("growth of the rim (um)", "circumferential stress at the hole (MPa)")
    begin("docs: warm_disc", "rings of elements", *shown)
    for rings in (4, 8, 16):
        quarter_annulus(folder / f"disc{rings}.msh", rings)
        values = {
            "mesh": {"file": str(folder / f"disc{rings}.msh"), "length_unit": "m"},
            "body": {"theory": "plane-stress", "thickness": 0.01},
            "material": {"young": E, "poisson": 0.3, "density": 7850.0, "expansion": alpha},
            "clamp": [
                {"facets": "below", "directions": ["y"]},
                {"facets": "beside", "directions": ["x"]},
            ],
            "contact": {"facets": "outer", "direction": [1.0, 1.0], "gap": 1.0},
            "load": {"temperature_field": {"shape": "table", "file": str(table)}},
        }
        solid, _ = body(values, {"axis": "z", "speed": 0.0})
        (u,) = displacement_at(solid, np.array([[b, 0.0]]))
        stress = state_stress_at(solid, np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]))
        found = (float(u[0]), float(stress[:, :, :2].max()))
        grown, pulled = (f / e - 1 for f, e in zip(found, exact, strict=True))
        rim, hole = f"{1e6 * found[0]:.4f} ({grown:+.1e})", f"{found[1] / 1e6:.4f} ({pulled:+.1e})"
        say(f"| {rings} | {rim} | {hole} |")
    say(f"| closed form | {1e6 * exact[0]:.4f} | {exact[1] / 1e6:.4f} |\n")
    assert abs(grown) < 1e-4 and abs(pulled) < 1e-2


# Cantilevers.


def cantilever(slenderness: float, axis: str, origin: float, speed: float, modes: int) -> Any:
    """Frequencies of a slender beam in 2-D that bends without shear, over sqrt(EI / rho A L^4)."""
    height, E, rho = 12**0.5 / slenderness, 1e11, 1e3
    unit = np.sqrt(E * height**2 / 12 / rho)
    values = {
        "mesh": {"model": "plate", "length": 1.0, "height": height, "elements": [24, 1]},
        "body": {"theory": "plane-stress", "thickness": 0.01},
        "material": {
            "young": [E] * 3,
            "poisson": [0.0] * 3,
            "shear": [1e3 * E] * 3,
            "density": rho,
        },
        "clamp": {"facets": "left"},
        "contact": {"facets": "right", "direction": [0.0, 1.0], "gap": 1.0},
    }
    middle = height / 2 if axis == "z" else 0.0
    rotation = {"axis": axis, "origin": [-origin, middle, 0.0], "speed": speed * unit}
    return [2 * np.pi * each / unit for each in frequencies(*body(values, rotation), modes)]


def flapping() -> None:
    """First flapping frequency of a cantilever about its root (Wright et al. 1982)."""
    published = {0: 3.5160, 2: 4.1373, 4: 5.5850, 6: 7.3603, 8: 9.2568, 10: 11.2023}
    shown = ("computed frequency", "frequency of Wright et al.", "relative difference")
    begin("docs: rotating_flap", "speed eta", *shown)
    worst = 0.0
    for eta, exact in published.items():
        found = cantilever(300.0, "y", 0.0, eta, 2)[0][0]
        worst = max(worst, abs(found / exact - 1))
        say(f"| {eta} | {found:.4f} | {exact:.4f} | {found / exact - 1:+.1e} |")
    say("")
    assert worst < 1e-3


def lagging() -> None:
    """Vibration in the plane of rotation, with Coriolis coupling to axial motion."""
    shown = (
        "first frequency, with Coriolis forces",
        "reference, with Coriolis forces",
        "relative difference, with Coriolis forces",
        "first frequency, without Coriolis forces",
        "reference, without Coriolis forces",
    )
    begin("docs: rotating_lag", "R/L", "speed eta", *shown)
    worst = 0.0
    for row in reference("a_chordwise_coriolis_slenderness70.csv"):
        if row["eta"] not in (2, 4, 6):
            continue
        plain, coupled = cantilever(70.0, "z", row["delta"], row["eta"], 16)
        exact = row["lambda1_coriolis"]
        error = coupled[0] / exact - 1
        worst = max(worst, abs(error), abs(plain[0] / row["lambda1_real"] - 1))
        say(
            f"| {row['delta']:g} | {row['eta']:g} | {coupled[0]:.5f} | {exact:.5f} | {error:+.1e} "
            f"| {plain[0]:.5f} | {row['lambda1_real']:.5f} |"
        )
    say("")
    assert worst < 3e-3


# Twisted blade.


def twisted(x: np.ndarray) -> np.ndarray:
    """From the unit cube to the twisted plate of the reference."""
    s, c, t = x[:, 0], 0.1 * (x[:, 1] - 0.5), 0.006 * (x[:, 2] - 0.5)
    turn = np.radians(10 + 45 * s)
    return np.column_stack(
        [
            0.3 + 0.3 * s,
            c * np.sin(turn) - t * np.cos(turn),
            c * np.cos(turn) + t * np.sin(turn),
        ]
    )


def twisted_blade(folder: Path) -> None:
    """Eight frequencies at all speeds, four with Coriolis forces, and the growth of the tip."""
    write_inp(box((24, 8, 1), lambda column: "hexahedron", twisted, 2), folder / "twisted.inp")
    values = {
        "mesh": {"file": str(folder / "twisted.inp"), "length_unit": "m"},
        "body": {"theory": "solid"},
        "material": {"young": 1.1e11, "poisson": 0.3, "density": 4500.0},
        "groups": {"root": {"x": 0.3}, "tip": {"x": 0.6}},
        "clamp": {"facets": "root"},
        "contact": {"facets": "tip", "direction": [1.0, 0.0, 0.0], "gap": 1.0, "points": 3},
    }
    corners = twisted(np.array([[1.0, c, 0.5] for c in (0.0, 0.5, 1.0)]))
    names = [f"f{n}" for n in range(1, 9)]
    shown = (
        *(f"f{n} (Hz)" for n in (1, 2, 3, 4, 8)),
        "largest difference of f1 to f8, without Coriolis forces",
        "largest difference of f1 to f4, with Coriolis forces",
        "largest difference of the tip displacement",
    )
    begin("docs: rotating_twisted", "speed (rad/s)", *shown)
    full = np.array([251.242, 470.287, 653.629, 1052.545])
    for row in reference("a_twisted_blade_campbell.csv"):
        if row["mesh"] != "24x8x1":
            continue
        speed = row["Om_rad_s"]
        solid, interface = body(values, {"axis": "z", "speed": speed})
        plain, coupled = frequencies(solid, interface, 16)
        exact = np.array([row[name] for name in names])
        error = np.abs(plain[:8] / exact - 1).max()
        with_coriolis = (
            full if speed == 1200 else np.array([row[f"f{n}_cor"] for n in (1, 2, 3, 4)])
        )
        coriolis = np.abs(coupled[:4] / with_coriolis - 1).max()
        growth = 0.0
        if speed:
            grown = displacement_at(solid, corners)[:, 0] * 1e6
            expected = np.array([row["ux_c_minus"], row["ux_mid"], row["ux_c_plus"]])
            growth = float(np.abs(grown / expected - 1).max())
        hertz = " | ".join(f"{plain[i]:.3f}" for i in (0, 1, 2, 3, 7))
        say(f"| {speed:g} | {hertz} | {error:.1e} | {coriolis:.1e} | {growth:.1e} |")
        assert error < 5e-3 and coriolis < 5e-3 and growth < 1e-2
    say("")


# Rotor 37.


def mass_of_four_points(solid: Solid, density: float) -> Solid:
    """The body with its mass integrated by four points a tetrahedron, as CalculiX 2.20 does."""
    u, v = ufl.TrialFunction(solid.space), ufl.TestFunction(solid.space)
    form = fem.form(density * ufl.inner(u, v) * ufl.dx(degree=2))
    mass = assemble_matrix(form, list(solid.held), 0.0)
    mass.assemble()
    return replace(solid, mass=mass, system=FreeSystem(solid.stiffness, mass))


def rotor37() -> None:
    """Six frequencies at four speeds, on the very mesh of CalculiX."""
    contact = {"facets": "tip", "direction": "radial", "axis": "x", "gap": 1.0, "points": 3}
    values = {**ROTOR37, "contact": contact}
    shown = (
        *(f"f{n} (Hz)" for n in (1, 2, 3, 6)),
        "largest difference of f1 to f6, mass by four points",
        "largest difference of f1 to f6, exact mass",
        "change of f1 by Coriolis forces",
    )
    begin("docs: rotating_rotor37", "speed (rad/s)", *shown)
    for row in reference("rotor37_6mm_calculix_speed.csv"):
        solid, interface = body(values, {"axis": "x", "speed": row["speed_rad_s"]})
        exact = np.array([row[f"f{n}"] for n in range(1, 7)])
        same, _ = frequencies(mass_of_four_points(solid, 4400.0), interface, 6)
        plain, coupled = frequencies(solid, interface, 10)
        errors = [np.abs(each[:6] / exact - 1).max() for each in (same, plain)]
        hertz = " | ".join(f"{same[i]:.4f}" for i in (0, 1, 2, 5))
        say(
            f"| {row['speed_rad_s']:g} | {hertz} | {errors[0]:.1e} | {errors[1]:.1e} | "
            f"{coupled[0] / plain[0] - 1:+.1e} |"
        )
        assert errors[0] < 1e-5 and errors[1] < 5e-5
    say("")


def studies(folder: Path) -> Iterator[Any]:
    """All studies, by their names."""
    yield "disc", lambda: annular_disc(folder)
    yield "warm_disc", lambda: warm_disc(folder)
    yield "flap", flapping
    yield "lag", lagging
    yield "twisted", lambda: twisted_blade(folder)
    yield "rotor37", rotor37


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        for study, run in studies(Path(name)):
            if study in (sys.argv[1:] or [study]):
                run()
