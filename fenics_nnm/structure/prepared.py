"""A study with all that its branch is made of, found once and handed on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.arc_start import Begin
from fenics_nnm.backbone.damped_branch import damped_branch
from fenics_nnm.backbone.follow import (
    Branch,
    FullOrder,
    Progress,
    ReducedOrder,
    Wanted,
    follow,
)
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.order import contact_model
from fenics_nnm.backbone.outlook import Outlook, outlook
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.quantities import PLAIN, Measures
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.reduction.flexibility import FlexibilitySource
from fenics_nnm.stages import Stages
from fenics_nnm.structure.damped_run import UNDAMPED, DampedRun
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
        damping: What its damping does in a run, once that is known.
    """

    study: Study
    linear: Linear
    balance: HarmonicBalance
    wanted: Wanted
    damping: DampedRun = UNDAMPED

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

    @property
    def reduced_order(self) -> ReducedOrder:
        """Equations of the reduced model, with all forces that it has."""
        reduction = self.linear.reduction
        return ReducedOrder(reduction.truncation, reduction.forces, self._doubt)

    @property
    def _doubt(self) -> str:
        """Why no motion can be verified, or nothing."""
        return self.linear.reduction.choice.doubt

    def warnings(self) -> tuple[str, ...]:
        """What looks like a wrong unit or direction, a line each; to be called on all ranks."""
        return tuple(self.linear.warnings(self.study, self.mode))

    def outlook(self) -> Outlook:
        """A look ahead at the branch."""
        forces = self.linear.reduction.forces
        return outlook(self.linear.model, self.wanted, self.balance, mode=self.mode, forces=forces)

    @property
    def series(self) -> str:
        """Series in time that its motions are written in: "time-reversible" or "general"."""
        return "general" if self.balance.general else "time-reversible"

    def with_damping(self, damping: DampedRun) -> Prepared:
        """The same with what its damping does; damped motions have sines."""
        general = self.balance.general or damping.follows
        return replace(self, damping=damping, balance=replace(self.balance, general=general))

    def beginning_at(self, begin: Begin) -> Prepared:
        """The same from a motion of an earlier run on; of a branch followed by its length."""
        return replace(self, wanted=wanted_motions(self.study, begin))

    def followed(
        self,
        *,
        flexibility: FlexibilitySource | None = None,
        known: Sequence[BranchPoint] = (),
        on_point: Callable[[BranchPoint], None] = lambda point: None,
        measures: Measures = PLAIN,
        stages: Stages | None = None,
    ) -> Branch:
        """Follow the nonlinear mode.

        Args:
            flexibility: Residual flexibility of the whole model, for a study of full order.
            known: Points found before.
            on_point: Called with each converged point before the next one is begun.
            measures: Quantities of motions that values may be asked of.
            stages: Timings and progress.
        """
        stages, wanted = stages or Stages(), self.wanted
        span = wanted.stop - wanted.start
        progress = Progress(
            known,
            on_point,
            lambda position: stages.report((position - wanted.start) / span),
            measures,
        )
        if (maker := self.damping.maker) is not None:
            with stages.stage("damped motions"):
                return damped_branch(
                    maker, self.damping.ratios, doubt=self._doubt, progress=progress
                )
        with stages.stage("backbone"):
            branch = follow(
                self.linear.model,
                wanted,
                self.balance,
                mode=self.mode,
                order=FullOrder(flexibility, self._doubt) if flexibility else self.reduced_order,
                shooting=self.study.continuation.shooting,
                progress=progress,
            )
        return branch if branch.complete else self._advised(branch)

    def _advised(self, branch: Branch) -> Branch:
        """A branch without all that was wanted, with the keys of the study that may help."""
        advice = self.study.continuation.advice(self.study.resolution.samples)
        return replace(branch, reason=f"{branch.reason}; {advice}")


def prepared(study: Study, linear: Linear) -> Prepared:
    """A study with all its numbers, and all that is linear of it, ready to be followed."""
    return Prepared(study, linear, harmonic_balance(study), wanted_motions(study))
