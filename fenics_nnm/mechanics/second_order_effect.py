r"""What second order changes, from the tensors of one mode, before any branch is followed.

At the amplitude a of a mode the closing of a contact point changes by 1/2 Theta a^2, and, without
contact, the frequency, to second order in the amplitude, by

    d omega / omega = (3/8 beta / omega^2 - D / 4 - 5/12 alpha^2 / omega^4) a^2

(method of averaging; A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, 1979, section 2.3), where
all other modes follow statically. Stiffness and inertia nearly cancel for a cantilever.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from fenics_nnm.mechanics.model import ReducedModel

Kind = Literal["linear", "auto"]

#: "auto" takes second order where it changes the closing by more than this part of the gap, or the
#: frequency by more than this part, at the largest energy asked for.
CLOSING_CHANGE, FREQUENCY_CHANGE = 5e-3, 1e-4

#: With linear kinematics no point is verified where second order would change the closing at
#: grazing by more than this part of the gap.
LARGEST_CLOSING_CHANGE = 0.05


@dataclass(frozen=True, slots=True)
class Effect:
    """Changes that second order makes.

    Attributes:
        gamma_ratio: Largest energy asked for, over that of grazing with linear kinematics.
        at_grazing: Change of the closing over the gap at grazing, of the point that grazes first;
            negative where bending opens the gap.
        at_largest: The same at the largest energy.
        frequency: Relative change of the frequency there, without contact.
    """

    gamma_ratio: float
    at_grazing: float
    at_largest: float
    frequency: float

    @property
    def matters(self) -> bool:
        """Whether "auto" takes second order."""
        return abs(self.at_largest) > CLOSING_CHANGE or abs(self.frequency) > FREQUENCY_CHANGE

    def __str__(self) -> str:
        return (
            f"at gamma ratio {self.gamma_ratio:.4g} of linear kinematics second order changes the "
            f"closing by {100 * self.at_largest:+.3g} % of the gap, and the frequency without "
            f"contact by {self.frequency:+.1e}"
        )


@dataclass(frozen=True, slots=True)
class KinematicsChoice:
    """Which kinematics a branch is followed with, and why.

    Attributes:
        second_order: Whether they are of second order.
        reason: Why.
        doubt: Why no point of the branch can be verified; empty if none stands against it.
        asked: Whether a study says anything of kinematics.
    """

    second_order: bool
    reason: str
    doubt: str = ""
    asked: bool = True


#: Of a structure whose study does not say which, and of one that asks for second order.
UNASKED = KinematicsChoice(False, "not asked for", asked=False)
ASKED = KinematicsChoice(True, "asked for")


def effect_of(model: ReducedModel, mode: int, largest_ratio: float) -> Effect:
    """What second order changes of a mode that is one of the masters.

    Args:
        model: Model with second-order kinematics; gaps are positive.
        mode: Index of the mode.
        largest_ratio: Largest energy asked for, over that of grazing.

    Raises:
        ModelError: if the mode never touches with linear kinematics.
    """
    rest = model.linearised.at_rest()
    amplitude, point = rest.amplitude(mode), rest.first(mode)
    ratio = max(1.0, largest_ratio)
    bend = float(model.kinematics.curvature(model)[point, mode])
    at_grazing = bend * amplitude**2 / (2 * float(model.gap[point]))
    change = frequency_change(model, mode, amplitude * float(np.sqrt(ratio)))
    return Effect(ratio, at_grazing, at_grazing * ratio, change)


def frequency_change(model: ReducedModel, mode: int, amplitude: float) -> float:
    """Relative change of the frequency of a master without contact, to second order.

    Args:
        model: Model with second-order kinematics, whether its contact points carry mass or not.
        mode: Index of the mode.
        amplitude: Its amplitude in kg^1/2 m.
    """
    masters = model.kinematics.masters
    tensors = model.kinematics.without_modes(masters, model).tensors
    at, square = int(np.searchsorted(masters, mode)), float(model.omega[mode]) ** 2
    alpha, beta, D = (tensors[name][(at,) * n] for name, n in (("alpha", 3), ("beta", 4), ("D", 4)))
    by_square = 3 * beta / (8 * square) - D / 4 - 5 * alpha**2 / (12 * square**2)
    return float(by_square) * amplitude**2


def chosen_kinematics(kind: Kind, effect: Effect, hindrance: str = "") -> KinematicsChoice:
    """Kinematics that a study asks for, or that it needs and can have.

    Args:
        kind: What is asked for: linear kinematics, or those that the branch needs.
        effect: What second order changes.
        hindrance: What second order would need that the study does not have; or nothing.
    """
    doubt = _doubt(effect)
    if kind == "linear":
        return KinematicsChoice(False, f"asked for; {effect}", doubt)
    closing, frequency = f"{100 * CLOSING_CHANGE:g} %", f"{FREQUENCY_CHANGE:g}"
    if not effect.matters:
        return KinematicsChoice(False, f"{effect}: no more than {closing} and {frequency}", doubt)
    limits = f"{closing} or {frequency}"
    if hindrance:
        reason = f"{effect}: more than {limits}, but {hindrance}"
        return KinematicsChoice(False, reason, doubt)
    return KinematicsChoice(True, f"{effect}: more than {limits}")


def _doubt(effect: Effect) -> str:
    """Why no point with linear kinematics can be verified, or nothing."""
    if abs(effect.at_grazing) <= LARGEST_CLOSING_CHANGE:
        return ""
    return (
        "kinematics are linear, and second order would change the closing at grazing by "
        f"{100 * effect.at_grazing:+.3g} % of the gap"
    )
