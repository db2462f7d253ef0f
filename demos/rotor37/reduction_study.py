# %% [markdown]
# # NASA rotor 37: what does the reduction cost?
#
# The branch of the blade with the whole finite-element model at every harmonic (full order), and
# with reduced models of more and more modes: how far are the frequencies apart, and does the error
# that each point reports say so beforehand?
#
# Run with `python3 demos/rotor37/reduction_study.py`; takes some minutes.

# %%
import tomllib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fenics_nnm.backbone.follow import Branch
from fenics_nnm.fem.harmonic import HarmonicSolver
from fenics_nnm.structure.analysis import linear_analysis, nonlinear_mode
from fenics_nnm.study import Study, study_from

PATH = Path(__file__).parent / "rotor37.toml"
ENERGIES = {"energies": {"from": 0.7, "to": 2.0, "step": 0.1}}


def study(**sections: dict[str, object]) -> Study:
    """The demo's study with five harmonics, gamma ratio 0.7 to 2, and other keys in sections."""
    values = {**tomllib.loads(PATH.read_text()), "continuation": ENERGIES}
    for section, keys in {"mode": {"harmonics": 5}, **sections}.items():
        values[section] = {**values[section], **keys}
    return study_from(values, PATH)


factorisations: list[str] = []
rows: list[str] = []


def branch(chosen: Study) -> Branch:
    analysis = linear_analysis(chosen, MPI.COMM_SELF)
    if not chosen.full_order:
        return nonlinear_mode(chosen, analysis)
    with HarmonicSolver(analysis, harmonics=chosen.mode.harmonics) as flexibility:
        found = nonlinear_mode(chosen, analysis, flexibility=flexibility)
    factorisations.append(f"{flexibility.factorisations} for {len(found.points)} points")
    return found


def beyond_grazing(reduced: Branch, full: Branch) -> Iterator[tuple[float, float, float, float]]:
    """Gamma ratio, error of the frequency, its prediction and the residual."""
    exact = {point.gamma_ratio: point.motion.frequency for point in full.points}
    for point in reduced.points:
        if point.gamma_ratio > 1.01 and point.gamma_ratio in exact:
            error = point.motion.frequency / exact[point.gamma_ratio] - 1
            expected = point.expected.reduction
            yield point.gamma_ratio, error, expected.frequency, expected.residual


def compare(name: str, reduced: Branch, full: Branch) -> float:
    """Add the worst error and its prediction to the rows; return the worst error."""
    _, error, predicted, residual = np.array(list(beyond_grazing(reduced, full))).T
    factor = predicted / error
    worst = int(np.argmax(np.abs(error)))
    rows.append(
        f"| {name} | {error[worst]:.2e} | {predicted[worst]:.2e} "
        f"| {factor.min():.3f} to {factor.max():.3f} | {residual.max():.1e} |"
    )
    assert 0.1 < factor.min() < factor.max() < 10
    return float(abs(error[worst]))


# %% [markdown]
# Massless boundary: complementarity at the samples, with and without the inertia of the modes left
# out.

# %%
worst = {}
for modes in (10, 20, 40):
    full = branch(study(reduction={"method": "none", "modes": modes}))
    reduced = branch(study(reduction={"method": "massless", "modes": modes}))
    worst[modes] = compare(f"massless boundary, J = {modes}", reduced, full)
rate = float(np.log(worst[10] / worst[40]) / np.log(4))
assert worst[40] < 1e-3
assert rate > 1.5
massless = reduced

# %% [markdown]
# Mass at the contact points: Craig-Bampton as in the paper, and full order, by the augmented
# Lagrangian. The number of modes that stay explicit at full order is of no consequence.

# %%
law = {"law": "augmented-lagrangian"}
full = branch(study(reduction={"method": "none", "modes": 40}, contact=law))
other = branch(study(reduction={"method": "none", "modes": 10}, contact=law))
same = max(
    abs(a.motion.frequency / b.motion.frequency - 1)
    for a, b in zip(full.points, other.points, strict=True)
)
assert same < 1e-9
for interface in ("all", "contact"):
    for modes in (10, 20, 40):
        chosen = {"method": "craig-bampton", "modes": modes, "interface": interface}
        reduced = branch(study(reduction=chosen, contact=law))
        compare(f"Craig-Bampton, {interface} directions, J = {modes}", reduced, full)

# %% [markdown]
# Both treatments of the contact points are the same structure; their motions differ by what the
# force does above the fifth harmonic.

# %%
apart = max(
    abs(a.frequency_ratio / b.frequency_ratio - 1)
    for a, b in zip(massless.points, reduced.points, strict=True)
)
assert apart < 5e-3

# %%
print(
    "docs: reduction\n| reduced model | worst relative error of the frequency "
    "| predicted error (`reduction_error`) at the point of the worst error "
    "| predicted error / true error, range over all points | largest `reduction_residual` |\n"
    "|---|---|---|---|---|"
)
print("\n".join(rows))
print(
    f"\ndocs: full_order\nThe frequency error of the massless boundary falls like J^-{rate:.1f}. "
    f"Two runs at full order have mass at the contact points, with 40 and with 10 explicit modes "
    f"(modes whose modal coordinates are unknowns of the equations). The relative difference of "
    f"their frequencies is at most {same:.1e}. The number of matrix factorisations is "
    f"{factorisations[3]} with 40 explicit modes, and {factorisations[4]} with 10 explicit modes. "
    f"With J = 40, the frequencies of the massless boundary and of "
    f"Craig-Bampton (contact directions) differ by at most {apart:.3%}. This difference comes from "
    f"harmonics of the contact force above the fifth.\n"
)
