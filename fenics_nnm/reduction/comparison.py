"""Whether two reduced models are of one structure: modes are known up to their sign."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.model import ReducedModel

#: Largest difference of two reduced models that are the same, relative to the largest entry.
_SAME_MODEL = 1e-6


def model_difference(stored: ReducedModel, model: ReducedModel) -> str:
    """What differs between two reduced models, up to the signs of the modes; or nothing."""
    if stored.Phi.shape != model.Phi.shape:
        (points, modes), (points_now, modes_now) = stored.Phi.shape, model.Phi.shape
        return (
            f"its model has {modes} modes and {points} contact points, and now there are "
            f"{modes_now} and {points_now}"
        )
    frequencies = np.abs(model.omega / stored.omega - 1)
    if frequencies.max() > _SAME_MODEL:
        mode = int(np.argmax(frequencies > _SAME_MODEL))
        before, now = stored.omega[mode] / (2 * np.pi), model.omega[mode] / (2 * np.pi)
        return f"linear frequency {mode + 1} was {before:.9g} Hz and is {now:.9g} Hz now"
    if not _close(stored.gap, model.gap):
        return "the gaps differ"
    shapes = _close(stored.Phi, model.Phi * mode_signs(stored, model))
    if not shapes:
        return "the linear modes differ at the contact points"
    if not _close(stored.R, model.R):
        return "the residual flexibility differs"
    return _kinematics_difference(stored, model)


def mode_signs(stored: ReducedModel, model: ReducedModel) -> Array:
    """The sign of each mode of a model in terms of the stored ones, shape (J,).

    A mode that is still at all contact points has either: no motion in contact has a part of it.
    """
    return np.where(np.einsum("ij,ij->j", stored.Phi, model.Phi) < 0, -1.0, 1.0)


def _kinematics_difference(stored: ReducedModel, model: ReducedModel) -> str:
    """What differs between second-order kinematics; or nothing."""
    before, now = stored.kinematics.tensors, model.kinematics.tensors
    if before.keys() != now.keys():
        return "second-order kinematics are with one of them alone"
    if not before:
        return ""
    if not np.array_equal(stored.kinematics.masters, model.kinematics.masters):
        return "the masters of second-order displacement differ"
    signs = mode_signs(stored, model)
    own = signs[model.kinematics.masters]
    pairs = np.multiply.outer(own, own)
    by_name = {
        "Theta": pairs,
        "alpha": np.multiply.outer(signs, pairs),
        "beta": np.multiply.outer(pairs, pairs),
        "D": np.multiply.outer(pairs, pairs),
    }
    for name, sign in by_name.items():
        if not _close(before[name], now[name] * sign):
            return f"{name} of second-order displacement differs"
    return ""


def _close(stored: Array, found: Array) -> bool:
    return bool(np.abs(found - stored).max() <= _SAME_MODEL * np.abs(stored).max())
