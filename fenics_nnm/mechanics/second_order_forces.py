r"""Forces of second-order kinematics: polynomial stiffness, and inertia of the displacement.

Both are cubic in the coordinates, so their harmonics 0..N are exact in 4 N + 1 samples, however
many a series has. See `mechanics.second_order` for the symbols.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.cubic_samples import CubicSamples
from fenics_nnm.mechanics.force import SampledMotion
from fenics_nnm.mechanics.master_tangent import MasterTangent


@dataclass(frozen=True, slots=True)
class PolynomialStiffness:
    r"""The force of the potential 1/3 alpha q^3 + alpha_a q_a q^2 + 1/4 beta q^4.

    Attributes:
        masters: Places of the masters among the coordinates, shape (k,).
        alpha: Quadratic forces on all coordinates, shape (J, k, k).
        beta: Cubic forces on the masters, shape (k, k, k, k).
    """

    masters: Indices
    alpha: Array
    beta: Array
    _coupled: Array = field(init=False, repr=False, compare=False)
    _by_master: Array = field(init=False, repr=False, compare=False)
    _of_master: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        coupled, k = self.alpha.copy(), len(self.masters)
        coupled[self.masters] = 0.0
        # derivatives 2 alpha_ajk q_k by master j, and of what acts on master j, rows k
        by_master, of_master = (2 * each.transpose(2, 0, 1) for each in (self.alpha, coupled))
        object.__setattr__(self, "_coupled", coupled)
        object.__setattr__(self, "_by_master", by_master.reshape(k, -1))
        object.__setattr__(self, "_of_master", of_master.swapaxes(1, 2).reshape(k, -1))

    def harmonics(self, motion: SampledMotion) -> Array:
        """Harmonics of the force, shape (c, J)."""
        assert_enough_samples(motion)
        samples, own = CubicSamples.of(motion.series), self.masters
        masters, shared = self._sampled(samples, motion.q)
        pairs = _pairs(masters)
        force = (samples.analysis @ pairs) @ self.alpha.reshape(len(self.alpha), -1).T
        shared = 2 * shared + _squared(self.beta, pairs)
        force[:, own] += samples.analysis @ (shared @ masters[:, :, None])[:, :, 0]
        return np.asarray(force)

    def tangent(self, motion: SampledMotion) -> Array:
        """Derivative: sum_k A_nk (df / dq)_k S_kn', whose columns or rows are of masters."""
        return self.master_tangent(motion).whole

    def master_tangent(self, motion: SampledMotion) -> MasterTangent:
        """The same by its columns and rows."""
        samples, k, own = CubicSamples.of(motion.series), len(self.masters), self.masters
        c, modes = motion.q.shape
        masters, shared = self._sampled(samples, motion.q)
        slopes = 2 * shared + 3 * _squared(self.beta, _pairs(masters))
        both = np.concatenate([masters[:, None], slopes], axis=1)
        found = samples.tangent(both[None], motion.omega)
        # harmonics n of the products of harmonic n' with master j, by (n, n'), j
        products = found[:, 0].reshape(c**2, k)
        columns = (products @ self._by_master).reshape(c, c, modes, k).swapaxes(1, 2)
        columns[:, own] += found[:, 1:]
        rows = (products @ self._of_master).reshape(c, c, k, modes).swapaxes(1, 2)
        return MasterTangent(own, columns.reshape(c * modes, -1), rows.reshape(c * k, -1))

    def by_omega(self, motion: SampledMotion) -> Array:
        """It does not depend on the frequency."""
        return np.zeros_like(motion.q)

    def mean_virial(self, motion: SampledMotion) -> float:
        """Mean of the force times the coordinates."""
        return _mean_product(motion, self.harmonics(motion))

    def mean_energy(self, motion: SampledMotion) -> float:
        """Mean of the potential."""
        samples = CubicSamples.of(motion.series)
        return float(samples.weight @ self._potentials(samples.basis[0] @ motion.q))

    def at(self, q: Array, velocity: Array) -> Array:
        """The force at states, shape (.., J)."""
        return self._values(q.reshape(-1, q.shape[-1])).reshape(q.shape)

    def tangent_at(self, q: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array]:
        """Its derivatives by coordinates and velocities at states."""
        shape, own = (*q.shape, q.shape[-1]), self.masters
        by_master, of_master = self._slopes(q.reshape(-1, q.shape[-1]))
        by_q = np.zeros((len(by_master), *shape[-2:]))
        by_q[:, :, own] = by_master
        by_q[:, own] += of_master
        return by_q.reshape(shape), np.zeros(shape)

    def energy_at(self, q: Array, velocity: Array) -> Array:
        """Its potential at coordinates of shape (.., J), shape (..)."""
        return self._potentials(q.reshape(-1, q.shape[-1])).reshape(q.shape[:-1])

    def _values(self, q: Array) -> Array:
        """Forces of states, both of shape (s, J)."""
        masters, pairs = q[:, self.masters], _pairs(q[:, self.masters])
        force = pairs @ self.alpha.reshape(len(self.alpha), -1).T
        shared = 2 * _coupling(self._coupled, q) + _squared(self.beta, pairs)
        force[:, self.masters] += (shared @ masters[:, :, None])[:, :, 0]
        return np.asarray(force)

    def _slopes(self, q: Array) -> tuple[Array, Array]:
        """Derivatives of the force by masters (s, J, k), and of that on masters by others."""
        masters, own = q[:, self.masters], self.masters
        states, modes, k = len(q), len(self.alpha), len(own)
        by_master = (masters @ self._by_master).reshape(states, modes, k)
        squared = _squared(self.beta, _pairs(masters))
        by_master[:, own] += 2 * _coupling(self._coupled, q) + 3 * squared
        return by_master, (masters @ self._of_master).reshape(states, k, modes)

    def _potentials(self, q: Array) -> Array:
        """Potentials of states (s, J), shape (s,)."""
        masters, pairs = q[:, self.masters], _pairs(q[:, self.masters])
        quadratic = pairs @ self.alpha.reshape(len(self.alpha), -1).T
        share = np.ones(len(self.alpha))
        share[self.masters] = 1 / 3
        cubic = np.sum(quadratic * q * share, axis=1)
        quartic = np.einsum("si,sij,sj->s", masters, _squared(self.beta, pairs), masters)
        return np.asarray(cubic + quartic / 4)

    def _sampled(self, samples: CubicSamples, q: Array) -> tuple[Array, Array]:
        """Masters, and `_coupling`, at the samples of coefficients (c, J)."""
        k, basis = len(self.masters), samples.basis[0]
        coupling = q @ self._coupled.reshape(len(self._coupled), -1)
        return basis @ q[:, self.masters], (basis @ coupling).reshape(-1, k, k)


def _coupling(coupled: Array, q: Array) -> Array:
    """Sum of alpha_ajk q_a over all a that are no masters, shape (s, k, k)."""
    k = coupled.shape[-1]
    return (q @ coupled.reshape(-1, k**2)).reshape(-1, k, k)


def _squared(beta: Array, pairs: Array) -> Array:
    """Cubic stiffness beta_ijkl q_k q_l, shape (s, k, k)."""
    k = len(beta)
    return (pairs @ beta.reshape(k**2, k**2)).reshape(-1, k, k)


@dataclass(frozen=True, slots=True)
class InertialForce:
    r"""The inertial force D_ikjl q_k (q_j'' q_l + q_j' q_l') of M(q) = 1 + D q q.

    Attributes:
        masters: Places of the masters among the coordinates, shape (k,).
        D: Inertia of the second-order displacement, shape (k, k, k, k).
    """

    masters: Indices
    D: Array

    def harmonics(self, motion: SampledMotion) -> Array:
        """Harmonics of the force, shape (c, J)."""
        assert_enough_samples(motion)
        whole, samples = np.zeros_like(motion.q), CubicSamples.of(motion.series)
        whole[:, self.masters] = samples.analysis @ self._values(self._states(motion))
        return whole

    def tangent(self, motion: SampledMotion) -> Array:
        """Derivative by displacement, velocity and acceleration at the samples."""
        return self.master_tangent(motion).whole

    def master_tangent(self, motion: SampledMotion) -> MasterTangent:
        """The same by its columns and rows."""
        slopes = np.array(self._slopes(self._states(motion)))
        own = CubicSamples.of(motion.series).tangent(slopes, motion.omega)
        return MasterTangent.between(self.masters, motion.q.shape[1], own)

    def by_omega(self, motion: SampledMotion) -> Array:
        """The force grows with the square of the frequency."""
        return 2 / motion.omega * self.harmonics(motion)

    def mean_virial(self, motion: SampledMotion) -> float:
        """Mean of the force times the coordinates."""
        return _mean_product(motion, self.harmonics(motion))

    def mean_energy(self, motion: SampledMotion) -> float:
        """Mean kinetic energy of the second-order displacement."""
        q, velocity, _ = self._states(motion)
        return float(CubicSamples.of(motion.series).weight @ self._energies(q, velocity))

    def at(self, q: Array, velocity: Array) -> Array:
        """The force at states, without the part of the acceleration, shape (.., J)."""
        k = len(self.masters)
        own, rate = (each[..., self.masters].reshape(-1, k) for each in (q, velocity))
        force = np.zeros_like(q)
        found = self._values((own, rate, np.zeros_like(own)))
        force[..., self.masters] = found.reshape(*q.shape[:-1], k)
        return force

    def tangent_at(self, q: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array]:
        """Derivatives of the whole force by coordinates and velocities."""
        k, modes, own = len(self.masters), q.shape[-1], self.masters
        states = [each[..., own].reshape(-1, k) for each in (q, velocity, acceleration)]
        found = []
        for block in self._slopes((states[0], states[1], states[2]))[:2]:
            whole = np.zeros((*q.shape, modes))
            whole[..., own[:, None], own] = block.reshape(*q.shape[:-1], k, k)
            found.append(whole)
        return found[0], found[1]

    def energy_at(self, q: Array, velocity: Array) -> Array:
        """Kinetic energy of the second-order displacement at states of shape (.., J)."""
        k = len(self.masters)
        own, rate = (each[..., self.masters].reshape(-1, k) for each in (q, velocity))
        return self._energies(own, rate).reshape(q.shape[:-1])

    def _states(self, motion: SampledMotion) -> tuple[Array, Array, Array]:
        """Displacement, velocity and acceleration of the masters at the samples, each (s, k)."""
        samples = CubicSamples.of(motion.series)
        return samples.states(motion.q[:, self.masters], motion.omega)

    def _inner(self, states: tuple[Array, Array, Array]) -> Array:
        """G_ik = D_ikjl (q_j'' q_l + q_j' q_l'), shape (s, k, k)."""
        q, velocity, acceleration = states
        pairs = acceleration[:, :, None] * q[:, None, :]
        pairs += velocity[:, :, None] * velocity[:, None, :]
        k = len(self.masters)
        return (pairs.reshape(len(q), -1) @ self.D.reshape(k**2, -1).T).reshape(-1, k, k)

    def _values(self, states: tuple[Array, Array, Array]) -> Array:
        """Forces on the masters, shape (s, k)."""
        return np.asarray((self._inner(states) @ states[0][:, :, None])[:, :, 0])

    def _slopes(self, states: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        """Derivatives by displacement, velocity and acceleration, each (s, k, k)."""
        q, velocity, acceleration = states
        k = len(self.masters)
        # D_ikjn a_k b_j by pairs (k, j), and D_iknl a_k b_l by pairs (k, l)
        by_pairs = self.D.transpose(1, 2, 0, 3).reshape(k**2, -1)
        across = self.D.transpose(1, 3, 0, 2).reshape(k**2, -1)
        found = (
            _products(q, acceleration) @ by_pairs,
            2 * _products(q, velocity) @ by_pairs,
            _products(q, q) @ across,
        )
        by_q, by_velocity, by_acceleration = (each.reshape(-1, k, k) for each in found)
        return self._inner(states) + by_q, by_velocity, by_acceleration

    def _energies(self, q: Array, velocity: Array) -> Array:
        """1/2 D_ikjl q_i' q_k q_j' q_l, shape (s,)."""
        rates = (velocity[:, :, None] * q[:, None, :]).reshape(len(q), -1)
        return np.asarray(np.sum((rates @ self.D.reshape(rates.shape[1], -1)) * rates, axis=1) / 2)


def _pairs(masters: Array) -> Array:
    """Products of masters (s, k), shape (s, k^2)."""
    return _products(masters, masters)


def _products(one: Array, other: Array) -> Array:
    """Products of entries of vectors (s, k), shape (s, k^2)."""
    return (one[:, :, None] * other[:, None, :]).reshape(len(one), -1)


def _mean_product(motion: SampledMotion, force: Array) -> float:
    """Mean over the period of the coordinates times harmonics of a force (Parseval)."""
    return float(motion.series.mean_square @ np.sum(motion.q * force, axis=1))


def assert_enough_samples(motion: SampledMotion) -> None:
    """Refuse a series in which cubic forces are not exact.

    Raises:
        ModelError: if there are not more than 4 N samples.
    """
    series = motion.series
    if series.samples <= 4 * series.harmonics:
        raise ModelError(
            f"samples = {series.samples} with harmonics = {series.harmonics}: must be above 4 "
            "harmonics with second-order kinematics, whose forces have three times as many"
        )
