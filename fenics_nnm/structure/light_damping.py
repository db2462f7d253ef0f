"""Damping of a study for its undamped motions: what it takes, and the force that keeps them up."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.light_damping import LightDamping
from fenics_nnm.structure.analysis import structure_of
from fenics_nnm.structure.structure import Linear
from fenics_nnm.study import Study


def light_damping(study: Study, linear: Linear) -> LightDamping | None:
    """Damping of the reduced model of a study; to be called on all ranks.

    None without damping, where the coordinates are no modes of the structure, and at full order.

    Raises:
        StudyError: if there are not as many ratios as modes.
        MeshError: as `rows_of_body`.
    """
    damped = study.damping is not None or study.dashpot
    if not damped or study.full_order or study.reduction.method != "massless":
        return None
    rows, omega = structure_of(study).damped_rows(linear), linear.model.omega
    count = len(omega)
    rate: Array = rows.rate[:count, :count]
    loss: Array = np.zeros((count, count))
    if study.damping is not None:
        rate = rate + study.damping.rate(omega, count)
        loss = study.damping.loss(omega, count)
    harmonics = {each.harmonic for each in study.excitation if each.order is None}
    single = len(harmonics) == 1 and all(each.order is None for each in study.excitation)
    if not single or 0 in harmonics:
        return LightDamping(rate, loss, np.zeros(count, dtype=complex), float("nan"))
    turns = np.array([each.turn for each in study.excitation])
    push = (rows.sizes * turns) @ rows.excited[:, :count]
    return LightDamping(rate, loss, push, float(rows.sizes[0]), *harmonics)
