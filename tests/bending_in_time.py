"""Frequencies of a cantilever that bends far, against the motion in time of its finite elements.

python3 tests/bending_in_time.py [ELEMENTS]

Second-order kinematics, with contact and without, and linear kinematics beside them.
"""

from __future__ import annotations

import sys

import numpy as np
from bending_cantilever import Cantilever, frequency_in_time

from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.mechanics.model import ReducedModel

#: Motions of the tip across the axis in m, the last three in contact; steps of a period.
LIFTS, STEPS = (4e-3, 7.9e-3, 8.0e-3, 8.2e-3), 400

#: Largest relative error of a frequency.
LARGEST = 3e-4


def points_of(model: ReducedModel, lift: float) -> tuple[BranchPoint, ...]:
    """Points at the motions, of a model whose tip moves by `lift` per coordinate."""
    ratios = tuple((each / lift / model.grazing_amplitude()) ** 2 for each in LIFTS)
    wanted = EnergyContinuation(ratios[0], ratios[-1], 9.0, report_at=ratios)
    return follow(model, wanted, HarmonicBalance(20, 256), mode=0, shooting=True).points


def write(line: str) -> None:
    """Show a line at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def main(elements: int) -> int:
    """Print a line for each motion; 1 if a frequency is farther off than it may be."""
    body = Cantilever(elements)
    reduction = body.reduced(5, np.array([0]))
    lift, rows = float(body.lift @ reduction.shapes[:, 0]), reduction.shapes[:, 0] @ body.M
    worst, touching = 0.0, 0
    write("tip (mm)  contact  second order (Hz)  in time (Hz)   error")
    for point in points_of(reduction.model, lift):
        start = reduction.displacement(point.motion.q.sum(axis=0), point.motion.force[0])
        step = 1 / point.motion.frequency / STEPS
        frequency, drift = frequency_in_time(body, start, rows, step=step, periods=2)
        error = point.motion.frequency / frequency - 1
        write(
            f"{1e3 * body.lift @ start:8.3f} {point.motion.contact_fraction:8.3f} "
            f"{point.motion.frequency:18.4f} {frequency:13.4f} {error:+9.1e}"
        )
        assert drift < 1e-8, "the scheme does not conserve energy"
        worst, touching = max(worst, abs(error)), touching + (point.motion.contact_fraction > 0)
    for point in points_of(reduction.model.linearised, lift):
        write(f"linear kinematics: {point.motion.frequency:.4f} Hz at {point.motion.energy:.4g} J")
    return int(worst > LARGEST or touching < 3)


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 12))
