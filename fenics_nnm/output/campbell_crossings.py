"""Where engine orders meet the linear and nonlinear lines of a Campbell diagram."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.reduction.mode_lines import crossings
from fenics_nnm.structure.campbell import AtSpeed
from fenics_nnm.structure.motions_at_speed import Target


@dataclass(frozen=True, slots=True)
class Met:
    """Where n times the speed is a frequency of a line.

    Attributes:
        order: Engine order n.
        mode: Number of the mode, from 1.
        speed: Speed in rad/s.
        frequency: Frequency in Hz.
        line: Mode, and what a nonlinear line keeps, in words.
        energy: Energy in J, 0 of a linear mode.
        amplitude: Largest displacement in m, 0 of a linear mode.
    """

    order: int
    mode: int
    speed: float
    frequency: float
    line: str
    energy: float = 0.0
    amplitude: float = 0.0


@dataclass(frozen=True, slots=True)
class NonlinearLine:
    """Motions of one energy, or one amplitude, over the speed; nan where there is none.

    Attributes:
        target: What it keeps.
        mode: Number of the mode, from 1.
        frequency: Frequency at each speed in Hz, shape (s,).
        energy: Energy in J, shape (s,).
        amplitude: Largest displacement in m, shape (s,).
    """

    target: Target
    mode: int
    frequency: Array
    energy: Array
    amplitude: Array


def borne(points: Iterable[AtSpeed]) -> list[AtSpeed]:
    """Speeds with a static state."""
    return [point for point in points if not point.reason]


def nonlinear_lines(points: Sequence[AtSpeed]) -> list[NonlinearLine]:
    """Nonlinear lines of speeds with a static state, in the order they were asked for."""
    found = borne(points)
    if not found:
        return []
    return [_line(found, place) for place in range(len(found[0].motions))]


def _line(points: Sequence[AtSpeed], place: int) -> NonlinearLine:
    motions = [point.motions[place] for point in points]
    rows = [
        [np.nan] * 3 if each.failed else [each.frequency, each.energy, each.amplitude]
        for each in motions
    ]
    return NonlinearLine(motions[0].target, points[0].mode, *np.array(rows).T)


def crossings_of(points: Sequence[AtSpeed], orders: Iterable[int]) -> list[Met]:
    """Where engine orders meet lines, by order; of linear modes first, each by speed."""
    found = borne(points)
    if not found:
        return []
    speeds = np.array([point.speed for point in found])
    linear = np.array([point.frequencies for point in found])
    lines = nonlinear_lines(points)
    met: list[Met] = []
    for order in orders:
        met += [
            Met(order, each.mode + 1, each.speed, each.frequency, f"mode {each.mode + 1}")
            for each in crossings(speeds, linear, order)
        ]
        for line in lines:
            met += _met(line, speeds, order)
    return met


def _met(line: NonlinearLine, speeds: Array, order: int) -> list[Met]:
    """Where an engine order meets a nonlinear line; numbers are linear between two speeds."""
    return [
        Met(
            order,
            line.mode,
            each.speed,
            each.frequency,
            f"mode {line.mode} of {line.target}",
            energy=float(np.interp(each.speed, speeds, line.energy)),
            amplitude=float(np.interp(each.speed, speeds, line.amplitude)),
        )
        for each in crossings(speeds, line.frequency[:, None], order)
    ]
