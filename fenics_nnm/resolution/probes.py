"""A few motions of a study, spread over its range, to judge its numbers by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.nonlinear.series_error import SeriesError
from fenics_nnm.structure.prepared import Prepared

#: Number of energies. Their distance from grazing goes with the cube of their number, since the
#: contact grows with the square root of that distance at first.
_ENERGIES = 9

#: Nearest to grazing, as a ratio: nearer there is next to no contact.
_NEAREST = 1.001


def probes(prepared: Prepared, *, count: int = _ENERGIES) -> tuple[float, ...]:
    """Gamma ratios of the probes, ascending; none for a branch that ends below grazing.

    Args:
        prepared: Study with all numbers.
        count: Number of probes.
    """
    wanted, model = prepared.wanted, prepared.linear.model
    start, stop = wanted.span(prepared.outlook)
    if np.isnan(start) or np.isnan(stop):
        return ()
    linear = model.at_rest().is_linear(prepared.mode)
    first = max(float(start), _NEAREST) if linear else float(start)
    if stop <= first:
        return ()
    part = (np.arange(count) / (count - 1)) ** 3
    return tuple(float(ratio) for ratio in first + (stop - first) * part)


def probed(prepared: Prepared, ratios: Sequence[float]) -> tuple[BranchPoint, ...]:
    """Points at some gamma ratios, where there are any, with all their expected errors.

    Where contact points carry mass, the error of the series is the difference to a motion of
    twice as many harmonics and samples.
    """
    if not ratios:
        return ()
    points, balance = solved(prepared, ratios), prepared.balance
    if prepared.linear.model.massless:
        return points
    finer = replace(balance, harmonics=2 * balance.harmonics, samples=2 * balance.samples)
    solutions = solved(replace(prepared, balance=finer), ratios)
    true = {p.gamma_ratio: p.motion.frequency for p in solutions}
    return tuple(
        _with_series_error(point, true[point.gamma_ratio])
        for point in points
        if point.gamma_ratio in true
    )


def _with_series_error(point: BranchPoint, true: float) -> BranchPoint:
    """A point with the error of its series, all of it taken to be that of the harmonics."""
    error = SeriesError(point.motion.frequency / true - 1, samples=0.0, remainder=0.0)
    return replace(point, expected=replace(point.expected, series=error))


def solved(prepared: Prepared, ratios: Sequence[float]) -> tuple[BranchPoint, ...]:
    """Points of a study at some gamma ratios, where there are any."""
    ends = ratios[0], max(ratios[-1], 1.01 * ratios[0])
    energies = EnergyContinuation(
        *ends, step=ends[1] - ends[0], smallest_step=np.inf, report_at=tuple(ratios)
    )
    branch = follow(
        prepared.linear.model,
        energies,
        prepared.balance,
        mode=prepared.mode,
        order=prepared.reduced_order,
    )
    return tuple(point for point in branch.points if point.gamma_ratio in ratios)
