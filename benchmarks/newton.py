"""Cost of a Newton iteration, and how it grows with harmonics, modes and contact points.

Run: environment/run python3 benchmarks/newton.py

Motions of a blade tip (benchmarks/tips.py) at 1.8 times the energy of grazing are solved
for from guesses that are off by some per cent. The time of a solution over its Newton steps is the
cost of an iteration: contact forces, linear system, line search. Times are CPU times of one thread,
the smallest of the repeats; exponents are slopes of log(time) over log(size), by least squares over
all sizes and between the two largest.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from tips import blade_tip

from fenics_nnm.continuation.levels import HarmonicBalance, levels
from fenics_nnm.continuation.lift import Lift
from fenics_nnm.nonlinear.condensed import pays
from fenics_nnm.nonlinear.mode import HarmonicEquations
from fenics_nnm.nonlinear.newton import FixedEnergy, Newton, Solution, solve

_GAMMA_RATIO = 1.8
_GAMMA = 0.25 * _GAMMA_RATIO
_REPEATS = 5


@dataclass(frozen=True, slots=True)
class Size:
    """Modes J, contact points n_c, harmonics N, samples m."""

    modes: int
    points: int
    harmonics: int
    samples: int


@dataclass(frozen=True, slots=True)
class Cost:
    """Time of an iteration in ms, of its linear system alone, and what was in contact."""

    size: Size
    iteration: float
    touched: int
    pairs: int
    unknowns: int
    condensed: bool


#: The case of the requirement, and the sweeps about it.
BASE = Size(40, 24, 10, 128)
SWEEPS = {
    "N": [Size(40, 24, N, 256) for N in (5, 10, 20, 40, 80)],
    "J": [Size(J, 24, 10, 128) for J in (20, 40, 80, 160, 320)],
    "n_c": [Size(40, n, 10, 128) for n in (10, 25, 50, 100, 200)],
}


def motion(size: Size) -> tuple[HarmonicEquations, Solution]:
    """The motion of a case, level by level from its first mode alone."""
    model, _ = blade_tip(size.modes, size.points).dimensionless()
    balance = HarmonicBalance(size.harmonics, size.samples)
    lift = Lift(levels(model, balance, mode=0), 0, Newton(iterations=60))
    found = lift.at(_GAMMA_RATIO, None)
    assert found.finest is not None, found.failure
    return lift.levels[-1].equations, found.finest


def guesses(found: Solution) -> Iterator[np.ndarray]:
    """Coefficients off by 2 % of the motion, most in the low harmonics."""
    rng = np.random.default_rng(0)
    for _ in range(_REPEATS):
        part = rng.normal(size=found.q.shape)
        yield found.q * (1 + 0.02 * part)


def cost(size: Size) -> Cost:
    """Smallest time of an iteration among the repeats."""
    equations, found = motion(size)
    times = []
    for q in guesses(found):
        start = time.process_time()
        solved = solve(equations, FixedEnergy(_GAMMA), q, found.omega)
        spent = time.process_time() - start
        if solved.iterations:
            times.append(1e3 * spent / solved.iterations)
    used, points = found.forces.used, found.forces.points
    return Cost(
        size=size,
        iteration=min(times),
        touched=len(np.unique(points[used])),
        pairs=int(np.count_nonzero(used)),
        unknowns=int(np.prod(equations.shape)),
        condensed=pays(equations, found.forces),
    )


def exponent(sizes: Sequence[float], times: Sequence[float]) -> float:
    """Slope of log(time) over log(size)."""
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])


def table(costs: Sequence[Cost]) -> str:
    """Rows of a Markdown table."""
    return "\n".join(
        f"| {c.size.modes} | {c.size.points} | {c.size.harmonics} | {c.size.samples} "
        f"| {c.touched} | {c.pairs} | {c.unknowns} | {'yes' if c.condensed else 'no'} "
        f"| {c.iteration:.2f} |"
        for c in costs
    )


def main() -> None:
    """Measure all cases and print tables and exponents."""
    head = (
        "| J | n_c | N | m | points touched | pairs in contact | unknowns | condensed "
        "| ms an iteration |\n|---|---|---|---|---|---|---|---|---|"
    )
    base = cost(BASE)
    print(f"{head}\n{table([base])}\n", flush=True)
    for name, sizes in SWEEPS.items():
        costs = [cost(size) for size in sizes]
        values = [{"N": s.harmonics, "J": s.modes, "n_c": s.points}[name] for s in sizes]
        times = [c.iteration for c in costs]
        last = exponent(values[-2:], times[-2:])
        print(f"{head}\n{table(costs)}\n")
        print(f"exponent in {name}: {exponent(values, times):.2f}, at the end {last:.2f}\n")
        assert exponent(values, times) < 2, "grows faster than the square"
    assert base.iteration < 10, "more than 10 ms an iteration"


if __name__ == "__main__":
    main()
