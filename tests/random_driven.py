"""Random driven models: do starts from rest end on the stable response, or are told not to."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from itertools import pairwise

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.response.in_time import state_at
from fenics_nnm.response.levels import response
from fenics_nnm.response.point import ResponsePoint
from fenics_nnm.response.simulation import settled, simulation
from fenics_nnm.response.structure import Drive, DrivenStructure
from fenics_nnm.time_domain.damped_flow import DampedFlow
from fenics_nnm.time_domain.driven_motion import DrivenOrbit, driven_orbit

SERIES = FourierSeries(20, 160)

#: Frequencies of the response, and those between which starts from rest lie, over that of mode 1.
FREQUENCIES, STARTS = np.linspace(0.9, 1.25, 36), (0.97, 1.06)

#: Distance from the curve, relative in the energy norm, of a motion that is on it.
ON_CURVE = 1e-6


def structure(rng: np.random.Generator) -> DrivenStructure:
    """Two to five modes, one to three points; linear motions would move 1.2 to 4 times the gap."""
    modes, points = int(rng.integers(2, 6)), int(rng.integers(1, 4))
    omega = 2 * np.pi * np.cumsum(np.append(1.0, rng.uniform(0.8, 3, modes - 1)))
    shapes = rng.normal(size=(points, modes))
    shapes[:, 0] = rng.uniform(0.5, 1.2, points)
    factor = rng.normal(size=(points, points))
    flexibility = 0.1 * np.sum((shapes / omega) ** 2) / points
    R = flexibility * (factor @ factor.T / points + 0.3 * np.eye(points))
    model = ReducedModel(omega, shapes, R, rng.uniform(0.8, 1.2, points))
    ratio = rng.uniform(0.005, 0.03)
    excited = rng.normal(size=(1, modes))
    excited[0, 0] = 1.0
    force = rng.uniform(1.2, 4) * 2 * ratio * omega[0] ** 2 / shapes[:, 0].max()
    part = RatedPart(omega, np.diag(2 * ratio * omega))
    return DrivenStructure.of(model, part, Drive.simple(excited, np.array([force + 0j])))


def distance(flow: DampedFlow, orbit: DrivenOrbit, points: tuple[ResponsePoint, ...]) -> float:
    """Least distance of an orbit from exact ones between two points of a curve, in energy norm."""
    frequency, scale = orbit.omega / (2 * np.pi), flow.model.omega
    least = float("inf")
    for before, after in pairwise(points):
        low, high = before.frequency, after.frequency
        if (low - frequency) * (high - frequency) > 0 or before.q.shape != after.q.shape:
            continue
        share = (frequency - low) / (high - low) if high != low else 0.0
        q = before.q + share * (after.q - before.q)
        if len(q) != len(SERIES.order):
            continue
        near = driven_orbit(flow.at(orbit.omega), *state_at(SERIES, q, orbit.omega, 0.0))
        if not near.failure:
            least = min(least, _apart(scale, near, orbit))
    return least


def _apart(scale: Array, orbit: DrivenOrbit, other: DrivenOrbit) -> float:
    away = [scale * (orbit.q - other.q), orbit.velocity - other.velocity]
    return float(np.linalg.norm(away) / np.linalg.norm([scale * other.q, other.velocity]))


def ends(number: int) -> list[str]:
    """How two starts from rest of a random model end."""
    rng = np.random.default_rng(number)
    driven = structure(rng)
    curve = response(driven, SERIES, FREQUENCIES).points
    flow = DampedFlow.of(driven.mechanics, 1.0)
    rest = np.zeros(driven.model.modes), np.zeros(driven.model.modes)
    slowest = float(np.diag(driven.linear.rate)[0]) / 2
    found = []
    for frequency in rng.uniform(*STARTS, 2):
        periods = np.full(int(15 * frequency / slowest), frequency)
        motion = simulation(flow, driven.watched, periods, rest)
        at = settled(flow, motion.q, motion.velocity, frequency)
        if at.periods != 1 or at.orbit is None:
            found.append(f"told: repeats after {at.periods or 'no'} periods")
        else:
            on = distance(flow, at.orbit, curve) < ON_CURVE
            touches = "in contact" if at.orbit.contact_fraction else "open"
            found.append(f"{'on' if on else 'OFF'} the curve, {touches}")
    return found


def main() -> int:
    """Run as many models as are wanted; exit code 1 if a motion is on no curve."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20)
    counts = Counter(end for number in range(parser.parse_args().count) for end in _shown(number))
    for end, count in sorted(counts.items()):
        sys.stdout.write(f"{count:4d}  {end}\n")
    return int(any(end.startswith("OFF") for end in counts))


def _shown(number: int) -> list[str]:
    found = ends(number)
    sys.stdout.write(f"model {number}: {'; '.join(found)}\n")
    sys.stdout.flush()
    return found


if __name__ == "__main__":
    sys.exit(main())
