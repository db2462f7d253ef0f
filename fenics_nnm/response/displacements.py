"""Displacements of the places that are watched, from a motion's harmonics."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_law import Complementarity, ContactForces
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.response.point import Displacements
from fenics_nnm.response.structure import DrivenStructure

#: Instants of a period at which the largest displacement of several harmonics is looked for.
_INSTANTS = 4096
_PHASES = 2 * np.pi * np.arange(_INSTANTS) / _INSTANTS


def displacements(
    structure: DrivenStructure, series: FourierSeries, solution: Solution
) -> Displacements:
    """Displacements of the places that are watched."""
    watched, q, forces = structure.watched, solution.q, solution.forces
    harmonics = watched.harmonics(series, q, forces)
    first, second = np.flatnonzero(series.order == 1)
    left = None
    if structure.gap_motion.moves:
        highest, lowest, left = _past_moving_gaps(structure, series, q)
    elif watched.bends or harmonics[series.order > 1].any():
        highest, lowest = _extremes(structure, series, q)
        if structure.model.massless:  # parabolas overshoot where a point lies on its obstacle
            highest[watched.before_contact :] = np.minimum(
                highest[watched.before_contact :], structure.model.gap
            )
    else:
        size = np.linalg.norm(harmonics[[first, second]], axis=0)
        highest, lowest = harmonics[0] + size, harmonics[0] - size
    return Displacements(
        first=harmonics[first] - 1j * harmonics[second],
        highest=highest,
        lowest=lowest,
        contact=_contact(watched.before_contact, series, forces),
        gap=structure.model.gap - highest[watched.before_contact :] if left is None else left,
    )


def _contact(others: int, series: FourierSeries, forces: ContactForces) -> Array:
    """Shares of the period with contact."""
    weight, touching = forces.instants.weight(series), forces.force > 0
    anywhere = float(weight @ touching.any(axis=1))
    return np.concatenate([np.full(others, anywhere), weight @ touching])


def _extremes(structure: DrivenStructure, series: FourierSeries, q: Array) -> tuple[Array, Array]:
    """Largest and smallest displacements over the period, each of shape (w,)."""
    model, watched = structure.model, structure.watched
    moved = watched.free(_basis(series.harmonics), q)
    if model.massless:
        force = Complementarity(model.R, model.gap)(moved[:, watched.before_contact :]).force
        moved -= force @ watched.residual.T
    return _top(moved), -_top(-moved)


def _past_moving_gaps(
    structure: DrivenStructure, series: FourierSeries, q: Array
) -> tuple[Array, Array, Array]:
    """As `_extremes`, and the smallest remaining gap of each contact point, shape (n_c,)."""
    model, watched = structure.model, structure.watched
    gap = model.gap + structure.gap_motion.at(_PHASES)
    moved = watched.free(_basis(series.harmonics), q)
    if not model.massless:
        return _top(moved), -_top(-moved), -_top(moved[:, watched.before_contact :] - gap)
    excess = moved[:, watched.before_contact :] - gap
    moved -= Complementarity(model.R, np.zeros(model.points))(excess).force @ watched.residual.T
    left = -_top(moved[:, watched.before_contact :] - gap)
    return _top(moved), -_top(-moved), np.maximum(left, 0.0)


def _top(values: Array) -> Array:
    """Largest values of columns that belong to evenly spread instants, by parabolas."""
    at, columns = values.argmax(axis=0), np.arange(values.shape[1])
    before, here, after = (values[(at + n) % len(values), columns] for n in (-1, 0, 1))
    bend = before - 2 * here + after
    smooth = bend < 0
    rise = (after - before) ** 2 / np.where(smooth, -8 * bend, 1.0)
    return np.asarray(here + np.where(smooth, rise, 0.0))


@lru_cache(maxsize=4)
def _basis(harmonics: int) -> Array:
    """Basis functions at instants of a period, shape (instants, c)."""
    series = FourierSeries(harmonics, 2 * harmonics + 1)
    return series.basis_at(_PHASES)
