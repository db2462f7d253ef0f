r"""Motion of a damped, driven model in time, exact but for round-off.

    q'' + C q' + Lambda q + Phi^T lambda = p(t),

with C any matrix and p harmonics of a frequency, in which gaps may move, too: as `flow`, of stages
that are linear in between changes of contact. A stop that gives way, of stiffness k, is a contact
point with 1 / k more residual flexibility R.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.damped_stage import DampedMotion, DampedStage
from fenics_nnm.time_domain.drive import Drive
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.gap_energy import with_moved_gaps
from fenics_nnm.time_domain.integrator import Trajectory
from fenics_nnm.time_domain.record import Record
from fenics_nnm.time_domain.stage_book import StageBook


@dataclass(frozen=True, slots=True)
class Stretch:
    """The motion between two changes of contact.

    Attributes:
        motion: Motion from the start of the stretch.
        clock: Time at its start in s.
        duration: How long it lasts in s.
    """

    motion: DampedMotion
    clock: float
    duration: float


@dataclass(frozen=True, slots=True)
class DampedFlow:
    """The flow of a damped, driven model with massless contact points; it keeps its stages.

    Attributes:
        model: Reduced model, R > 0.
        rate: C in 1/s, shape (J, J).
        drive: Harmonic forces, and motions of the gaps.
        most_changes: A motion with more changes of contact than this is given up.

    Raises:
        ModelError: if contact points carry mass: what follows an impact is then not defined.
    """

    model: ReducedModel
    rate: Array
    drive: Drive
    most_changes: int = 20_000
    book: StageBook[DampedStage] = field(init=False, repr=False, compare=False)
    conservative: Flow = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        model, rate = self.model, self.rate
        moves = np.hstack([model.Phi, -np.eye(model.points)])
        book = StageBook(model, moves, lambda active: DampedStage.of(model, rate, active))
        object.__setattr__(self, "book", book)
        object.__setattr__(self, "conservative", Flow(self.model))

    @classmethod
    def of(cls, mechanics: Mechanics, omega: float) -> DampedFlow:
        """The flow of what a motion obeys, driven at a circular frequency in rad/s.

        Raises:
            ModelError: if contact points carry mass, or forces besides contact depend on the
                motion: it is not linear between changes of contact then.
        """
        if mechanics.forces:
            raise ModelError(
                "springs that are not linear, or large deflection: a driven motion in time needs "
                "linear equations between changes of contact"
            )
        model = mechanics.model
        drive = Drive.of(omega, mechanics.excitations, model.modes, mechanics.gap_motion)
        return cls(model, mechanics.linear.rate, drive)

    def at(self, omega: float) -> DampedFlow:
        """The same, with its stages, driven at another circular frequency in rad/s."""
        return self.driven_by(self.drive.at(omega))

    def driven_by(self, drive: Drive) -> DampedFlow:
        """The same, with its stages, under other forces."""
        other = replace(self, drive=drive)
        object.__setattr__(other, "book", self.book)
        object.__setattr__(other, "conservative", self.conservative)
        return other

    def run(
        self,
        q: Array,
        velocity: Array,
        span: float,
        *,
        times: Array | None = None,
        along: Array | None = None,
        speeds: bool = False,
        phase: float = 0.0,
    ) -> Trajectory:
        """Follow the motion from a state for a time; see `Integrator.run`.

        Args:
            q: Modal coordinates, shape (J,).
            velocity: Their velocities, shape (J,).
            span: Time in s, not negative.
            times: Ascending times from 0 to `span` at which the state is wanted.
            along: Changes of the first state, shape (2 J, c).
            speeds: Whether the integral of |velocity|^2 is wanted.
            phase: Phase omega t of the force at the start.
        """
        record = Record(times, self.model.modes, along, speeds=speeds)
        if not np.all(np.isfinite([*q, *velocity, span])):
            return record.trajectory(q, velocity, 0, "the state to start from is not finite")
        changes, clock = -1, 0.0
        for stretch in self.stretches(q, velocity, span, phase):
            record.note(stretch.motion, stretch.clock, stretch.duration)
            q, velocity = stretch.motion.state(stretch.duration)
            clock, changes = stretch.clock + stretch.duration, changes + 1
        failure = ""
        if clock < span:
            failure = f"more than {changes} changes of contact in {clock:.3g} of {span:.3g} s"
        return record.trajectory(q, velocity, changes, failure)

    def stretches(
        self, q: Array, velocity: Array, span: float, phase: float = 0.0
    ) -> Iterator[Stretch]:
        """The motion from a state, from change to change of contact, for a time."""
        clock, stage = 0.0, None
        for _ in range(self.most_changes + 1):
            turned = phase + self.drive.omega * clock
            gap, gap_rate = self.drive.gap_at(turned, self.model.points)
            stage = self.book.after(
                np.concatenate([q, gap]), np.concatenate([velocity, gap_rate]), stage
            )
            motion = stage.motion(q, velocity, self.drive, turned)
            duration = motion.end(2 * self.book.moment, span - clock)
            yield Stretch(motion, clock, duration)
            q, velocity = motion.state(duration)
            clock += duration
            if clock >= span:
                return

    def forces(self, q: Array, phase: Array | float = 0.0) -> Array:
        """Contact forces in N at states of shape (s, J), and one phase or (s,), shape (s, n_c)."""
        moved = np.broadcast_to(self.drive.gap.at(phase), (len(q), self.model.points))
        return self.book.forces(np.hstack([q, moved]))

    @property
    def error(self) -> float:
        """Round-off."""
        return 1e-13

    @property
    def cheap(self) -> bool:
        """All motions are followed for ten periods."""
        return True

    @property
    def rough(self) -> DampedFlow:
        """Itself: it is as cheap as it can be."""
        return self

    def acceleration(self, q: Array, velocity: Array, phase: float = 0.0) -> Array:
        """Acceleration p - C q' - omega^2 q - Phi^T lambda(q) at a phase, shape (J,)."""
        pull = self.model.omega**2 * q + self.forces(q[None], phase)[0] @ self.model.Phi
        return np.asarray(self.drive.force(phase) - pull - self.rate @ velocity)

    def energy_gradient(self, q: Array, velocity: Array) -> Array:
        """Derivative of the energy by q and velocity, of gaps that stand still, shape (2 J,)."""
        return self.conservative.energy_gradient(q, velocity)

    def energy(self, q: Array, velocity: Array, phase: float = 0.0) -> float:
        """Total energy in J from the state of rest, without the potential of the drive.

        Of contact points it is that of their residual flexibility, lambda^T R lambda / 2.
        """
        own = self.conservative.energy(q, velocity)
        return with_moved_gaps(
            own,
            self.model.R,
            self.drive,
            phase,
            lambda moved: self.book.forces(np.concatenate([q, moved])[None])[0],
        )
