# %% [markdown]
# # NASA rotor 37: a compressor blade that rubs its casing
#
# The blade is lofted through NASA's section table, clamped at the hub, and meets a rigid casing in
# the radial direction at 24 points of its tip. The study is rotor37.toml; how fine the mesh must
# be is measured by mesh_study.py.
#
# As in the paper the blade stands still, and its kinematics are linear. A real blade gets shorter
# as it bends: where contact begins here, at some 6 mm of tip motion, its tip has come 68 um nearer
# to the casing when it bends to one side and 197 um to the other, not 346 and 293 um, and does not
# reach it. The blade at speed, with kinematics of second order, is engine.py.
#
# Run with `python3 demos/rotor37/rotor37.py`; results go to demos/rotor37/results. Open
# results/fields/motion_1.8.pvd in ParaView, warp by displacement, and play the period. The pictures
# are discussed in docs/paper_figures.md.

# %%
from pathlib import Path

import numpy as np
from rich.console import Console

from fenics_nnm.output.gallery import draw, make_pictures
from fenics_nnm.output.motion_measures import first_torsion_mode, kinetic_shares, section_motion
from fenics_nnm.output.pictures.body import Row, Shape, plan_shapes
from fenics_nnm.output.pictures.scene import View
from fenics_nnm.progress import progress
from fenics_nnm.results.stored_branch import read_stored_branch
from fenics_nnm.run import run_study
from fenics_nnm.study import read_study

HERE = Path(__file__).parent
RESULTS = HERE / "results"
path = HERE / "rotor37.toml"
with progress(Console()) as stages:
    result = run_study(read_study(path), path.read_text(), RESULTS, stages=stages)
points = result.branch.points
print(
    f"{result.summary['dofs']} degrees of freedom, first frequency "
    f"{result.summary['linear_frequencies_Hz'][0]:.2f} Hz; {result.branch.reason}"
)

# %% [markdown]
# Contact begins where the first mode moves outwards most: at the leading edge.

# %%
blade = read_stored_branch(RESULTS / "branch.h5")
axial = blade.contact_points[:, 0]
touching = next(
    point for point in points if point.motion.force.max() > 1e-6 * points[-1].motion.force.max()
)
first = int(np.argmax(touching.motion.force.max(axis=0)))
chord_position = (axial[first] - axial.min()) / np.ptp(axial)
print(f"contact begins at {chord_position:.0%} of the axial chord (0 % is the leading edge)")
assert min(chord_position, 1 - chord_position) < 0.05

# %% [markdown]
# The frequency rises with the energy as more of the tip rubs for longer.

# %%
for point in points:
    count = np.count_nonzero(point.motion.force.max(axis=0))
    print(
        f"gamma ratio {point.gamma_ratio:.2f}: {point.motion.frequency:.2f} Hz, in contact "
        f"{point.motion.contact_fraction:.0%} of the period, at {count} points"
    )
contacting = [point.motion.frequency for point in points if point.gamma_ratio >= 1]
assert np.all(np.diff(contacting) > 0)
assert result.branch.complete

# %% [markdown]
# The first torsion mode is the lowest linear mode that turns the tip section about the span more
# than it moves it otherwise. How much of it is in the nonlinear mode, and how does the tip turn?

# %%
span, tip = blade.contact_axis, blade.contact_nodes
torsion = first_torsion_mode(blade)
torsion_frequency = blade.header.model.omega[torsion] / (2 * np.pi)
for mode in range(3):
    turning = section_motion(blade.nodes[tip], blade.shapes[mode, tip], span).rotation_share
    print(f"mode {mode + 1}: rotation is {turning:.0%} of the tip's mean square motion")
print(f"first torsion mode: number {torsion + 1}, {torsion_frequency:.1f} Hz")
assert torsion == 1

ENERGIES = (0.7, 1.8, 3.0)
shares, amplitudes, turns = {}, {}, {}
for ratio in ENERGIES:
    point = blade.point(ratio)
    shares[ratio] = kinetic_shares(blade.series, point.motion.q)[torsion]
    phase = np.linspace(0, np.pi, 181)
    largest = np.linalg.norm(blade.displacement(point, phase), axis=2).max(axis=1).argmax()
    for instant in {0, int(largest)}:
        q = blade.coordinates(point, phase[[instant]])[0]
        moved = blade.displacement(point, phase[[instant]], tip)[0]
        section = section_motion(blade.nodes[tip], moved, span)
        turn = np.degrees(section.angle) / np.linalg.norm(section.translation) / 1e3
        if instant == 0:
            amplitudes[ratio], turns[ratio] = q[torsion] / q[0], turn
        print(
            f"gamma ratio {ratio:.1f}, t/T = {phase[instant] / 2 / np.pi:.2f}: torsion mode has "
            f"{shares[ratio]:.4%} of the kinetic energy and {q[torsion] / q[0]:+.2%} of the first "
            f"mode's amplitude; the tip turns by {abs(turn):.3f} degrees a millimetre"
        )
assert shares[0.7] < 1e-12
assert 1e-6 < shares[1.8] < 1e-4 < shares[3.0] < 1e-3
assert 0.005 < abs(amplitudes[3.0]) < 0.03
assert abs(turns[3.0]) < 0.9 * abs(turns[0.7])

# %% [markdown]
# Deformed blades in the middle of the contact, and what contact adds to the linear mode: above all
# the bending of the corner that rubs.

# %%
whole, added = [], []
for ratio in ENERGIES:
    point = blade.point(ratio)
    displacement = blade.displacement(point, np.zeros(1))[0]
    in_mode = np.diag(blade.coordinates(point, np.zeros(1))[0])  # a row a mode
    by_contact = displacement - blade.modal_field(in_mode[0])
    largest, by_torsion = (
        1e3 * np.linalg.norm(field, axis=1).max()
        for field in (by_contact, blade.modal_field(in_mode[torsion]))
    )
    print(
        f"gamma ratio {ratio:.1f}: contact adds {largest:.2f} mm, torsion mode {by_torsion:.2f} mm"
    )
    name = f"gamma ratio {ratio:g}"
    whole.append(
        Shape(
            f"{name}: {point.motion.frequency:.2f} Hz\n"
            f"(Rayleigh {point.motion.rayleigh_frequency:.2f} Hz)",
            displacement,
        )
    )
    added.append(
        Shape(
            f"torsion: {shares[ratio]:.4%} of energy,\n{amplitudes[ratio]:+.2%} of amplitude",
            by_contact,
        )
    )
compared = plan_shapes(
    blade,
    [Row("displacement", 1.5, whole), Row("part not in the linear mode", 5, added)],
    View(elevation=18, azimuth=-65),
    name="contact_shapes",
    title="Motion in the middle of the contact, and what contact adds",
    caption="NASA rotor 37 blade, nonlinear mode 1 in the middle of the contact: above the motion, "
    "below the same without the followed linear mode. Torsion mode: "
    f"mode {torsion + 1}, {torsion_frequency:.1f} Hz; its amplitude is that over the "
    "first mode's, its energy the share of the kinetic energy.",
)
draw([compared], RESULTS)
pictures = make_pictures(RESULTS, RESULTS / "pictures", formats=["png"])
print(f"{len(pictures)} pictures in {RESULTS}/pictures, and {RESULTS}/contact_shapes.png")
