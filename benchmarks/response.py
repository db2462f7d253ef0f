"""Cost of a point of a response through contact beside that of a backbone of the same size.

    environment/run python3 benchmarks/response.py
    environment/run python3 benchmarks/response.py --masters 2 --pairs 3 --only 2 --profile

A blade tip (benchmarks/tips.py) with 5 % damping, with linear kinematics and with second-order ones
of some masters: the backbone at 16 energies from 1.05 to 1.8 times grazing by energy levels, and
the response to a force on the followed mode that passes its gap by half at resonance. Times are CPU
milliseconds of one thread for a point with contact, without and with the check in time: the least
of several pairs, of which ratios are medians. Points without contact are left out: with linear
kinematics they are solved at once, and with second-order ones, where they are nonlinear motions
themselves, they cost less.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import argparse
import cProfile
import itertools
import pstats
import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from backbone import measured
from tips import bent_tip, blade_tip

from fenics_nnm.backbone.follow import EnergyContinuation
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.response.curve import curve
from fenics_nnm.response.judge import Unjudged, judge_of
from fenics_nnm.response.structure import Drive, DrivenStructure

#: Modes J, contact points n_c, harmonics N, samples m.
CASES = ((6, 4, 6, 48), (6, 4, 10, 80), (10, 8, 10, 80), (20, 12, 10, 80))

#: Masters of each table; none are linear kinematics.
MASTERS = (0, 1, 2)

_RATIO = 0.05
_HEAD = (
    "| masters | J | n_c | N | points | in contact | verified | backbone (ms) | response (ms) "
    "| ratio | backbone, checked (ms) | response, checked (ms) | ratio |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)


@dataclass(frozen=True, slots=True)
class Spent:
    """CPU milliseconds a point, without and with the check in time."""

    plain: float
    checked: float


@dataclass(slots=True)
class Clock:
    """CPU seconds between points of a curve."""

    spent: list[float]
    last: float

    @classmethod
    def started(cls) -> Clock:
        """From now on."""
        return cls([], time.process_time())

    def noted(self, part: float) -> None:
        """A point was found."""
        now = time.process_time()
        self.spent.append(now - self.last)
        self.last = now


def driven(model: ReducedModel) -> DrivenStructure:
    """The tip under a force on its first mode that would move it by 1.5 gaps.

    What second order takes from the way to the casing is added to the force.
    """
    shape = np.zeros((1, model.modes))
    shape[0, 0] = 1.0
    way = 1.5 if not len(model.kinematics.masters) else 1.9
    force = way * 2 * _RATIO * model.omega[0] ** 2 * float(model.gap.min())
    linear = RatedPart(model.omega, np.diag(2 * _RATIO * model.omega))
    return DrivenStructure.of(model, linear, Drive.simple(shape, np.array([force + 0j])))


def of_backbone(model: ReducedModel, harmonics: int, samples: int) -> Spent:
    """What a point of the backbone costs."""
    energies = EnergyContinuation(1.05, 1.8, 0.05)
    whole = measured(model, HarmonicBalance(harmonics, samples), energies)
    count = len(whole.branch.points)
    assert count, whole.branch.reason
    return Spent(1e3 * whole.found / count, 1e3 * whole.whole / count)


def of_response(
    structure: DrivenStructure, series: FourierSeries, profiler: cProfile.Profile | None
) -> tuple[Spent, str]:
    """What a point of the response with contact costs, and how many there are and are verified."""
    frequencies = np.linspace(0.7, 1.5, 9) * structure.model.omega[0] / (2 * np.pi)
    costs = []
    if profiler:
        profiler.enable()
    for judge in (Unjudged(), judge_of(structure.mechanics)):
        clock = Clock.started()
        found = curve(structure, series, frequencies, judge=judge, on_progress=clock.noted)
        assert not found.reason, found.reason
        assert len(found.points) == len(clock.spent)
        touching = [p.displacements.contact.any() for p in found.points]
        costs.append(1e3 * float(np.mean(np.array(clock.spent)[touching])))
    if profiler:
        profiler.disable()
    verified = sum(p.status == "verified" for p in itertools.compress(found.points, touching))
    return Spent(*costs), f"{len(found.points)} | {sum(touching)} | {verified}"


def row(
    masters: int, case: Sequence[int], pairs: int, profiler: cProfile.Profile | None = None
) -> str:
    """What one case costs."""
    modes, points, harmonics, samples = case
    model = bent_tip(modes, points, masters) if masters else blade_tip(modes, points)
    structure, series, found = driven(model), FourierSeries(harmonics, samples), []
    for _ in range(pairs):
        own = of_backbone(model, harmonics, samples)
        other, counts = of_response(structure, series, profiler)
        found.append((own, other))
    costs = []
    for name in ("plain", "checked"):
        each = [(getattr(own, name), getattr(other, name)) for own, other in found]
        least = f"{min(own for own, _ in each):.0f} | {min(other for _, other in each):.0f}"
        costs.append(f"{least} | {statistics.median(other / own for own, other in each):.1f}")
    return f"| {masters} | {modes} | {points} | {harmonics} | {counts} | {' | '.join(costs)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--masters", type=int, help="number of masters, 0 for linear kinematics")
    parser.add_argument("--only", type=int, help="number of the case, from 0")
    parser.add_argument("--pairs", type=int, default=3, help="how often each case is measured")
    parser.add_argument("--profile", action="store_true", help="profile the response, too")
    chosen = parser.parse_args()
    cases = CASES if chosen.only is None else CASES[chosen.only :][:1]
    profiler = cProfile.Profile(time.process_time) if chosen.profile else None
    print(_HEAD)
    for masters in MASTERS if chosen.masters is None else (chosen.masters,):
        for case in cases:
            print(row(masters, case, chosen.pairs, profiler), flush=True)
    if profiler:
        for order in ("cumulative", "tottime"):
            pstats.Stats(profiler).strip_dirs().sort_stats(order).print_stats(45)


if __name__ == "__main__":
    main()
