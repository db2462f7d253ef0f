# %% [markdown]
# # A rod that meets a rigid obstacle
#
# The first example of Laxalde and Legrand (Comput. Mech. 47, 2011, section 4.1): a clamped-free
# rod whose free end can touch an obstacle. Its first nonlinear mode is known exactly, so this demo
# shows how near the program comes: `paper.toml` is the paper's coarse mesh, `fine.toml` a finer
# one. All natural frequencies of the rod are odd multiples of the first one, the worst case of
# internal resonance; the dents in the curve are such resonances.
#
# Run with `python3 demos/rod/rod.py`; results go to demos/rod/results.

# %%
from pathlib import Path

import numpy as np
from exact_rod import frequency_ratio
from rich.console import Console

from fenics_nnm.output.plots import plot_backbone
from fenics_nnm.progress import progress
from fenics_nnm.run import RunResult, run_study
from fenics_nnm.study import read_study

HERE = Path(__file__).parent


def run(name: str) -> RunResult:
    path = HERE / f"{name}.toml"
    with progress(Console()) as stages:
        return run_study(read_study(path), path.read_text(), HERE / "results" / name, stages=stages)


# %% [markdown]
# The coarse rod has its first frequency at 1297.5 Hz, 0.03 % above sqrt(E / rho) / 4 L.

# %%
print("paper: its five harmonics cannot follow the contact, so points are marked unresolved")
paper = run("paper")
first = paper.summary["linear_frequencies_Hz"][0]
print(f"paper: first linear frequency {first:.2f} Hz; {paper.branch.reason}")
assert abs(first - 1297.5) < 0.05

# %% [markdown]
# The fine rod against the exact mode, whose frequency depends on the energy alone.

# %%
fine = run("fine")
points = fine.branch.points
wanted = np.arange(1.2, 4.01, 0.2)
error = {}
for point in points:
    if np.abs(wanted - point.gamma_ratio).min() < 1e-9:
        exact = float(frequency_ratio(point.gamma_ratio))
        error[point.gamma_ratio] = point.frequency_ratio / exact - 1
        print(
            f"gamma ratio {point.gamma_ratio:.1f}: {point.frequency:.2f} Hz, "
            f"exact {exact * points[0].frequency:.2f} Hz, error {error[point.gamma_ratio]:+.3%}"
        )
within = sum(abs(value) < 5e-3 for value in error.values())
print(f"within 0.5 % of the exact frequency at {within} of {len(wanted)} energies")
assert within >= 12
assert max(map(abs, error.values())) < 0.03

# %% [markdown]
# The frequency follows the exact curve; the Rayleigh frequency sqrt(r) / 2 pi, the paper's
# ordinate, lies far below it, because the virial of the contact force is not zero across a gap.

# %%
gamma = np.linspace(1.02, 4, 200)
linear = fine.summary["linear_frequencies_Hz"][0]
plot_backbone(
    HERE / "results" / "backbone_exact.png",
    points,
    title="Rod against a rigid obstacle: 100 quadratic elements, 40 modes, 20 harmonics",
    linear_frequency=linear,
    curves={"exact": (gamma, frequency_ratio(gamma) * linear)},
)
print(f"picture: {HERE / 'results' / 'backbone_exact.png'}")
