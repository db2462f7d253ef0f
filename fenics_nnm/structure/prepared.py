"""A study with all that its branch is made of, found once and handed on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import Branch, Continuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance, contact_model
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.targets import Begin
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.full_order_solver import FlexibilitySource
from fenics_nnm.stages import Stages
from fenics_nnm.structure.motions import harmonic_balance, wanted_motions
from fenics_nnm.structure.structure import Linear
from fenics_nnm.study import Study


@dataclass(frozen=True, slots=True)
class Prepared:
    """A study, ready to be followed.

    Attributes:
        study: Study with all its numbers.
        linear: All that is linear of its structure.
        balance: How its motions are written in time, and contact is found.
        wanted: Which motions it asks for.
    """

    study: Study
    linear: Linear
    balance: HarmonicBalance
    wanted: Continuation

    @property
    def mode(self) -> int:
        """Index of the linear mode that the branch starts at, from 0."""
        return self.study.mode.number - 1

    @property
    def model_in_contact(self) -> ReducedModel:
        """The model that the motions obey, R = 0 where contact points carry mass."""
        return contact_model(self.linear.model, self.balance, full_order=self.study.full_order)

    @property
    def linear_frequencies(self) -> Array:
        """Frequencies of the linear modes about the state of rest in Hz, ascending."""
        rest = self.linear.model.at_rest()
        if rest.closed.any():
            return np.asarray(rest.omega / (2 * np.pi))
        return np.asarray(self.linear.modes.frequencies)

    def beginning_at(self, begin: Begin) -> Prepared:
        """The same from a motion of an earlier run on; of a branch followed by its length."""
        return replace(self, wanted=wanted_motions(self.study, begin))

    def followed(
        self,
        *,
        flexibility: FlexibilitySource | None = None,
        known: Sequence[BranchPoint] = (),
        on_point: Callable[[BranchPoint], None] = lambda point: None,
        stages: Stages | None = None,
    ) -> Branch:
        """Follow the nonlinear mode.

        Args:
            flexibility: Residual flexibility of the whole model, for a study of full order.
            known: Points found before.
            on_point: Called with each converged point before the next one is begun.
            stages: Told how far the branch is.
        """
        stages, wanted = stages or Stages(), self.wanted
        span = wanted.stop - wanted.start
        with stages.stage("backbone"):
            return follow(
                self.linear.model,
                wanted,
                self.balance,
                mode=self.mode,
                flexibility=flexibility,
                truncation=self.linear.reduction.truncation,
                shooting=self.study.continuation.shooting,
                known=known,
                on_point=on_point,
                on_progress=lambda place: stages.report((place - wanted.start) / span),
            )


def prepared(study: Study, linear: Linear) -> Prepared:
    """A study with all its numbers, and all that is linear of it, ready to be followed."""
    return Prepared(study, linear, harmonic_balance(study), wanted_motions(study))
