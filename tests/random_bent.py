"""Random masses with springs that are not linear: frequencies against the masses' own equations.

The program gets such a system as matrices: unilateral springs are unknowns without mass behind
contact rows. The reference knows masses, springs and stops alone. SciPy integrates it over half a
period, and its free motion from rest to rest is found at the energy of each verified point.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

import fenics_nnm as nnm
from fenics_nnm.arrays import Array, Indices

#: Largest relative error of the frequency of a verified point.
LARGEST_ERROR = 1e-4

#: Of lengths, m.
_GAP = 1e-3


@dataclass(frozen=True, slots=True)
class Masses:
    """Masses that are held and coupled by springs, some of them before stops that give way.

    Attributes:
        mass: kg, shape (n,).
        stiffness: Of the linear springs at speed, N/m, shape (n, n).
        quadratic: Of the springs that hold the masses, N/m^2, shape (n,).
        cubic: The same, N/m^3, shape (n,).
        touching: Masses before stops, shape (n_c,).
        way: Direction towards the stop, 1 or -1, shape (n_c,).
        curvature: The closing is way u + curvature u^2, 1/m, shape (n_c,).
        gap: At speed, m, shape (n_c,).
        stop: Stiffness of the stops, N/m, shape (n_c,).
    """

    mass: Array
    stiffness: Array
    quadratic: Array
    cubic: Array
    touching: Indices
    way: Array
    curvature: Array
    gap: Array
    stop: Array

    def _pressed(self, u: Array) -> Array:
        v = u[self.touching]
        return np.asarray(np.maximum(self.way * v + self.curvature * v**2 - self.gap, 0.0))

    def energy(self, u: Array) -> float:
        """Potential energy in J of displacements of shape (n,)."""
        springs = u @ self.stiffness @ u / 2 + (self.quadratic * u**3 / 3).sum()
        stops = (self.stop * self._pressed(u) ** 2 / 2).sum()
        return float(springs + (self.cubic * u**4 / 4).sum() + stops)

    def acceleration(self, u: Array) -> Array:
        """In m/s^2, shape (n,)."""
        force = -self.stiffness @ u - self.quadratic * u**2 - self.cubic * u**3
        turned = self.way + 2 * self.curvature * u[self.touching]
        np.subtract.at(force, self.touching, self.stop * self._pressed(u) * turned)
        return np.asarray(force / self.mass)

    def frequency(self, start: Array, near: float, energy: float) -> float:
        """Frequency in Hz of the motion from rest to rest near another one; nan if none is found.

        Args:
            start: Displacements at rest of the other motion, m, shape (n,).
            near: Its frequency, Hz.
            energy: J.
        """
        n, size = len(start), np.abs(start).max()

        def slope(_: float, y: Array) -> Array:
            return np.concatenate([y[n:], self.acceleration(y[:n])])

        def off(x: Array) -> Array:
            u, period = size * x[:n], x[n] / near
            course = solve_ivp(
                slope,
                (0.0, period / 2),
                np.append(u, np.zeros(n)),
                method="DOP853",
                rtol=1e-10,
                atol=1e-13,
                max_step=period / 100,
            )
            velocity = course.y[n:, -1] / (2 * np.pi * near * size)
            return np.append(velocity, self.energy(u) / energy - 1)

        found = root(off, np.append(start / size, 1.0), tol=1e-9)
        return float(near / found.x[n]) if np.abs(found.fun).max() < 1e-7 else float("nan")


@dataclass(frozen=True, slots=True)
class Model:
    """Masses at a speed, and what changes with it.

    Attributes:
        masses: At speed.
        speed: rad/s.
        per_speed: Stiffness per speed^2, shape (n, n).
        gap_growth: Per speed^2, shape (n_c,).
    """

    masses: Masses
    speed: float
    per_speed: Array
    gap_growth: Array

    @classmethod
    def random(cls, rng: np.random.Generator) -> Model:
        """One to three masses, one or two stops, with or without speed and quadratic closing."""
        n = int(rng.choice([1, 2, 2, 3]))
        points = min(int(rng.choice([1, 1, 2])), n)
        between = rng.uniform(2e3, 2e4, n - 1)
        K = np.diag(rng.uniform(2e3, 1e4, n) + np.append(between, 0) + np.append(0, between))
        K -= np.diag(between, 1) + np.diag(between, -1)
        mass, speed = rng.uniform(0.5, 2, n), float(rng.choice([0.0, 20.0, 40.0]))
        per_speed = np.diag(mass * rng.uniform(-1, 2, n))
        growth = rng.uniform(-1e-4, 1e-4, points) * _GAP
        curved = bool(rng.random() < 0.5)
        masses = Masses(
            mass=mass,
            stiffness=K + speed**2 * per_speed,
            quadratic=rng.uniform(-0.1, 0.1, n) * K[0, 0] / _GAP,
            cubic=rng.uniform(-0.03, 0.1, n) * K[0, 0] / _GAP**2,
            touching=rng.permutation(n)[:points],
            way=rng.choice([-1.0, 1.0], points),
            curvature=curved * rng.uniform(-0.1, 0.1, points) / _GAP,
            gap=rng.uniform(0.5, 1.5, points) * _GAP + speed**2 * growth,
            stop=10 ** rng.uniform(3.3, 5.5, points),
        )
        return cls(masses, speed, per_speed, growth)

    def study(self, folder: Path, number: int) -> nnm.Study:
        """As matrices: each stop is an unknown without mass, held to its mass by a spring."""
        masses, n, points = self.masses, len(self.masses.mass), len(self.masses.gap)
        size, own, stops = n + points, np.arange(n), n + np.arange(points)
        K, M, S = (np.zeros((size, size)) for _ in range(3))
        K[:n, :n] = masses.stiffness - self.speed**2 * self.per_speed
        M[own, own], S[:n, :n] = masses.mass, self.per_speed
        for stop, mass, k in zip(stops, masses.touching, masses.stop, strict=True):
            K[np.ix_([mass, stop], [mass, stop])] += k * np.array([[1, -1], [-1, 1]])
        B, B2 = np.zeros((points, size)), np.zeros((points, size, size))
        B[range(points), stops] = masses.way
        B2[range(points), masses.touching, masses.touching] = masses.curvature
        K2, K3 = np.zeros((size,) * 3), np.zeros((size,) * 4)
        K2[own, own, own], K3[own, own, own, own] = masses.quadratic, masses.cubic
        np.savez(folder / "m.npz", K=K, M=M, B=B, B2=B2, K2=K2, K3=K3, S=S)
        names = {"quadratic_stiffness": "K2", "cubic_stiffness": "K3", "quadratic_rows": "B2"}
        turning = {"speed": self.speed, "speed_stiffness": "S"} if self.speed else {}
        growth = {"gap_growth": self.gap_growth} if self.speed else {}
        at_rest = masses.gap - self.speed**2 * self.gap_growth
        values = {
            "title": f"Random masses {number}",
            "matrices": {"file": "m.npz", "masters": list(range(1, n + 1)), **names, **turning},
            "contact": {"gap": at_rest, **growth},
            "reduction": {"modes": n},
            "mode": {"number": 1 + number % n, "harmonics": 15, "samples": 256},
            "continuation": {"energies": {"from": 0.6, "to": 3.0, "step": 0.3}, "report_at": [3.0]},
        }
        return nnm.make_study(values, folder)


def ends(number: int) -> list[tuple[str, float]]:
    """Statuses of the points of a random model, and errors of the frequencies of verified ones."""
    model = Model.random(np.random.default_rng(number))
    with tempfile.TemporaryDirectory() as folder:
        branch = model.study(Path(folder), number).branch()
        return [(point.status, _error(model.masses, point)) for point in branch]


def _error(masses: Masses, point: nnm.Point) -> float:
    """Relative error of the frequency; 0 if the point is not verified, nan without a reference."""
    if point.status != "verified":
        return 0.0
    start = point.unknowns(instants=64).displacement_m[0, : len(masses.mass)]
    exact = masses.frequency(start, point.frequency_Hz, point.energy_J)
    return abs(point.frequency_Hz / exact - 1)


def main() -> int:
    """Run as many models as are wanted; exit code 1 if a verified frequency is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=40)
    statuses: Counter[str] = Counter()
    errors: list[float] = []
    for number in range(parser.parse_args().count):
        points = ends(number)
        statuses.update(status for status, _ in points)
        errors += [error for status, error in points if status == "verified"]
        worst = max((error for _, error in points), default=0.0)
        sys.stdout.write(f"model {number}: {len(points)} points, largest error {worst:.1e}\n")
        sys.stdout.flush()
    found = np.array(errors)
    for status, count in sorted(statuses.items()):
        sys.stdout.write(f"{count:4d}  {status}\n")
    without = int(np.isnan(found).sum())
    sys.stdout.write(
        f"largest error of {len(found)} verified frequencies {np.nanmax(found):.1e}, "
        f"median {np.nanmedian(found):.1e}; {without} without a reference\n"
    )
    return int(bool((found > LARGEST_ERROR).any()))


if __name__ == "__main__":
    sys.exit(main())
