# %% [markdown]
# # The rod that is pressed against its obstacle
#
# With a negative gap the rod is under compression at rest, and small motions are those of the rod
# clamped at both ends: omega = pi c / L. They end where the force at the tip comes to zero; beyond,
# the tip lifts off and the frequency falls, towards the 2/3 pi c / L of the rod without gap. The
# exact motions are square waves again, with the period T = 3 - 1 / sqrt(1 + 2 E) in units of L/c at
# the energy E from the state of rest, in units of EA gap^2 / L.
#
# Natural frequencies of the rod at rest are multiples of the first, so there is an internal
# resonance next to any motion. Points that are not inside one are compared.
#
# Run with `python3 demos/rod/preload.py`; takes a minute or two.

# %%
import tomllib
from pathlib import Path

import numpy as np
from exact_rod import pressed_period
from mpi4py import MPI

from fenics_nnm.backbone.point import CONVERGED, VERIFIED, BranchPoint
from fenics_nnm.structure.analysis import linear_analysis, nonlinear_mode
from fenics_nnm.study import study_from

FINE = Path(__file__).parent / "fine.toml"
LENGTH, AREA, YOUNG, DENSITY, GAP = 1.0, 9e-4, 2.1e11, 7800.0, -1e-3
SPEED = np.sqrt(YOUNG / DENSITY)
ENERGY = YOUNG * AREA * GAP**2 / LENGTH


def points(modes: int, harmonics: int, stop: float) -> tuple[BranchPoint, ...]:
    """The branch from below the first lift-off."""
    values = tomllib.loads(FINE.read_text())
    values["contact"]["gap"] = GAP
    values["reduction"] = {"modes": modes}
    values["mode"] = {"harmonics": harmonics, "samples": 256}
    ratios = [0.5, 1.0, *(float(ratio) for ratio in np.geomspace(1.2, stop, 14))]
    energies = {"from": 0.5, "to": ratios[-1], "step": 100.0}
    values["continuation"] = {"energies": energies, "report_at": ratios, "shooting": False}
    study = study_from(values, FINE)
    return nonlinear_mode(study, linear_analysis(study, MPI.COMM_SELF)).points


if __name__ == "__main__":
    held, before, errors, marked = SPEED / (2 * LENGTH), [], [], 0
    for point in points(20, 10, 60.0):
        ratio = f"gamma ratio {point.gamma_ratio:4.1f}"
        if point.gamma_ratio <= 1:
            error = point.motion.frequency / held - 1
            before.append(abs(error))
            print(f"{ratio}: {error:+.1e} off the rod clamped at both ends")
            assert abs(error) < 1e-4 and point.status == VERIFIED
            continue
        exact = SPEED / LENGTH / float(pressed_period(point.motion.energy / ENERGY))
        error = point.motion.frequency / exact - 1
        print(
            f"{ratio}: {point.motion.frequency / held:.4f} of it, exact {exact / held:.4f}, "
            f"{error:+.1e} off  {point.status} {point.resonance}"
        )
        if point.status in (VERIFIED, CONVERGED):
            errors.append(abs(error))
        else:
            marked += 1
    worst, median = max(errors), np.median(errors)
    print(
        "docs: preload\nUp to lift-off, the frequency agrees with the frequency of the rod clamped "
        f"at both ends; the largest relative difference is {max(before):.1e}. Beyond lift-off, up "
        f"to gamma ratio 60, the number of points is {len(errors) + marked}, and the number of "
        f"unmarked points is {len(errors)}. The largest relative frequency error of these unmarked "
        f"points is {worst:.1e}, and the median error is {median:.1e}.\n"
    )
    assert len(errors) >= 4 and worst < 1e-2 and median < 1e-3
