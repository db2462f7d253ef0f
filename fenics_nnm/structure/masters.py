"""Which modes bend a body in second order: the followed one, and those that matter beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fem.modal_solver import ModalSolver
from fenics_nnm.mechanics.along import Along
from fenics_nnm.mechanics.pairs import Pairs
from fenics_nnm.mechanics.second_order import SecondOrder
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.structure.bending import Bendable, Bending, bent

#: Most masters that the program chooses, the followed mode among them.
MOST = 6

#: A mode is a master if it would change the frequency by more than this part, that to which motions
#: are verified.
FREQUENCY_CHANGE = 1e-3


@dataclass(frozen=True, slots=True)
class MastersChoice:
    """A reduction with the masters that the program has chosen.

    Attributes:
        reduction: Reduction with second-order kinematics of these.
        reason: Why these.
    """

    reduction: Reduction
    reason: str


def chosen_masters(
    body: Bendable, bending: Bending, largest_ratio: float, solver: ModalSolver
) -> MastersChoice:
    """The followed mode, and up to five others that would change closing or frequency.

    Derivatives are made for those alone that could do so as far as one can tell from the followed
    mode; to be called on all ranks.

    Args:
        body: Body with its contact points.
        bending: Its models, with the followed mode as the only master.
        largest_ratio: Largest energy asked for, over that of grazing.
        solver: Solver of its stiffness.
    """
    along = Along.of(bending.bent.model, bending.mode, max(1.0, largest_ratio))
    expected = _expected(body, bending, along)
    likely = np.argsort(-expected, kind="stable")[: MOST - 1]
    likely = likely[expected[likely] > FREQUENCY_CHANGE]
    if not len(likely):
        return MastersChoice(bending.bent, "no other mode moves far enough to bend it as well")
    whole = bent(body, bending.straight, np.sort([bending.mode, *likely]), solver)
    found = _changes(whole, along)
    kept = [each.place for each in found if each.matters]
    own = int(np.searchsorted(whole.model.kinematics.masters, bending.mode))
    return MastersChoice(with_masters(whole, np.sort([own, *kept])), _words(found))


@dataclass(frozen=True, slots=True)
class _Change:
    """What a mode changes as a master.

    Attributes:
        place: Its place among the masters tried.
        number: Its number, from 1.
        frequency: Relative change of the frequency.
    """

    place: int
    number: int
    frequency: float

    @property
    def matters(self) -> bool:
        """Whether it must be one."""
        return self.frequency > FREQUENCY_CHANGE

    def __str__(self) -> str:
        return f"mode {self.number} would change the frequency by {self.frequency:.1e}"


def _changes(whole: Reduction, along: Along) -> list[_Change]:
    """What each master but the followed one changes, largest first."""
    masters = whole.model.kinematics.masters
    own = int(np.searchsorted(masters, along.mode))
    found = []
    for place in (each for each in range(len(masters)) if each != own):
        pair = with_masters(whole, np.sort([own, place])).model
        change = along.bounce.frequency_change(along.closing_change(pair))
        found.append(_Change(place, int(masters[place]) + 1, change))
    return sorted(found, key=lambda each: -each.frequency)


def with_masters(reduction: Reduction, kept: Indices) -> Reduction:
    """A reduction with some of its masters alone, by their places among these, ascending."""
    model, pairs = reduction.model, Pairs.of(len(reduction.model.kinematics.masters))
    tensors = model.kinematics.tensors
    square, cube = np.ix_(kept, kept), np.ix_(kept, kept, kept, kept)
    order = SecondOrder(
        model.kinematics.masters[kept],
        Theta=tensors["Theta"][:, square[0], square[1]],
        alpha=tensors["alpha"][:, square[0], square[1]],
        beta=tensors["beta"][cube],
        D=tensors["D"][cube],
    )
    first, second = np.triu_indices(len(kept))
    columns = pairs.place[kept[first], kept[second]]
    bent_shapes = reduction.bent_shapes[:, columns]
    return replace(reduction, model=replace(model, kinematics=order), bent_shapes=bent_shapes)


def _expected(body: Bendable, bending: Bending, along: Along) -> Array:
    """About what each other mode changes of the frequency, (J,); rather more than less.

    The second-order displacement of two modes is taken to be that of the followed one times their
    displacements over its own, and the root of their frequencies over its own, as slopes of beams
    in bending are.
    """
    model, mode, a = bending.bent.model, along.mode, along.bounce.largest
    moved = body.interface.displacements(bending.straight.shapes)
    theta = body.interface.displacements(bending.bent.bent_shapes)[:, :, 0]
    largest = np.linalg.norm(moved, axis=1).max(axis=0)
    second = np.linalg.norm(theta, axis=1).max() * a**2 / 2 / float(model.gap[along.point])
    steeper = np.sqrt(np.maximum(model.omega / model.omega[mode], 1.0))
    shares = largest * along.amplitudes / (largest[mode] * a)
    shares[bending.straight.free :] = 0.0  # shapes of springs are no modes
    return np.array([along.bounce.frequency_change(2 * second * each) for each in steeper * shares])


def _words(found: Sequence[_Change]) -> str:
    """Why these masters."""
    told = [str(each) for each in found if each.matters]
    if told:
        return f"as masters {', '.join(told)}"
    return f"as a master {found[0]}, no other one more"
