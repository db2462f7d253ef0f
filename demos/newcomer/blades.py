# %% [markdown]
# # Three blades as STEP files
#
# A fan blade with a thin step at its tip (a squealer), a stubby turbine blade with a rail around a
# hollow tip, both with a fillet on a block, and a vane between two platforms with a button on its
# side. Lengths are in mm, x is the axis of the machine, the span is along z.
#
# Run `python3 demos/newcomer/blades.py`, which writes demos/newcomer/results/*.step.

# %%
import math
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import gmsh
import numpy as np

RESULTS = Path(__file__).parent / "results"

Solid = tuple[int, int]  # dimension and number, as gmsh has them
Offsets = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


class Section(NamedTuple):
    """A section at one radius: lengths in mm, angles in degrees."""

    radius: float
    chord: float
    stagger: float
    camber: float
    thickness: float
    edge: float
    lean: float = 0.0
    sweep: float = 0.0


FAN = [
    Section(138, 82, 18, 40, 8.5, 1.4),
    Section(150, 82, 20, 38, 8.0, 1.4),
    Section(230, 84, 36, 24, 5.5, 1.2, 2, -4),
    Section(320, 88, 51, 10, 3.6, 1.0, 3, -2),
    Section(410, 92, 61, 3, 2.4, 0.8, 0, 6),
]
TURBINE = [
    Section(214, 36, -30, 85, 7.5, 1.4),
    Section(220, 36, -30, 85, 7.2, 1.4),
    Section(250, 34, -36, 74, 6.0, 1.3, 0.5, 0.4),
    Section(280, 32, -42, 62, 5.0, 1.2, 1, 0.8),
]
VANE = [
    Section(174, 40, 25, 40, 3.2, 0.8),
    Section(180, 40, 25, 40, 3.2, 0.8),
    Section(235, 42, 18, 34, 3.0, 0.8),
    Section(290, 44, 12, 30, 3.4, 0.8),
    Section(297, 44, 12, 30, 3.4, 0.8),
]


# %% [markdown]
# A section has a circular arc as its mean line and the thickness of the four-digit NACA series.


# %%
def both_sides(half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return half, -half


def suction_side(half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """From the mean line to 8 mm off it: what a squealer leaves away."""
    return 0 * half + 8.0, 0 * half


def within_rail(half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The hollow that leaves walls of 1.1 mm."""
    return both_sides(np.maximum(half - 1.1, 0.15))


def half_thickness(section: Section, s: np.ndarray) -> np.ndarray:
    roots = 0.2969 * np.sqrt(s) - 0.1260 * s - 0.3516 * s**2 + 0.2843 * s**3 - 0.1015 * s**4
    return 5 * section.thickness * roots + section.edge / 2 * s


def outline(section: Section, offsets: Offsets, cut: float) -> list[np.ndarray]:
    """Points of both sides, shapes (15, 3), from the leading to the trailing edge."""
    s = cut + (1 - 2 * cut) * 0.5 * (1 - np.cos(np.linspace(0, math.pi, 15)))
    camber, stagger = math.radians(section.camber), math.radians(section.stagger)
    radius, angle = section.chord / (2 * math.sin(camber / 2)), (s - 0.5) * camber
    mean = np.stack([radius * np.sin(angle), radius * (np.cos(angle) - math.cos(camber / 2))], 1)
    normal = np.stack([np.sin(angle), np.cos(angle)], 1)
    cos, sin = math.cos(stagger), math.sin(stagger)
    turn = np.array([[cos, sin], [-sin, cos]])
    place = (section.sweep, section.lean)
    sides = (
        (mean + offset[:, None] * normal) @ turn + place
        for offset in offsets(half_thickness(section, s))
    )
    return [np.column_stack([side, np.full(len(s), section.radius)]) for side in sides]


def beyond(side: np.ndarray, length: float) -> np.ndarray:
    """The side, longer along the chord at both ends."""
    step = length * (side[-1] - side[0]) / np.linalg.norm(side[-1] - side[0])
    return np.vstack([side[0] - step, side, side[-1] + step])


def at_radius(inner: Section, outer: Section, radius: float) -> Section:
    """Between two sections, or beyond them along the same line."""
    part = (radius - inner.radius) / (outer.radius - inner.radius)
    values = ((1 - part) * a + part * b for a, b in zip(inner, outer, strict=True))
    return Section(*values)


# %% [markdown]
# Solids of them, by OpenCASCADE.


# %%
def loft(outlines: list[list[np.ndarray]]) -> Solid:
    occ = gmsh.model.occ
    wires = []
    for one, other in outlines:
        upper = [occ.addPoint(*point) for point in one]
        sharp = np.allclose(one[0], other[0], atol=1e-9)
        first = upper[0] if sharp else occ.addPoint(*other[0])
        lower = [first, *(occ.addPoint(*point) for point in other[1:])]
        curves = [occ.addSpline(upper), occ.addLine(upper[-1], lower[-1])]
        curves.append(occ.addSpline(lower[::-1]))
        if not sharp:
            curves.append(occ.addLine(lower[0], upper[0]))
        wires.append(occ.addWire(curves))
    (solid,) = (e for e in occ.addThruSections(wires, makeSolid=True) if e[0] == 3)
    return solid


def airfoil(sections: list[Section]) -> Solid:
    return loft([outline(section, both_sides, 0.0) for section in sections])


def cylinder(radius: float) -> Solid:
    return 3, gmsh.model.occ.addCylinder(-300, 0, 0, 600, 0, 0, radius)


def box(corner: tuple[float, float, float], size: tuple[float, float, float]) -> Solid:
    return 3, gmsh.model.occ.addBox(*corner, *size)


def common(one: Solid, other: Solid) -> Solid:
    return gmsh.model.occ.intersect([one], [other])[0][0]


def without(one: Solid, other: Solid) -> Solid:
    return gmsh.model.occ.cut([one], [other])[0][0]


def join(*solids: Solid) -> None:
    gmsh.model.occ.fuse([solids[0]], list(solids[1:]))
    tidy()


def tidy() -> None:
    """Keep the solids alone."""
    occ = gmsh.model.occ
    occ.remove([e for e in occ.getEntities() if e[0] < 3], recursive=True)
    occ.synchronize()


def on_hub(
    curve: int, radius: float, lower: tuple[float, float], upper: tuple[float, float]
) -> bool:
    """Whether the curve lies on the hub, inside the rectangle of x and y."""
    (begin,), (end,) = gmsh.model.getParametrizationBounds(1, curve)
    at = gmsh.model.getValue(1, curve, np.linspace(begin, end, 7)).reshape(-1, 3)
    inside = np.all(at[:, :2] > np.add(lower, 0.5)) and np.all(at[:, :2] < np.subtract(upper, 0.5))
    return bool(inside and np.all(abs(np.hypot(at[:, 1], at[:, 2]) - radius) < 1e-2))


def fillet(size: float, hub: float, lower: tuple[float, float], upper: tuple[float, float]) -> None:
    """Round the edges where the airfoil meets the block whose rectangle is given."""
    curves = [c for _, c in gmsh.model.getEntities(1) if on_hub(c, hub, lower, upper)]
    ((_, solid),) = gmsh.model.getEntities(3)
    gmsh.model.occ.fillet([solid], curves, [size])
    tidy()


def fan() -> None:
    hub, tip = 150.0, 400.0
    blade = common(airfoil(FAN), cylinder(tip))
    tops = [at_radius(FAN[3], FAN[4], radius) for radius in (tip - 3, tip + 6)]
    sides = [[beyond(side, 6) for side in outline(top, suction_side, 0.0)] for top in tops]
    blade = without(blade, without(loft(sides), cylinder(tip - 3)))
    join(common(box((-50, -34, 120), (100, 68, 60)), cylinder(hub)), blade)
    fillet(4.0, hub, (-50, -34), (50, 34))


def turbine() -> None:
    hub, tip = 220.0, 275.0
    rise = 60 * math.tan(math.radians(6))  # of the conical tip, over 60 mm
    cone = 3, gmsh.model.occ.addCone(-60, 0, 0, 120, 0, 0, tip - rise, tip + rise)
    blade = common(airfoil(TURBINE), cone)
    tops = [at_radius(TURBINE[2], TURBINE[3], radius) for radius in (tip - 2.5, tip + 8)]
    blade = without(blade, loft([outline(top, within_rail, 0.06) for top in tops]))
    join(common(box((-20, -15, 200), (42, 32, 40)), cylinder(hub)), blade)
    fillet(2.0, hub, (-20, -15), (22, 17))


def vane() -> None:
    inner = without(common(box((-28, -18, 165), (56, 40, 30)), cylinder(180)), cylinder(170))
    outer = without(common(box((-28, -18, 280), (56, 40, 40)), cylinder(300)), cylinder(290))
    button = 3, gmsh.model.occ.addCylinder(0, 2, 235, 0, 8, 0, 4.0)
    join(inner, airfoil(VANE), outer, button)


# %%
@contextmanager
def quiet() -> Iterator[None]:
    """Drop what OpenCASCADE writes to standard output past Python."""
    sys.stdout.flush()
    before, nothing = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    try:
        yield
    finally:
        os.dup2(before, 1)
        os.close(before)
        os.close(nothing)


def write(make: Callable[[], None]) -> None:
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    make()
    path = RESULTS / f"{make.__name__}.step"
    with quiet():
        gmsh.write(str(path))
    (solid,) = gmsh.model.getEntities(3)
    print(f"{path.name}: volume {gmsh.model.occ.getMass(*solid):.0f} mm^3")
    gmsh.finalize()


if __name__ == "__main__":
    RESULTS.mkdir(exist_ok=True)
    for make in (fan, turbine, vane):
        write(make)
