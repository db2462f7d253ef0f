# %% [markdown]
# # NASA rotor 37 in the engine: how far does a bending tip really come?
#
# The blade at its design speed of 1800 rad/s, with a gap of 0.1 mm that is left there. Its first
# mode is followed twice: with linear kinematics, by which a blade that bends keeps its length, and
# with those of second order, by which it gets shorter. Beside it the closing of the tip as the
# blade is bent statically, by both and geometrically exactly.
#
# Run with `python3 demos/rotor37/engine.py`; takes less than a minute. The study is engine.toml.
# Results go to demos/rotor37/results/engine.

# %%
import os
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fenics_nnm.backbone.point import VERIFIED
from fenics_nnm.cli import main
from fenics_nnm.mechanics.motion import free_displacement
from fenics_nnm.output.pictures.style import BLACK, BLUE, GREY, RED, label, new_figure, save
from fenics_nnm.results.stored_branch import StoredBranch, read_stored_branch
from fenics_nnm.stages import Stages
from fenics_nnm.structure.mesh_structure import MeshStructure
from fenics_nnm.structure.static_bending import BentModel, radial_closing, statically_bent
from fenics_nnm.study import MeshStudy, read_study

HERE = Path(__file__).parent
STUDY, RESULTS = HERE / "engine.toml", HERE / "results" / "engine"
KINDS = {"linear": "linear kinematics", "second-order": "second order"}
ENERGIES = {"linear": 4.0, "second-order": 2.8}


def branch(kind: str) -> StoredBranch:
    """The first mode with a kind of kinematics, up to the same energy in J with both."""
    settings = [f'body.kinematics="{kind}"', f"continuation.energies.to={ENERGIES[kind]}"]
    chosen = [word for setting in settings for word in ("--set", setting)]
    folder = RESULTS / kind
    study = os.path.relpath(STUDY)
    assert main(["run", *chosen, "--output", str(folder), study]) == 0
    return read_stored_branch(folder / "branch.h5")


def first_contact(blade: StoredBranch) -> float:
    """Energy in J at which the tip reaches the casing, from the motions that do not.

    The largest share of a gap that closes in a period is a polynomial in the amplitude.
    """
    model, phase = blade.header.model, np.linspace(0, 2 * np.pi, 720, endpoint=False)
    amplitude, share = [], []
    for point in blade.points:
        motion = point.motion
        if not motion.contact_fraction:
            moved = free_displacement(model, blade.series, motion, phase)
            amplitude.append(np.sqrt(motion.energy))
            share.append((moved / model.gap).max())
    powers = np.array(amplitude)[:, None] ** np.arange(1, 4)
    series = np.linalg.lstsq(powers, np.array(share), rcond=None)[0]
    roots = np.roots([*series[::-1], -1.0])
    real = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0)]
    return float(min(real, key=lambda root: abs(root - amplitude[-1])) ** 2)


blades = {kind: branch(kind) for kind in KINDS}
contact = {kind: first_contact(blade) for kind, blade in blades.items()}

# %% [markdown]
# The closing of the tip in statics: the blade at speed is bent by a load in the shape of the first
# mode's inertia forces, towards both sides.

# %%
study = read_study(STUDY)
assert isinstance(study, MeshStudy)
linear = MeshStructure(study).linear(MPI.COMM_WORLD, Stages())
model = BentModel(linear.model)
tips = linear.interface.displacements(linear.reduction.shapes[:, :1])[:, :, 0]
largest = np.linalg.norm(tips, axis=1).max()
exact = []
for side in (1, -1):
    wanted = [side * millimetres * 1e-3 / largest for millimetres in (1, 2, 3, 4, 5, 6)]
    for state in statically_bent(linear, 0, wanted):
        q, closing = state.coordinate, radial_closing(linear, state.displacement)
        exact.append((q, closing.max()))
        assert abs(model.closing(q).max() - closing.max()) < 6e-6
coordinates, closings = np.array(sorted(exact)).T

# %% [markdown]
# Both in one picture.

# %%
figure = new_figure(height=3.7, width=8.6)
left, right = figure.subplots(1, 2)
for (kind, name), colour in zip(KINDS.items(), (RED, BLUE), strict=True):
    points = blades[kind].points
    energy = [point.motion.energy for point in points]
    frequency = [point.motion.frequency for point in points]
    status = {point.verdict.status for point in points if point.verdict}
    face = colour if status == {VERIFIED} else "white"
    said = f"{name}: {', '.join(sorted(status))}"
    left.plot(energy, frequency, "o-", color=colour, mfc=face, ms=4, lw=1.3, label=said)
    left.axvline(contact[kind], color=colour, lw=0.8, ls=":")
label(left, "total energy  (J)", "frequency  (Hz)")
left.legend(fontsize=8, loc="upper left", title="dotted: first contact", title_fontsize=8)
sweep = np.linspace(-6.3e-3, 6.3e-3, 127) / largest
for name, rule, colour in (
    (KINDS["linear"], model.linear_closing, RED),
    (KINDS["second-order"], model.closing, BLUE),
):
    curve = [1e6 * rule(q).max() for q in sweep]
    right.plot(1e3 * largest * sweep, curve, color=colour, lw=1.3, label=name)
exact_name = "geometrically exact"
right.plot(1e3 * largest * coordinates, 1e6 * closings, "x", color=BLACK, ms=6, label=exact_name)
gap = 1e6 * linear.model.gap
right.axhspan(gap.min(), gap.max(), color=GREY, alpha=0.4, lw=0, label="gap at speed")
label(right, "motion of the tip  (mm)", "largest radial closing of the tip  (\N{MICRO SIGN}m)")
right.legend(fontsize=8, loc="upper center")
save(figure, RESULTS, "engine", ["png"])

# %% [markdown]
# What linear kinematics get wrong.

# %%
at = 0.6
frequencies = {
    kind: float(
        np.interp(
            at,
            [point.motion.energy for point in blade.points],
            [point.motion.frequency for point in blade.points],
        )
    )
    for kind, blade in blades.items()
}
omega = linear.model.omega[0] / (2 * np.pi)
rise = {kind: frequency / omega - 1 for kind, frequency in frequencies.items()}
late = contact["second-order"] / contact["linear"]
print(
    f"{linear.solid.dofs} degrees of freedom, first frequency {omega:.2f} Hz at speed, gap "
    f"{gap.min():.0f} to {gap.max():.0f} um\n"
    f"first contact: {contact['linear']:.3f} J with linear kinematics, "
    f"{contact['second-order']:.3f} J with second order: {late:.2f} times as much"
)
for kind, name in KINDS.items():
    print(f"frequency at {at} J: {frequencies[kind]:.2f} Hz ({rise[kind]:+.2%}), {name}")
for q, closing in zip(coordinates, closings, strict=True):
    three = 1e6 * np.array([closing, model.linear_closing(q).max(), model.closing(q).max()])
    print("tip {:+.2f} mm: closing {:.0f}, {:.0f}, {:.0f} um".format(1e3 * q * largest, *three))
assert 1.7 < late < 2
assert 5 < rise["linear"] / rise["second-order"] < 9
