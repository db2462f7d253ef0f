"""Cost of a point of a response through contact beside that of a backbone of the same size.

    environment/run python3 benchmarks/response.py

A blade tip (benchmarks/tips.py) with 5 % damping: the backbone at 16 energies from 1.05 to 1.8
times grazing by energy levels, and the response to a force on the followed mode that passes its gap
by half at resonance. Times are CPU seconds of one thread for each point with contact, without and
with the check in time.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import time
from collections.abc import Callable

import numpy as np
from backbone import measured
from tips import blade_tip

from fenics_nnm.backbone.follow import EnergyContinuation
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.response.curve import Curve, curve
from fenics_nnm.response.judge import Unjudged, judge_of
from fenics_nnm.response.structure import Drive, DrivenStructure

#: Modes J, contact points n_c, harmonics N, samples m.
CASES = ((6, 4, 6, 48), (6, 4, 10, 80), (10, 8, 10, 80), (20, 12, 10, 80))
_RATIO = 0.05
_HEAD = (
    "| J | n_c | N | points | in contact | verified | backbone (ms) | response (ms) | ratio "
    "| backbone, checked (ms) | response, checked (ms) | ratio |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|"
)


def driven(model: ReducedModel) -> DrivenStructure:
    """The tip under a force on its first mode that would move it by 1.5 gaps."""
    shape = np.zeros((1, model.modes))
    shape[0, 0] = 1.0
    force = 1.5 * 2 * _RATIO * model.omega[0] ** 2 * float(model.gap.min())
    linear = RatedPart(model.omega, np.diag(2 * _RATIO * model.omega))
    return DrivenStructure.of(model, linear, Drive.simple(shape, np.array([force + 0j])))


def timed(action: Callable[[], Curve]) -> tuple[float, Curve]:
    """CPU seconds of a curve, and the curve."""
    start = time.process_time()
    found = action()
    return time.process_time() - start, found


def row(modes: int, points: int, harmonics: int, samples: int) -> str:
    """What one case costs."""
    model, series = blade_tip(modes, points), FourierSeries(harmonics, samples)
    energies = EnergyContinuation(1.05, 1.8, 0.05)
    whole = measured(model, HarmonicBalance(harmonics, samples), energies)
    count = len(whole.branch.points)
    structure = driven(model)
    frequencies = np.linspace(0.7, 1.5, 9) * model.omega[0] / (2 * np.pi)
    costs = []
    for judge in (Unjudged(), judge_of(structure.mechanics)):
        spent, found = timed(lambda judge=judge: curve(structure, series, frequencies, judge=judge))
        touching = [p for p in found.points if p.displacements.contact.any()]
        costs.append(1e3 * spent / len(touching))
    assert not found.reason, found.reason
    verified = sum(point.status == "verified" for point in touching)
    own = [1e3 * whole.found / count, 1e3 * whole.whole / count]
    return (
        f"| {modes} | {points} | {harmonics} | {len(found.points)} | {len(touching)} | {verified} "
        f"| {own[0]:.0f} | {costs[0]:.0f} | {costs[0] / own[0]:.1f} "
        f"| {own[1]:.0f} | {costs[1]:.0f} | {costs[1] / own[1]:.1f} |"
    )


def main() -> None:
    print(_HEAD)
    for case in CASES:
        print(row(*case), flush=True)


if __name__ == "__main__":
    main()
