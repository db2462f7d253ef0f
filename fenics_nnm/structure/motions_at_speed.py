"""Nonlinear motions of a structure at a speed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fenics_nnm.structure.bending import Bendable
    from fenics_nnm.study import MeshStudy


class Quantity(Enum):
    """What a nonlinear line of a Campbell diagram keeps over the speed."""

    ENERGY = "energy"
    AMPLITUDE = "amplitude"

    @property
    def unit(self) -> str:
        """Unit of its values."""
        return "J" if self is Quantity.ENERGY else "m"


@dataclass(frozen=True, slots=True)
class Target:
    """A nonlinear line that is asked for.

    Attributes:
        quantity: What it keeps over the speed.
        value: Its value, energy in J or largest displacement in m.
    """

    quantity: Quantity
    value: float

    def __str__(self) -> str:
        """Its value with its unit."""
        return f"{self.value:g} {self.quantity.unit}"


def ascending(energies: Iterable[float], amplitudes: Iterable[float]) -> tuple[Target, ...]:
    """Lines of energies in J, then of largest displacements in m, each from the smallest."""
    return (
        *(Target(Quantity.ENERGY, float(value)) for value in sorted(energies)),
        *(Target(Quantity.AMPLITUDE, float(value)) for value in sorted(amplitudes)),
    )


@dataclass(frozen=True, slots=True)
class ReachedByTargets:
    """Largest energy of nonlinear lines, which decides about the kinematics of a body.

    Attributes:
        targets: The lines.
    """

    targets: Sequence[Target]

    def __call__(self, study: MeshStudy, linear: Bendable) -> float:
        """Its ratio to that of grazing with linear kinematics; to be called on all ranks."""
        mode = study.mode.number - 1
        rest = linear.model.at_rest()
        amplitude, shape = rest.amplitude(mode), rest.shapes[:, mode]
        grazing = {
            Quantity.ENERGY: float(rest.omega[mode] * amplitude) ** 2 / 2,
            Quantity.AMPLITUDE: linear.largest_displacement(
                amplitude * shape, amplitude * rest.pull[:, mode]
            ),
        }
        powers = {Quantity.ENERGY: 1, Quantity.AMPLITUDE: 2}
        ratios = [(e.value / grazing[e.quantity]) ** powers[e.quantity] for e in self.targets]
        return max(ratios)


@dataclass(frozen=True, slots=True)
class MotionAtSpeed:
    """A point of a nonlinear line.

    Attributes:
        target: The line.
        status: Status of the motion, see `backbone.point`; "failed" if there is none.
        reason: Why the motion failed, or is missing; empty otherwise.
        energy: Energy in J.
        amplitude: Largest displacement of any node in m.
        frequency: Frequency in Hz.
    """

    target: Target
    status: str
    reason: str = ""
    energy: float = float("nan")
    amplitude: float = float("nan")
    frequency: float = float("nan")

    @property
    def failed(self) -> bool:
        """Whether it is no motion to be shown."""
        return bool(self.reason)
