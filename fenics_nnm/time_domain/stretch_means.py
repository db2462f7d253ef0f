r"""Integrals over the motion between two changes of contact, and their derivatives by its start.

Each component of the motion is a sum of exponentials, z_k = a_k exp(d_k t) + sum_f c_kf exp(i nu_f
t), so that with their exponents s_m, the displacement along p as Re(sum_m u_m exp(s_m t)) + p .
rest and the velocity as Re(sum_m v_m exp(s_m t)),

    int (p . q - p . rest) exp(i omega t) = 1/2 sum_m u_m I(s_m + i omega) + u*_m I(s*_m + i omega)
    int |q'|^2 = 1/2 Re sum_mn (v_m* . v_n) I(s*_m + s_n) + (v_m . v_n) I(s_m + s_n)

with I(s) = (exp(s T) - 1) / s in closed form. The start z(0) is in a alone, whose derivative by it
is 1. Where components do not move by themselves (critical damping), or the force is in resonance
with one that has no damping, Gauss' rule does the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.time_domain.damped_flow import Stretch
from fenics_nnm.time_domain.quadrature import Panels

#: Panels of Gauss' rule last for so many times those that integrate to the last digit: 1e-10 left.
_LONGER = 3.0

#: Closer to resonance than this over the time, too many digits are lost.
_RESONANT = 1e-4


def integrals(stretch: Stretch, omega: float, push: Array) -> Array:
    """Integrals of p . q sin and cos(omega t), and |q'|^2 over a stretch, shape (3,)."""
    if not _in_closed_form(stretch):
        return _by_quadrature(stretch, omega, push)
    waves = _Waves.of(stretch, push)
    s, u, v, time = waves.exponents, waves.along, waves.velocity, stretch.duration
    turned = u @ _integral(s + 1j * omega, time)
    turned += u.conj() @ _integral(s.conj() + 1j * omega, time)
    still = waves.rest * _integral(np.array([1j * omega]), time)[0]
    whole = np.exp(1j * omega * stretch.clock) * (turned / 2 + still)
    squared = np.sum((v.conj().T @ v) * _integral(np.add.outer(s.conj(), s), time))
    squared += np.sum((v.T @ v) * _integral(np.add.outer(s, s), time))
    return np.array([whole.imag, whole.real, float(squared.real) / 2])


def gradients_of(stretch: Stretch, omega: float, push: Array) -> Array:
    """Derivatives of the first and the last of them by the state at its start, shape (2, 2 J)."""
    if not _in_closed_form(stretch):
        return _gradients_by_quadrature(stretch, omega, push)
    waves, time, stage = _Waves.of(stretch, push), stretch.duration, stretch.motion.stage
    d, s, v, start = (
        stage.propagator.exponents,
        waves.exponents,
        waves.velocity,
        omega * stretch.clock,
    )
    ahead = np.exp(1j * start) * _integral(d + 1j * omega, time)
    behind = np.exp(-1j * start) * _integral(d - 1j * omega, time)
    across = waves.by_z * (ahead - behind) / 2j
    products = waves.velocity_by_z.T @ v.conj() * _integral(np.add.outer(d, s.conj()), time)
    products += waves.velocity_by_z.T @ v * _integral(np.add.outer(d, s), time)
    rows = np.array([across, np.sum(products, axis=1)])
    return stretch.motion.by_start(rows)


def _integral(s: Complex, time: float) -> Complex:
    """I(s): the integral of exp(s t)."""
    still = np.abs(s) * time < np.finfo(float).tiny
    return np.where(still, time, np.expm1(time * s) / np.where(still, 1.0, s))


def _in_closed_form(stretch: Stretch) -> bool:
    """Whether the motion is a sum of exponentials that are told apart."""
    d, rates = stretch.motion.stage.propagator.exponents, stretch.motion.course.push.rates
    apart = np.abs(d[:, None] - 1j * rates) * stretch.duration
    return bool(d.size and apart.min(initial=np.inf) > _RESONANT)


@dataclass(frozen=True, slots=True)
class _Waves:
    """A motion as a sum of exponentials.

    Attributes:
        exponents: s, shape (m,).
        along: u, shape (m,).
        velocity: v, shape (J, m).
        rest: p . rest.
        by_z: Displacement along p by z, shape (K,).
        velocity_by_z: Velocity by z, shape (J, K).
    """

    exponents: Complex
    along: Complex
    velocity: Complex
    rest: float
    by_z: Complex
    velocity_by_z: Complex

    @classmethod
    def of(cls, stretch: Stretch, push: Array) -> _Waves:
        """That of a stretch, with its displacement along p."""
        stage, course = stretch.motion.stage, stretch.motion.course
        linear, d, modes = stage.linear, stage.propagator.exponents, len(push)
        by_z = (push @ linear.V / linear.nu) @ stage.basis[:modes]
        velocity_by_z = linear.V @ stage.basis[modes:]
        forced = course.push.amplitude / (1j * course.push.rates - d[:, None])
        z = np.hstack([np.diag(course.start - forced.sum(axis=1)), forced])
        exponents = np.concatenate([d, 1j * course.push.rates])
        rest = float(push @ linear.rest)
        return cls(exponents, by_z @ z, velocity_by_z @ z, rest, by_z, velocity_by_z)


def _panels(stretch: Stretch) -> Panels:
    """Times and weights in a stretch, for squares of its motion."""
    fastest = max(stretch.motion.stage.fastest, stretch.motion.driven)
    return Panels.over(stretch.duration, 2 * fastest / _LONGER)


def _by_quadrature(stretch: Stretch, omega: float, push: Array) -> Array:
    panels = _panels(stretch)
    q, velocity = stretch.motion.states(panels.times)
    phase, pushed = omega * (stretch.clock + panels.times), q @ push
    every = [pushed * np.sin(phase), pushed * np.cos(phase), np.sum(velocity**2, axis=1)]
    return np.asarray(np.array(every) @ panels.weights)


def _gradients_by_quadrature(stretch: Stretch, omega: float, push: Array) -> Array:
    panels = _panels(stretch)
    _, velocity = stretch.motion.states(panels.times)
    weights = panels.weights * np.sin(omega * (stretch.clock + panels.times))
    by_q, by_velocity = np.outer(weights, push), 2 * panels.weights[:, None] * velocity
    nothing = np.zeros_like(by_q)
    return np.array(
        [
            stretch.motion.gathered(by_q, nothing, panels.times),
            stretch.motion.gathered(nothing, by_velocity, panels.times),
        ]
    )
