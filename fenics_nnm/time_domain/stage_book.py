"""Linear stages of a model with massless contact points, and which of them a state is in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Generic, Protocol, TypeVar

from fenics_nnm.arrays import Array, Mask
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.closed import highest_frequency
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.kept import Kept

#: Points in contact after a change are those a moment later: this over the highest frequency.
#: Changes that lie closer together count as one; the state is in error by the square of it.
_MOMENT = 1e-9

#: Stages that are kept, if they are not too large.
_STAGES_KEPT = 2000

#: Stages that are tried for a state before its forces are found from scratch.
_RECENT = 4


class Stage(Protocol):
    """Equations of motion while the points in contact stay the same."""

    def holds(self, q: Array) -> bool:
        """Whether all margins are positive at a state of shape (k,)."""

    def toggled(self, q: Array) -> Mask:
        """Points in contact, with the change where a margin is not positive, shape (n_c,)."""

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""


S = TypeVar("S", bound=Stage)


@dataclass(frozen=True, slots=True)
class StageBook(Generic[S]):
    """The stages that a motion met; each is made once.

    Attributes:
        model: Reduced model, R > 0.
        moves: Displacement of the contact points against their gaps per number of a state: Phi, or
            Phi and -1 of coordinates with changes of the gaps after them, shape (n_c, k).
        made: Makes the stage with given points in contact, shape (n_c,).

    Raises:
        ModelError: if contact points carry mass: what follows an impact is then not defined.
    """

    model: ReducedModel
    moves: Array
    made: Callable[[Mask], S]
    moment: float = field(init=False)
    _law: Complementarity = field(init=False, repr=False, compare=False)
    _stages: Kept[S] = field(
        init=False, repr=False, compare=False, default_factory=lambda: Kept(_STAGES_KEPT)
    )
    _recent: list[S] = field(init=False, repr=False, compare=False, default_factory=list)

    def __post_init__(self) -> None:
        if not self.model.massless:
            raise ModelError("the motion in time needs contact points without mass: R is singular")
        object.__setattr__(self, "_law", Complementarity(self.model.R, self.model.gap))
        object.__setattr__(self, "moment", _MOMENT / highest_frequency(self.model))

    def forces(self, q: Array) -> Array:
        """Contact forces in N at states of shape (s, k), shape (s, n_c)."""
        return self._law(q @ self.moves.T).force

    def after(self, q: Array, velocity: Array, before: S | None) -> S:
        """The stage that a state is about to be in; most often one point opens or closes."""
        soon = q + self.moment * velocity
        if before is not None:
            changed = self._stage(before.toggled(soon))
            if changed.holds(soon):
                return changed
        return self.at(soon)

    def at(self, q: Array) -> S:
        """The stage of a state of shape (k,).

        The forces at a state are unique: a stage with positive margins is the right one. Most
        often it is one of the last states asked for.
        """
        stage = next((known for known in self._recent if known.holds(q)), None)
        if stage is None:
            stage = self._stage(self._law((self.moves @ q)[None]).force[0] > 0)
        others = [known for known in self._recent if known is not stage]
        self._recent[:] = [stage, *others[: _RECENT - 1]]
        return stage

    def _stage(self, active: Mask) -> S:
        """The stage with given points in contact."""
        return self._stages.at(active.tobytes(), lambda: self.made(active))
