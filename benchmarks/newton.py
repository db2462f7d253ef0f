"""Cost of a Newton iteration, and how it grows with harmonics, modes and contact points.

Run: environment/run python3 benchmarks/newton.py

Motions of a blade tip (benchmarks/tips.py) at 1.8 times the energy of grazing are found level by
level, then solved for again from guesses that are off by some per cent. The time of a solution over
its Newton steps is the cost of an iteration: contact forces, linear system, line search. Times are
CPU times of one thread; exponents are slopes of log(time) over log(size), between neighbours and by
least squares over all sizes. Beside them are those of n_active^2 J N + (J N)^2, with n_active the
pairs of a sample and a point in contact there, or the points that touch at all.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from tips import blade_tip

from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.levels import HarmonicBalance, levels
from fenics_nnm.nonlinear.condensed import pays
from fenics_nnm.nonlinear.conditions import FixedEnergy
from fenics_nnm.nonlinear.equations import HarmonicEquations
from fenics_nnm.nonlinear.newton import Newton, solve
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.nonlinear.unknowns import Unknowns

_GAMMA_RATIO = 1.8
_GAMMA = 0.25 * _GAMMA_RATIO
_REPEATS = 25


@dataclass(frozen=True, slots=True)
class Size:
    """Modes J, contact points n_c, harmonics N, samples m."""

    modes: int
    points: int
    harmonics: int
    samples: int


@dataclass(frozen=True, slots=True)
class Cost:
    """Times of an iteration in ms, seconds to the motion, and what was in contact."""

    size: Size
    iterations: tuple[float, ...]
    levels: float
    touched: int
    pairs: int
    unknowns: int
    condensed: bool

    @property
    def median(self) -> float:
        return float(np.median(self.iterations))

    @property
    def smallest(self) -> float:
        return min(self.iterations)

    def bound(self, active: int) -> float:
        """n_active^2 J N + (J N)^2."""
        both = self.size.modes * self.size.harmonics
        return float(active**2 * both + both**2)


#: The case of the requirement, and the sweeps about it.
BASE = Size(40, 24, 10, 128)
SWEEPS = {
    "N": [Size(40, 24, N, 256) for N in (5, 10, 20, 40, 80)],
    "J": [Size(J, 24, 10, 128) for J in (20, 40, 80, 160, 320)],
    "n_c": [Size(40, n, 10, 128) for n in (10, 25, 50, 100, 200, 400)],
}


def motion(size: Size) -> tuple[HarmonicEquations, Solution]:
    """The motion of a case, level by level from its first mode alone."""
    model, _ = blade_tip(size.modes, size.points).dimensionless()
    balance = HarmonicBalance(size.harmonics, size.samples)
    cascade = Cascade(levels(model, balance, mode=0), 0, Newton(iterations=60))
    found = cascade.at(_GAMMA_RATIO, None)
    assert found.finest is not None, found.failure
    return cascade.levels[-1].equations, found.finest


def guesses(found: Solution) -> Iterator[np.ndarray]:
    """Coefficients off by 2 % of the motion, most in the low harmonics."""
    rng = np.random.default_rng(0)
    for _ in range(_REPEATS):
        part = rng.normal(size=found.q.shape)
        yield found.q * (1 + 0.02 * part)


def cost(size: Size) -> Cost:
    """Times of an iteration, one for each guess."""
    start = time.process_time()
    equations, found = motion(size)
    levels_time = time.process_time() - start
    times = []
    for q in guesses(found):
        start = time.process_time()
        solved = solve(equations, FixedEnergy(_GAMMA), Unknowns.of(q, found.omega))
        times.append(1e3 * (time.process_time() - start) / solved.iterations)
        assert solved.converged, solved.failure
        assert abs(solved.omega / found.omega - 1) < 1e-8, "another motion"
    used, points = found.forces.used, found.forces.points
    return Cost(
        size=size,
        iterations=tuple(times),
        levels=levels_time,
        touched=len(np.unique(points[used])),
        pairs=int(np.count_nonzero(used)),
        unknowns=int(np.prod(equations.shape)),
        condensed=pays(found.forces, found.q.size),
    )


def exponent(sizes: Sequence[float], costs: Sequence[float]) -> float:
    """Slope of log(cost) over log(size)."""
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])


def table(costs: Sequence[Cost]) -> str:
    """A Markdown table of costs."""
    rows = (
        f"| {c.size.modes} | {c.size.points} | {c.size.harmonics} | {c.size.samples} "
        f"| {c.touched} | {c.pairs} | {c.unknowns} | {'yes' if c.condensed else 'no'} "
        f"| {c.median:.2f} | {c.smallest:.2f} | {c.levels:.2f} |"
        for c in costs
    )
    head = (
        "| J | n_c | N | m | points touched | pairs in contact | unknowns | condensed "
        "| median (ms) | smallest (ms) | levels (s) |"
    )
    return "\n".join([head, "|" + "---|" * 11, *rows])


def growth(name: str, costs: Sequence[Cost]) -> str:
    """A Markdown table of exponents, between neighbours and over all sizes."""
    values = [{"N": c.size.harmonics, "J": c.size.modes, "n_c": c.size.points}[name] for c in costs]
    kinds = {
        "median": [c.median for c in costs],
        "smallest": [c.smallest for c in costs],
        "bound, pairs": [c.bound(c.pairs) for c in costs],
        "bound, points": [c.bound(c.touched) for c in costs],
    }
    last = len(values) - 1
    spans = [*((i, i + 1) for i in range(last)), (0, last)]
    rows = [
        f"| {name}, {values[i]} to {values[j]} | "
        + " | ".join(f"{exponent(values[i : j + 1], k[i : j + 1]):.2f}" for k in kinds.values())
        + " |"
        for i, j in spans
    ]
    return "\n".join([f"| exponent | {' | '.join(kinds)} |", "|" + "---|" * 5, *rows])


def main() -> None:
    """Measure all cases and print tables and exponents."""
    cost(BASE)  # what is only paid once
    base = cost(BASE)
    print(f"{table([base])}\n", flush=True)
    overall = {}
    for name, sizes in SWEEPS.items():
        costs = [cost(size) for size in sizes]
        print(f"{table(costs)}\n\n{growth(name, costs)}\n", flush=True)
        values = [{"N": s.harmonics, "J": s.modes, "n_c": s.points}[name] for s in sizes]
        overall[name] = exponent(values, [c.median for c in costs])
    print(f"{time.process_time():.0f} s of CPU time, load {os.getloadavg()[0]:.1f}")
    assert max(overall.values()) < 2, "grows faster than the square"
    assert base.median < 10, "more than 10 ms an iteration"


if __name__ == "__main__":
    main()
