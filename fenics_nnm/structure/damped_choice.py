"""Whether a run follows damped motions, or undamped ones with their damping to first order."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.damped_branch import DampedMaker
from fenics_nnm.backbone.damped_model import DampedModel
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.light_damping import LightDamping
from fenics_nnm.structure.damped_run import DampedRun
from fenics_nnm.structure.light_damping import light_damping
from fenics_nnm.structure.structure import Linear
from fenics_nnm.study import Study

#: Parts below this are round-off.
_NOTHING = 1e-9


def damped_run(study: Study, linear: Linear) -> DampedRun:
    """What the damping of a study does in a run; to be called on all ranks.

    Raises:
        StudyError, MeshError: as `light_damping`.
    """
    method, given = study.reduction.method, study.damping is not None or study.dashpot
    if given and method != "massless":
        return DampedRun(ignored=f'reduction.method = "{method}": damping needs "massless"')
    light, ratios = light_damping(study, linear), study.continuation.damped_ratios
    if light is None or not study.continuation.damped:
        return DampedRun(light)
    if objection := _objection(study, linear, light, ratios):
        return DampedRun(light, objection=objection)
    model, mode = linear.model, study.mode.number - 1
    push, size = _push(light, mode)
    numbers = study.resolution
    series = FourierSeries(numbers.harmonics, numbers.samples)
    maker = DampedMaker(DampedModel(model, light.rate, push, mode), size, series)
    return DampedRun(light, maker, ratios)


def _push(light: LightDamping, mode: int) -> tuple[Array, float]:
    """The force of level 1 without its phase and its size; modal where there is none."""
    if not light.push.any():
        modal = np.zeros(len(light.push))
        modal[mode] = 1.0
        return modal, float("nan")
    return _without_phase(light), light.size


def _without_phase(light: LightDamping) -> Array:
    """The force with the phase of its largest part turned to zero; its real part."""
    largest = light.push[np.argmax(np.abs(light.push))]
    return np.asarray((light.push * abs(largest) / largest).real)


def _objection(study: Study, linear: Linear, light: LightDamping, ratios: tuple[float, ...]) -> str:
    """Why damped motions cannot be followed, or nothing."""
    model, mode = linear.model, study.mode.number - 1
    if not ratios:
        return 'continuation.parameter: damped motions are followed over "energy" alone'
    if study.continuation.sought:
        return "continuation: amplitudes, stresses and energies in J are those of undamped motions"
    if light.loss.any():
        return "damping.loss_factor: has no equations in time"
    if model.kinematics.forces:
        return "second-order kinematics: damped motions need linear ones"
    if linear.reduction.forces:
        return "springs that are not linear: damped motions need linear ones"
    if model.gap.min() <= 0:
        return f"contact.gap = {model.gap.min():g}: must be positive for damped motions"
    if light.rate[mode, mode] <= 0:
        return "damping: takes nothing from the followed mode"
    return _objection_to_force(study, light, mode)


def _objection_to_force(study: Study, light: LightDamping, mode: int) -> str:
    """Why a force cannot keep the motion up, or nothing."""
    if not study.excitation:
        return ""
    if not light.push.any() or light.harmonic != 1:
        return "excitation.harmonic, order: damped motions need forces at their own frequency"
    size, own = float(np.linalg.norm(light.push)), _without_phase(light)
    if np.linalg.norm(np.abs(light.push) - np.abs(own)) > _NOTHING * size:
        return "excitation.phase_deg: must be the same for all forces"
    if abs(own[mode]) <= _NOTHING * size:
        return "excitation: does not move the followed mode"
    return ""
