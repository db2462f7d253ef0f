# %% [markdown]
# # Many contact points at once, by two methods
#
# A dumbbell in plane stress (dumbbell.py draws it) lands flat on a straight line: all 41 vertices
# of its right face touch at once. Its axial mode is followed by both methods of the program:
#
# * `plate.toml`: massless contact points, complementarity at every sample;
# * `craig_bampton.toml`: contact points with mass, augmented Lagrangian.
#
# Two questions: is it the same mode, and is the contact pressure free of oscillation from point to
# point? pressure.py says what is measured. Run with `python3 demos/plate/plate.py`; takes one to
# two minutes, results go to demos/plate/results.

# %%
from pathlib import Path

import numpy as np
from dumbbell import write_mesh
from mpi4py import MPI
from pictures import draw_comparison, draw_pressed, draw_pressure
from pressure import ContactLine, corner_jump, zigzag
from rich.console import Console

from fenics_nnm.backbone.follow import Branch
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.progress import progress
from fenics_nnm.run import run_study
from fenics_nnm.structure.analysis import harmonic_balance, linear_analysis, nonlinear_mode
from fenics_nnm.study import Study, read_study

HERE = Path(__file__).parent
RESULTS = HERE / "results"
STUDIES = {"massless": HERE / "plate.toml", "Craig-Bampton": HERE / "craig_bampton.toml"}
RATIOS = np.linspace(0.7, 2.0, 14)


def run(path: Path) -> Branch:
    with progress(Console()) as stages:
        study = read_study(path)
        return run_study(study, path.read_text(), RESULTS / path.stem, stages=stages).branch


def coarser(study: Study, harmonics: int) -> Branch:
    mode = study.mode.model_copy(update={"harmonics": harmonics})
    analysis = linear_analysis(study, MPI.COMM_SELF)
    return nonlinear_mode(study.model_copy(update={"mode": mode}), analysis)


def at(branch: Branch, ratio: float) -> BranchPoint:
    return min(branch.points, key=lambda point: abs(point.gamma_ratio - ratio))


write_mesh(RESULTS / "dumbbell.msh")
linear = linear_analysis(read_study(STUDIES["massless"]), MPI.COMM_SELF)
line = ContactLine.of(linear.interface)
series = harmonic_balance(read_study(STUDIES["massless"])).series
branches = {}
for method, path in STUDIES.items():
    branches[method, 5] = coarser(read_study(path), 5)
    branches[method, 10] = run(path)
assert all(branch.complete for branch in branches.values())

# %% [markdown]
# The axial mode is the one that moves the face most evenly.

# %%
evenness = np.abs(linear.model.Phi.mean(0)) / np.sqrt((linear.model.Phi**2).mean(0))
print(f"mode 3: {linear.modes.frequencies[2]:.1f} Hz, mean over rms of the face {evenness[2]:.4f}")
assert evenness[2] > 0.99 > 0.1 > evenness[:2].max()

# %% [markdown]
# ## The same mode
#
# The methods differ in how the mass near the contact takes part. Where they are farthest apart, at
# 1.5, the Craig-Bampton motion has 1.5 % of its kinetic energy in mode 9 in harmonic 5, 4 % off
# resonance, and the massless one 0.3 %.

# %%
found = {
    key: np.array([at(branch, ratio).frequency_ratio for ratio in RATIOS])
    for key, branch in branches.items()
}
print("docs: plate_methods\n| gamma ratio ", end="")
for harmonics in (5, 10):
    names = ("massless", "Craig-Bampton", "relative difference")
    print("".join(f"| {name}, N = {harmonics} " for name in names), end="")
print("|\n|---|---|---|---|---|---|---|")
for index in np.flatnonzero(RATIOS > 1.05):
    print(f"| {RATIOS[index]:.1f} ", end="")
    for harmonics in (5, 10):
        massless, craig_bampton = (found[method, harmonics][index] for method in STUDIES)
        apart = craig_bampton / massless - 1
        print(f"| {massless:.5f} | {craig_bampton:.5f} | {apart:+.2%} ", end="")
    print("|")
print("\ndocs: plate_apart")
for harmonics in (5, 10):
    apart = np.abs(found["Craig-Bampton", harmonics] / found["massless", harmonics] - 1)
    print(
        f"With N = {harmonics}, the relative difference of the two methods has a median of "
        f"{np.median(apart[RATIOS > 1.05]):.2%} and a maximum of {apart.max():.2%}. At gamma ratio "
        f"2.0, this difference is {apart[-1]:.2%}."
    )
    assert apart.max() < 6e-3
    assert apart[-1] < (3e-3 if harmonics == 5 else 1e-3)
print()
assert {point.status for point in branches["massless", 10].points} <= {"verified", "converged"}
draw_comparison(RESULTS / "comparison.png", RATIOS, found)

# %% [markdown]
# ## The pressure
#
# What acts on the motion are the harmonics 0 to N of the pressure. With massless points the
# pressure at each single sample is smooth too; with points that carry mass it is not determined
# there.

# %%
phase = 2 * np.pi * np.arange(65) / 128
print(
    "docs: plate_pressure\n| method (N = 10) | contact points closed at once "
    "| oscillation at instants of contact | oscillation in the mean "
    "| oscillation at single samples | corner jump |\n|---|---|---|---|---|---|"
)
for method in STUDIES:
    worst = {"acting": 0.0, "mean": 0.0, "sample": 0.0, "corner": 0.0}
    for point in branches[method, 10].points:
        if point.gamma_ratio < 1.05:
            continue
        samples, mean = line.at_samples(point), line.mean(point, series)
        acting = line.acting(point, series, phase)
        peak = acting.mean(1).max()
        contact = acting[acting.mean(1) > peak / 2]
        now = {
            "acting": max(zigzag(line.y, p) for p in contact) / peak,
            "mean": zigzag(line.y, mean) / mean.mean(),
            "sample": max(zigzag(line.y, p) for p in samples) / samples.mean(1).max(),
            "corner": max(corner_jump(line.y, p) for p in contact) / peak,
        }
        worst = {key: max(value, now[key]) for key, value in worst.items()}
    together = int((at(branches[method, 10], 2.0).motion.force > 0).sum(axis=1).max())
    print(
        f"| {method} | {together} | {worst['acting']:.2%} | {worst['mean']:.2%} "
        f"| {worst['sample']:.2%} | {worst['corner']:.1%} |"
    )
    assert together >= 30
    assert worst["acting"] < 0.02
    assert worst["mean"] < 0.02
    assert worst["corner"] < 0.06
    assert worst["sample"] < 1e-3 or method == "Craig-Bampton"

# %%
instants, means = {}, {}
for method in STUDIES:
    point = at(branches[method, 10], 2.0)
    shown = np.array([0.0, 0.01, 0.02, 0.03])
    pressures = line.acting(point, series, 2 * np.pi * shown)
    instants[method] = dict(zip(shown, pressures, strict=True))
    means[method] = {
        ratio: line.mean(at(branches[method, 10], ratio), series) for ratio in (1.3, 2.0)
    }
draw_pressure(RESULTS / "pressure.png", line.y, 2.0, instants, means)

# %% [markdown]
# ## Elements
#
# The static pressure of the flat face, moved by the same amount everywhere, shows what the elements
# do. Linear ones are smooth, on equal spacing and on one that varies by a factor 4.7. Quadratic
# ones are not: contact points are vertices, and point forces at the vertices are not the forces of
# a pressure on quadratic edges. That is why the studies have `degree = 1`. Without tributary areas
# the corners would stand out by half.

# %%
print(
    "\ndocs: plate_elements\n| degree, shape and spacing of the elements "
    "| oscillation of the pressure | corner jump | corner jump with equal areas of all points |\n"
    "|---|---|---|---|"
)
curves, jumps = {}, {}
study = read_study(STUDIES["massless"])
for degree in (1, 2):
    body = study.body.model_copy(update={"degree": degree})
    for cells, bump in (("quad", 1.0), ("quad", 0.2), ("triangle", 1.0), ("triangle", 0.2)):
        write_mesh(RESULTS / "element.msh", cells=cells, bump=bump)
        mesh = study.mesh.model_copy(update={"file": RESULTS / "element.msh"})
        changed = study.model_copy(update={"body": body, "mesh": mesh})
        analysis = linear_analysis(changed, MPI.COMM_SELF)
        face = ContactLine.of(analysis.interface)
        pressure = face.pressed(analysis.model)
        mean = pressure.mean()
        oscillation = zigzag(face.y, pressure) / mean
        jump = corner_jump(face.y, pressure) / mean
        force = pressure * face.areas
        ignored = corner_jump(face.y, force) / force.mean()
        name = f"degree {degree}, {cells}s, {'equal' if bump == 1 else 'graded'}"
        curves[name] = (face.y, pressure)
        jumps[degree, cells, bump] = (oscillation, jump, ignored)
        print(f"| {name} | {oscillation:.2%} | {jump:.1%} | {ignored:.1%} |")
print()
linear_worst = np.max([values for key, values in jumps.items() if key[0] == 1], axis=0)
assert linear_worst[0] < 2e-3
assert linear_worst[1] < 0.06
assert min(values[2] for values in jumps.values()) > 0.12
assert jumps[2, "quad", 1.0][1] > 0.1
assert jumps[2, "triangle", 1.0][0] > 0.01
draw_pressed(RESULTS / "pressed.png", curves)
for name in ("comparison", "pressure", "pressed"):
    print(f"picture: {RESULTS / name}.png")
