"""What is known of motions of harmonic balance from other methods: stability, verdict in time."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.response.in_time import in_time
from fenics_nnm.response.point import Judgement, Status
from fenics_nnm.time_domain.driven_flow import DrivenFlow, driven_flow, has_equations_in_time


class Judge(Protocol):
    """Something that judges motions of one structure under given forces."""

    def of_linear(self, omega: float) -> Judgement:
        """What is known of the motion at a frequency that touches nothing, solved exactly."""

    def of_contact(self, series: FourierSeries, q: Array, omega: float) -> Judgement:
        """What is known of a motion with contact, or nearly so, of coefficients (c, J)."""

    def under(self, mechanics: Mechanics) -> Judge:
        """What judges motions of the same structure under other forces."""


class Unjudged:
    """Nothing more is known than that the harmonic equations are solved."""

    def of_linear(self, omega: float) -> Judgement:
        """Exact."""
        return Judgement(Status.EXACT)

    def of_contact(self, series: FourierSeries, q: Array, omega: float) -> Judgement:
        """Converged."""
        return Judgement(Status.CONVERGED)

    def under(self, mechanics: Mechanics) -> Unjudged:
        """The same."""
        return self


@dataclass(frozen=True, slots=True)
class JudgeInTime:
    """Follows motions in time, see `response.in_time`.

    Attributes:
        mechanics: What motions obey, with viscous damping and no forces besides contact.
    """

    mechanics: Mechanics
    flow: DrivenFlow = field(init=False, repr=False, compare=False)
    slowest: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        model, rate = self.mechanics.model, self.mechanics.linear.rate
        state = np.block([[0 * rate, np.eye(len(rate))], [-np.diag(model.omega**2), -rate]])
        slowest = float(np.linalg.eigvals(state).real.max())
        object.__setattr__(self, "slowest", slowest)
        object.__setattr__(self, "flow", driven_flow(self.mechanics, float(model.omega[0])))

    def of_linear(self, omega: float) -> Judgement:
        """Exact; multipliers are those of the free vibrations without contact."""
        largest = float(np.exp(self.slowest * 2 * np.pi / omega))
        return Judgement(Status.EXACT, "", largest, "stable" if largest < 1 else "unstable")

    def of_contact(self, series: FourierSeries, q: Array, omega: float) -> Judgement:
        """Verdict and multipliers of the exact motion near it."""
        found = in_time(self.flow, series, q, omega)
        return Judgement(
            Status(found.status), found.reason, found.largest_multiplier, found.stability
        )

    def under(self, mechanics: Mechanics) -> JudgeInTime:
        """The same, with what is known of stages of contact, under other forces."""
        other = JudgeInTime(mechanics)
        object.__setattr__(other, "flow", self.flow.driven_by(other.flow.drive))
        return other


def judge_of(mechanics: Mechanics) -> Judge:
    """The judge that fits: in time where there are equations in time between changes of contact."""
    return JudgeInTime(mechanics) if has_equations_in_time(mechanics) else Unjudged()
