"""Motion in time by steps, for models whose motion between changes of contact is not linear.

    M(q) q'' = -Lambda q - C q' - Psi^T lambda(p) - f(q, q')

with p = Phi q, Psi = Phi and M = 1, or those of second-order kinematics. With massless contact
points lambda is a continuous, piecewise linear function of p, so the right side is Lipschitz
continuous, and a Runge-Kutta method of order 8 with control of the error (DOP853, E. Hairer,
S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 1993; from SciPy) steps over
changes of contact: it shortens its steps there. The derivative along changes of the first state
follows from the variational equations, stepped with the motion.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy.integrate import DOP853

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.collocated import Collocated
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.integrator import Integrator, Trajectory
from fenics_nnm.time_domain.states import States


@dataclass(frozen=True, slots=True)
class Stepped:
    """Integrates a model with any forces.

    Attributes:
        mechanics: What a motion obeys; without excitation.
        tolerance: Error of a step, relative to the size of the motion in the energy norm.
        most_steps: A motion that needs more steps is given up.

    Raises:
        ModelError: if contact points carry mass, or points are pressed at rest.
    """

    mechanics: Mechanics
    tolerance: float = 1e-12
    most_steps: int = 200_000
    model: ReducedModel = field(init=False, repr=False, compare=False)
    states: States = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "states", States(self.mechanics))
        object.__setattr__(self, "model", self.mechanics.model)

    def run(
        self,
        q: Array,
        velocity: Array,
        span: float,
        *,
        times: Array | None = None,
        along: Array | None = None,
        speeds: bool = False,
    ) -> Trajectory:
        """Follow the motion from a state for a time; see `Integrator.run`."""
        wanted = np.empty(0) if times is None else np.asarray(times)
        columns = np.empty((2 * len(q), 0)) if along is None else along
        walk = _Walk(self, wanted, columns)
        if not np.all(np.isfinite([*q, *velocity, span])):
            return walk.trajectory(walk.first(q, velocity), "the state to start from is not finite")
        end, failure = walk.run(walk.first(q, velocity), span)
        found = walk.trajectory(end, failure)
        return found if along is not None else replace(found, derivative=None)

    @property
    def error(self) -> float:
        """Round-off: that of a period is not known from the errors of its steps."""
        return 1e-13

    @property
    def cheap(self) -> bool:
        """All motions are followed for ten periods."""
        return True

    @property
    def rough(self) -> Stepped:
        """Itself: it has one error."""
        return self

    def acceleration(self, q: Array, velocity: Array) -> Array:
        """Acceleration of a state, shape (J,)."""
        pull = self.states.conservative(q) + self.mechanics.linear.rate @ velocity
        pull = pull + sum(f.at(q, velocity) for f in self.mechanics.forces)
        return self.model.kinematics.inertia.accelerated(q, -pull[:, None])[:, 0]

    def energy_gradient(self, q: Array, velocity: Array) -> Array:
        """Derivative of the energy by q and velocity, shape (2 J,)."""
        return self.states.energy_gradient(q, velocity)

    def energy(self, q: Array, velocity: Array) -> float:
        """Total energy in J from the state of rest."""
        return self.states.energy(q, velocity)

    def tangent(self, q: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array]:
        """Derivatives of the acceleration by coordinates and velocities, each of shape (J, J)."""
        closing, inertia = self.model.kinematics.closing, self.model.kinematics.inertia
        contact = self.states.contact(q)
        by_q = np.diag(self.model.omega**2)
        by_q += contact.stiffness(closing.shapes_at(self.model.Phi, q)).sum(axis=0)
        by_q = closing.stiffened(by_q, contact.force[0])
        by_velocity = self.mechanics.linear.rate.copy()
        for force in self.mechanics.forces:
            one, other = force.tangent_at(q, velocity, acceleration)
            by_q, by_velocity = by_q + one, by_velocity + other
        return inertia.accelerated(q, -by_q), inertia.accelerated(q, -by_velocity)


@dataclass(slots=True)
class _Walk:
    """One integration: state (q, q', integral of |q'|^2, derivatives) and what is noted of it."""

    flow: Stepped
    times: Array
    along: Array
    changes: int = 0
    contact_time: float = 0.0
    q_at: Array = field(init=False)
    velocity_at: Array = field(init=False)

    def __post_init__(self) -> None:
        shape = len(self.times), self.flow.model.modes
        self.q_at, self.velocity_at = np.full(shape, np.nan), np.full(shape, np.nan)

    def first(self, q: Array, velocity: Array) -> Array:
        """State to begin with."""
        return np.concatenate([q, velocity, [0.0], self.along.ravel()])

    def run(self, state: Array, span: float) -> tuple[Array, str]:
        """The state after a time, or after the last step, and why it ended before."""
        self._note_start(state)
        if span == 0:
            return state, ""
        solver = DOP853(
            self._rate, 0.0, state, span, rtol=self.flow.tolerance, atol=self._absolute(state)
        )
        touched = self._touches(state)
        for _ in range(self.flow.most_steps):
            message = solver.step()
            if solver.status == "failed":
                return solver.y, f"the steps in time became too small: {message}"
            now = self._touches(solver.y)
            self.changes += int(np.count_nonzero(now != touched))
            self.contact_time += solver.step_size * np.mean([now.any(), touched.any()])
            touched = now
            self._note(solver)
            if solver.status == "finished":
                return solver.y, ""
        return solver.y, f"more than {self.flow.most_steps} steps in {solver.t:.3g} of {span:.3g} s"

    def trajectory(self, state: Array, failure: str) -> Trajectory:
        """The result, with the final state."""
        modes = self.flow.model.modes
        return Trajectory(
            q=state[:modes],
            velocity=state[modes : 2 * modes],
            changes=self.changes,
            contact_time=self.contact_time,
            q_at=self.q_at,
            velocity_at=self.velocity_at,
            speed_integral=float(state[2 * modes]),
            derivative=partial(np.reshape, state[2 * modes + 1 :], self.along.shape),
            failure=failure,
        )

    def _rate(self, time: float, state: Array) -> Array:
        modes = self.flow.model.modes
        q, velocity = state[:modes], state[modes : 2 * modes]
        square = np.array([velocity @ velocity])
        acceleration = self.flow.acceleration(q, velocity)
        rate = np.concatenate([velocity, acceleration, square])
        if not self.along.size:
            return rate
        by_q, by_velocity = self.flow.tangent(q, velocity, acceleration)
        moved = state[2 * modes + 1 :].reshape(self.along.shape)
        pulled = by_q @ moved[:modes] + by_velocity @ moved[modes:]
        return np.concatenate([rate, moved[modes:].ravel(), pulled.ravel()])

    def _absolute(self, state: Array) -> Array:
        """Errors allowed of each entry, from the size of the motion and of the derivatives."""
        omega, modes = self.flow.model.omega, self.flow.model.modes
        amplitude = np.sqrt(2 * self.flow.energy(state[:modes], state[modes : 2 * modes]))
        motion = np.concatenate([amplitude / omega, np.full(modes, amplitude), [amplitude**2]])
        scale = np.concatenate([1 / omega, np.ones(modes)])[:, None]
        size = np.max(np.abs(self.along / scale), axis=0, initial=1e-300)
        derivatives = np.broadcast_to(scale * size, self.along.shape)
        return np.asarray(self.flow.tolerance * np.concatenate([motion, derivatives.ravel()]))

    def _touches(self, state: Array) -> Array:
        return np.asarray(self.flow.states.contact(state[: self.flow.model.modes]).force[0] > 0)

    def _note_start(self, state: Array) -> None:
        modes = self.flow.model.modes
        at = self.times <= 0
        self.q_at[at], self.velocity_at[at] = state[:modes], state[modes : 2 * modes]

    def _note(self, solver: DOP853) -> None:
        at = (self.times > solver.t_old) & (self.times <= solver.t)
        if at.any():
            modes, states = self.flow.model.modes, solver.dense_output()(self.times[at]).T
            self.q_at[at], self.velocity_at[at] = states[:, :modes], states[:, modes : 2 * modes]


def integrator_of(mechanics: Mechanics) -> Integrator | None:
    """What follows free motions: exactly where contact alone makes them nonlinear, else by steps.

    Returns:
        None where contact points carry mass: what follows an impact is then not defined.
    """
    if not mechanics.model.massless:
        return None
    if not mechanics.forces:
        return Flow(mechanics.model)
    by_kinematics_alone = len(mechanics.forces) == len(mechanics.model.kinematics.forces)
    return Collocated(mechanics) if by_kinematics_alone else Stepped(mechanics)
