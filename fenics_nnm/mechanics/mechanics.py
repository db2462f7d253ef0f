"""What a motion obeys: model, state of rest, linear part, forces, excitation."""

from __future__ import annotations

from dataclasses import dataclass, field

from fenics_nnm.mechanics.excitation import Excitation
from fenics_nnm.mechanics.force import Force, PeriodicForce
from fenics_nnm.mechanics.linear_part import LinearPart, ModalPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.moving_gap import STILL, GapMotion
from fenics_nnm.mechanics.rest import RestState
from fenics_nnm.mechanics.turned_force import TurnedForce


@dataclass(frozen=True, slots=True)
class Mechanics:
    """A reduced model with all that acts on it.

    Attributes:
        model: Reduced model.
        rest: Its state of rest, and linear modes about it.
        linear: What harmonics see linearly.
        forces: Forces besides contact that the motion determines.
        excitations: Given forces; a motion without any, and with gaps that stand still, is free.
        gap_motion: How gaps move.
        turned: What given forces that turn with the motion add to those; one, or none.
    """

    model: ReducedModel
    rest: RestState
    linear: LinearPart
    forces: tuple[Force, ...] = ()
    excitations: tuple[Excitation, ...] = ()
    gap_motion: GapMotion = STILL
    turned: tuple[TurnedForce, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        turning = tuple(each for each in self.excitations if each.turning.any())
        force = TurnedForce(self.model.kinematics.masters, turning)
        object.__setattr__(self, "turned", (force,) if turning else ())

    @classmethod
    def of(cls, model: ReducedModel, forces: tuple[Force, ...] = ()) -> Mechanics:
        """A free, conservative structure under the forces of its kinematics, and others.

        Raises:
            ModelError: if a gap is not positive where contact points carry mass.
        """
        own = model.kinematics.forces
        return cls(model, model.at_rest(), ModalPart(model.omega), (*own, *forces))

    @property
    def acting(self) -> tuple[PeriodicForce, ...]:
        """All forces besides contact of which harmonics follow from those of the motion."""
        return (*self.forces, *self.turned)

    @property
    def free(self) -> bool:
        """Whether nothing drives the motion: a shift in time gives another motion then."""
        return not self.excitations and not self.gap_motion.moves
