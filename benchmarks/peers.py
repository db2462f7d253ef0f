"""Side by side with what a user would take instead, on the same reduced matrices.

Run: environment/run python3 benchmarks/peers.py [--peers FOLDER]

1. Harmonic balance: package `harmonicbalance` from PyPI (MIT), `fouriersolve_ode`. It does not know
   unilateral contact, so both solve for the same penalty springs, at the same frequency, from the
   same guess, with the same N harmonics and 4 N + 1 samples: the same discrete equations, to the
   same solution. It is no dependency of this project. To have it,
   `python3 -m venv --system-site-packages FOLDER`, `FOLDER/bin/pip install harmonicbalance==0.2.0`,
   and give the FOLDER; without it this part is left out, which is said.
2. Shooting with SciPy: `solve_ivp` (DOP853) over half a period and `fsolve`, for the motion of the
   energy of a point of a branch under one massless contact point, against `shoot` from the same
   guess; and the time of a whole point of the branch beside it.

Times are CPU times of one thread, the smallest of the repeats, all in one run.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import contextlib
import io
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve
from tips import blade_tip

from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.penalty_law import AugmentedLagrangian
from fenics_nnm.nonlinear.conditions import FixedFrequency
from fenics_nnm.nonlinear.equations import harmonic_equations
from fenics_nnm.nonlinear.newton import Newton, solve
from fenics_nnm.nonlinear.unknowns import Unknowns
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.shooting import OrbitGuess, shoot

_STIFFNESS = 4.0
_OMEGA = 1.1
_REPEATS = 3


def timed(work: Callable[[], Any], repeats: int = _REPEATS) -> tuple[float, Any]:
    """Smallest CPU time in s, and the result."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        result = work()
        times.append(time.process_time() - start)
    return min(times), result


def amplitudes(rows: np.ndarray, harmonics: int) -> np.ndarray:
    """Amplitude of each harmonic and mode, which a shift in time leaves as it is."""
    cosine, sine = rows[1 : harmonics + 1], rows[harmonics + 1 :]
    return np.vstack([np.abs(rows[:1]), np.hypot(cosine, sine)])


def against_harmonicbalance(modes: int, points: int, harmonics: int) -> str:
    """Row of the table: both times, their ratio, and how far the solutions are apart."""
    from harmonicbalance.fourier import Fourier
    from harmonicbalance.solvers import fouriersolve_ode

    tip = blade_tip(modes, points)
    model = ReducedModel(tip.omega, tip.Phi, np.zeros_like(tip.R), tip.gap, contact=MASSIVE)
    series = FourierSeries(harmonics, 4 * harmonics + 1)
    stiffness = np.full((len(series.phase), points), _STIFFNESS / points)
    law = AugmentedLagrangian(model.gap, stiffness, np.zeros_like(stiffness))
    equations = harmonic_equations(model, series, law)
    guess = np.zeros(equations.shape)
    guess[1, 0] = 1.6
    fixed, options = FixedFrequency(_OMEGA), Newton(iterations=100)
    near = solve(equations, fixed, Unknowns.of(guess, _OMEGA), options=options)
    assert near.converged and near.energies.contact, near.failure
    rng = np.random.default_rng(0)
    start = near.q * (1 + 0.02 * rng.normal(size=near.q.shape))
    ours, found = timed(lambda: solve(equations, fixed, Unknowns.of(start, _OMEGA)))
    assert found.converged and found.energies.contact

    def ode(state: list[Any]) -> list[Any]:
        x, v = state[:modes], state[modes:]
        moved = [sum(p * each for p, each in zip(row, x, strict=True)) for row in model.Phi]
        pushed = [
            (w - g).nonlinearity(lambda over: _STIFFNESS / points * np.maximum(over, 0.0))
            for w, g in zip(moved, model.gap, strict=True)
        ]
        pull = [sum(p * f for p, f in zip(row, pushed, strict=True)) for row in model.Phi.T]
        rates = [-(w**2) * each - f for w, each, f in zip(model.omega, x, pull, strict=True)]
        return [*v, *rates]

    def series_of(column: np.ndarray) -> Any:
        return Fourier.from_coeffs(column, _OMEGA)

    displacements = [series_of(column) for column in start.T]
    velocities = [each.dt() for each in displacements]

    def theirs() -> Any:
        with contextlib.redirect_stdout(io.StringIO()):
            return fouriersolve_ode(ode, [*displacements, *velocities], method="lm", tol=1e-11)

    spent, (motion, told) = timed(theirs, repeats=1)
    rows = np.array([each.coeffs() for each in motion[:modes]]).T
    apart = np.abs(amplitudes(rows, harmonics) - amplitudes(found.q, harmonics)).max()
    return (
        f"| {modes} | {points} | {harmonics} | {1e3 * ours:.1f} | {1e3 * spent:.0f} "
        f"| {spent / ours:.0f} | {apart:.0e} | {'yes' if told.success else 'no'} |"
    )


def by_scipy(model: ReducedModel, point: BranchPoint, energy: float, rtol: float) -> float:
    """Frequency in Hz of the motion of an energy, shot with SciPy from a point."""
    Phi, R, gap = model.Phi[0], float(model.R[0, 0]), float(model.gap[0])
    modes = model.modes
    size = np.sqrt(2 * energy)
    half = 0.5 / point.motion.frequency

    def rate(clock: float, state: np.ndarray) -> np.ndarray:
        q = state[:modes]
        force = max(0.0, (Phi @ q - gap) / R)
        return np.concatenate([state[modes:], -(model.omega**2) * q - force * Phi])

    def miss(unknowns: np.ndarray) -> np.ndarray:
        q = unknowns[:modes] * size / model.omega
        start = np.concatenate([q, np.zeros(modes)])
        span = (0.0, unknowns[modes] * half)
        end = solve_ivp(rate, span, start, method="DOP853", rtol=rtol, atol=rtol * 1e-2).y[:, -1]
        force = max(0.0, (Phi @ q - gap) / R)
        found = (np.sum((model.omega * q) ** 2) + R * force**2) / 2
        return np.append(end[modes:] / size, found / energy - 1)

    first = np.append(model.omega * point.motion.q.sum(axis=0) / size, 1.0)
    solved = fsolve(miss, first, xtol=1e-11)
    return float(0.5 / (half * solved[modes]))


def against_scipy(modes: int, rtol: float) -> str:
    """Row of the table: times of shooting, their ratio, and how far the frequencies are apart."""
    model, balance = blade_tip(modes, 1), HarmonicBalance(10, 128)
    energies = EnergyContinuation(1.5, 2.0, 0.05)
    whole, branch = timed(lambda: follow(model, energies, balance, mode=0), repeats=1)
    point = branch.points[len(branch.points) // 2]

    def shot() -> Any:
        return shoot(Flow(model), OrbitGuess.of(balance.series, point.motion))

    ours, found = timed(shot)
    assert found.converged, found.failure
    spent, frequency = timed(lambda: by_scipy(model, point, point.motion.energy, rtol), repeats=1)
    return (
        f"| {modes} | {rtol:.0e} | {1e3 * whole / len(branch.points):.0f} | {1e3 * ours:.1f} "
        f"| {1e3 * spent:.0f} | {spent / ours:.0f} | {abs(frequency / found.frequency - 1):.0e} "
        f"| {abs(point.motion.frequency / found.frequency - 1):.0e} |"
    )


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description="Side by side with other programs.")
    parser.add_argument("--peers", type=Path, help="virtual environment with harmonicbalance")
    chosen = parser.parse_args()
    if chosen.peers:
        sys.path += [str(path) for path in chosen.peers.glob("lib/python3*/site-packages")]
    try:
        import harmonicbalance.solvers  # noqa: F401
    except ImportError:
        print("harmonicbalance is not installed: see benchmarks/README.md; this part is left out\n")
    else:
        print(
            "| J | n_c | N | fenics_nnm (ms) | harmonicbalance (ms) | ratio | difference "
            "| it converged |\n|---|---|---|---|---|---|---|---|"
        )
        for modes, points, harmonics in ((2, 1, 5), (4, 2, 5), (4, 2, 10), (8, 4, 10)):
            print(against_harmonicbalance(modes, points, harmonics), flush=True)
    print(
        "\n| J | rtol | a point of the branch, checked (ms) | shoot (ms) | SciPy (ms) | ratio "
        "| SciPy off | point off |\n|---|---|---|---|---|---|---|---|"
    )
    for modes in (4, 10, 20):
        for rtol in (1e-6, 1e-10):
            print(against_scipy(modes, rtol), flush=True)


if __name__ == "__main__":
    main()
