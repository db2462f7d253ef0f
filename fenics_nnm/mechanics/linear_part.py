r"""What a harmonic sees linearly: stiffness and inertia, and terms of the velocity.

With the coefficients q_n of harmonic n the linear part of the equations of motion is

    (Lambda - n^2 omega^2) q_n + omega C q'_n,      q' the derivative by the phase,

with Lambda = diag(omega_j^2). `ModalPart` has C = 0 (conservative, without rotation), so that all
coefficients are independent; `RatedPart` has any C: damping, gyroscopic terms. Of cosines alone a
term of the velocity makes sines, so that needs a general series. A drift d adds d q', see
`nonlinear.equations`.

An operator is the linear part at one frequency. Coefficients q have the shape (c, J); where an
operator acts on several of them at once, the shape (.., c, J).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array, Complex, Indices, Mask
from fenics_nnm.mechanics.fourier import Series

#: Coordinates with a smaller |omega_j^2 - n^2 omega^2|, over the sum of the two, are kept.
_RESONANT = 1e-2

#: The skew part of C is round-off below this part of its largest entry.
_SKEW = 1e-9


class HarmonicOperator(Protocol):
    """Linear part at one frequency and drift."""

    @property
    def kept(self) -> Mask:
        """Coordinates that `solve` leaves out, being in resonance, shape (c, J)."""

    def times(self, q: Array) -> Array:
        """Product with coefficients, shape (.., c, J)."""

    def by_omega(self, q: Array) -> Array:
        """Derivative of the product by the frequency, shape (c, J)."""

    def add_to(self, matrix: Array) -> None:
        """Add it to a matrix with rows and columns by (n, j), shape (c J, c J)."""

    def solve(self, right: Array) -> Array:
        """Coefficients, zero where `kept`, with the right-hand sides elsewhere, (.., c, J)."""

    def keeping(self, more: Indices) -> HarmonicOperator:
        """The same with further coordinates that `solve` leaves out, of a separate part alone."""

    def flexibility(self, shapes: Array) -> Array:
        """Dynamic flexibility of n_a rows of shapes by the time difference in samples.

        Args:
            shapes: Displacement per modal coordinate, shape (n_a, J).

        Returns:
            sum_n shapes Z_n^-1 shapes^T cos(n t) / c_n and so on, shape (m, n_a^2).
        """


class LinearPart(Protocol):
    """Linear part of the equations of motion, at any frequency."""

    @property
    def reversible(self) -> bool:
        """Whether time-reversible motions stay so: it acts on cosines alone."""

    @property
    def separate(self) -> bool:
        """Whether it acts on each coordinate by itself, so that any of them can be kept."""

    @property
    def in_time(self) -> bool:
        """Whether it is that of equations in time, and not a law of harmonics alone."""

    @property
    def rate(self) -> Array:
        """C, what multiplies the velocities, in 1/s, shape (J, J)."""

    @property
    def gyroscopic(self) -> Array:
        """The part of it that is skew and does no work, shape (J, J)."""

    def at(self, series: Series, omega: float, drift: float = 0.0) -> HarmonicOperator:
        """The operator at a frequency and a drift."""


@dataclass(frozen=True, slots=True)
class ModalPart:
    """Conservative: Z_nj = omega_j^2 - n^2 omega^2 for each coefficient by itself.

    Attributes:
        omega: Natural circular frequencies, shape (J,).
    """

    omega: Array

    @property
    def reversible(self) -> bool:
        """Whether time-reversible motions stay so."""
        return True

    @property
    def separate(self) -> bool:
        """It does."""
        return True

    @property
    def in_time(self) -> bool:
        """It is."""
        return True

    @property
    def rate(self) -> Array:
        """Nothing multiplies the velocities."""
        return np.zeros((len(self.omega), len(self.omega)))

    @property
    def gyroscopic(self) -> Array:
        """Nothing."""
        return self.rate

    def at(self, series: Series, omega: float, drift: float = 0.0) -> ModalOperator:
        """The operator at a frequency and a drift."""
        stiffness = self.omega**2 - (series.order[:, None] * omega) ** 2
        scale = self.omega**2 + (series.order[:, None] * omega) ** 2
        return ModalOperator(series, omega, stiffness, np.abs(stiffness) < _RESONANT * scale, drift)


@dataclass(frozen=True, slots=True)
class ModalOperator:
    """The conservative part; with a drift its inverse is (Z - d rot) / (Z^2 + n^2 d^2).

    Attributes:
        series: Series in time.
        omega: Frequency.
        stiffness: Z, shape (c, J).
        kept: Coordinates in resonance, shape (c, J).
        drift: Drift d.
    """

    series: Series
    omega: float
    stiffness: Array
    kept: Mask
    drift: float

    def times(self, q: Array) -> Array:
        """Product with coefficients, shape (.., c, J)."""
        return self.stiffness * q + self._turned(q) if self.drift else self.stiffness * q

    def by_omega(self, q: Array) -> Array:
        """Derivative of the product by the frequency, shape (c, J)."""
        return -2 * self.omega * self.series.order[:, None] ** 2 * q

    def add_to(self, matrix: Array) -> None:
        """Add it to a matrix with rows and columns by (n, j)."""
        diagonal = np.arange(len(matrix))
        matrix[diagonal, diagonal] += self.stiffness.ravel()
        if self.drift:
            matrix += self.drift * np.kron(self.series.rotation(), np.eye(self.stiffness.shape[1]))

    def solve(self, right: Array) -> Array:
        """Coefficients, zero where `kept`, with the right-hand sides elsewhere, (.., c, J)."""
        if not self.drift:
            return np.where(self.kept, 0.0, self.stiffness * right / self._square)
        turned = self._turned(right)
        return np.where(self.kept, 0.0, (self.stiffness * right - turned) / self._square)

    def keeping(self, more: Indices) -> ModalOperator:
        """The same with further coordinates that `solve` leaves out."""
        kept = self.kept.copy()
        kept[:, more] = True
        return replace(self, kept=kept)

    def flexibility(self, shapes: Array) -> Array:
        """Dynamic flexibility by the time difference in samples, shape (m, n_a^2)."""
        series = self.series
        order = np.arange(series.harmonics + 1)
        rows, square = slice(len(order)), np.broadcast_to(self._square, self.kept.shape)
        inverse = np.where(self.kept, 0.0, 1 / square)[rows] / series.mean_square[rows, None]
        angle = np.outer(2 * np.pi / series.samples * np.arange(series.samples), order)
        even = (shapes * (inverse * self.stiffness[rows])[:, None]) @ shapes.T
        table = np.cos(angle) @ even.reshape(len(order), -1)
        if self.drift:
            odd = (shapes * inverse[:, None]) @ shapes.T
            table += (self.drift * order * np.sin(angle)) @ odd.reshape(len(order), -1)
        return np.asarray(table)

    @property
    def _square(self) -> Array:
        square = self.stiffness**2 + (self.drift * self.series.order[:, None]) ** 2
        return np.where(self.kept, 1.0, square)

    def _turned(self, q: Array) -> Array:
        return np.asarray(self.drift * (self.series.rotation() @ q))


@dataclass(frozen=True, slots=True)
class RatedPart:
    """With terms of the velocity: (Lambda - n^2 omega^2) q_n + omega C q'_n.

    Attributes:
        omega: Natural circular frequencies, shape (J,).
        rate: C, modal damping and gyroscopic matrix in 1/s, shape (J, J).
    """

    omega: Array
    rate: Array

    @property
    def separate(self) -> bool:
        """Terms of the velocity couple coordinates."""
        return False

    @property
    def in_time(self) -> bool:
        """It is."""
        return True

    @property
    def reversible(self) -> bool:
        """Whether time-reversible motions stay so: only without terms of the velocity."""
        return not self.rate.any()

    @property
    def gyroscopic(self) -> Array:
        """The skew part of C, nothing where that is round-off, shape (J, J)."""
        skew = (self.rate - self.rate.T) / 2
        round_off = _SKEW * np.abs(self.rate).max(initial=0.0)
        return np.where(np.abs(skew).max(initial=0.0) > round_off, skew, 0.0)

    def at(self, series: Series, omega: float, drift: float = 0.0) -> RatedOperator:
        """The operator at a frequency and a drift.

        Raises:
            ValueError: if the series has cosines alone: terms of the velocity make sines.
        """
        if not self.reversible and not series.free_phase:
            raise ValueError("terms of the velocity need a general series, with sines")
        return RatedOperator.of(self, series, omega, drift)


@dataclass(frozen=True, slots=True)
class RatedOperator:
    """With x_n = a_n - i b_n of a_n cos + b_n sin it is Z_n x_n, Z_n complex of size J.

    Z_n = Lambda - n^2 omega^2 + i n (omega C + d), n = 0..N. Nothing is kept: damping keeps Z_n
    away from singular.

    Attributes:
        series: Series in time, general.
        omega: Frequency.
        rate: C, shape (J, J).
        blocks: Z_n, shape (N + 1, J, J).
    """

    series: Series
    omega: float
    rate: Array
    blocks: Complex
    _inverse: list[Complex] = field(init=False, repr=False, compare=False, default_factory=list)

    @classmethod
    def of(cls, part: RatedPart, series: Series, omega: float, drift: float) -> RatedOperator:
        """The operator of a part."""
        order = np.arange(series.harmonics + 1)[:, None, None]
        unit = np.eye(len(part.omega))
        conservative = unit * (part.omega**2 - (order * omega) ** 2)
        return cls(
            series, omega, part.rate, conservative + 1j * order * (omega * part.rate + drift * unit)
        )

    @property
    def kept(self) -> Mask:
        """Coordinates that `solve` leaves out: none."""
        return np.zeros((len(self.series.order), self.blocks.shape[1]), dtype=bool)

    def times(self, q: Array) -> Array:
        """Product with coefficients, shape (.., c, J)."""
        return self._with(self.blocks, q)

    def by_omega(self, q: Array) -> Array:
        """Derivative of the product by the frequency, shape (c, J)."""
        order = np.arange(self.series.harmonics + 1)[:, None, None]
        unit = np.eye(self.blocks.shape[1])
        return self._with(-2 * self.omega * order**2 * unit + 1j * order * self.rate, q)

    def add_to(self, matrix: Array) -> None:
        """Add it to a matrix with rows and columns by (n, j)."""
        harmonics, modes = self.series.harmonics, self.blocks.shape[1]
        whole = matrix.reshape(2 * harmonics + 1, modes, 2 * harmonics + 1, modes)
        cosine = np.arange(harmonics + 1)
        sine = harmonics + cosine[1:]
        whole[cosine, :, cosine, :] += self.blocks.real
        whole[sine, :, sine, :] += self.blocks.real[1:]
        whole[cosine[1:], :, sine, :] += self.blocks.imag[1:]
        whole[sine, :, cosine[1:], :] -= self.blocks.imag[1:]

    def keeping(self, more: Indices) -> HarmonicOperator:
        """Refused."""
        raise TypeError("coordinates that are coupled cannot be kept alone")

    def solve(self, right: Array) -> Array:
        """Coefficients with the given right-hand sides, shape (.., c, J)."""
        return self._with(self._inverted, right)

    def flexibility(self, shapes: Array) -> Array:
        """Dynamic flexibility by the time difference in samples, shape (m, n_a^2)."""
        series = self.series
        order = np.arange(series.harmonics + 1)
        inverse = shapes @ self._inverted @ shapes.T
        inverse /= series.mean_square[: len(order), None, None]
        angle = np.outer(2 * np.pi / series.samples * np.arange(series.samples), order)
        by_time = np.exp(1j * angle) @ inverse.reshape(len(order), -1)
        return np.asarray(by_time.real)

    @property
    def _inverted(self) -> Complex:
        """Inverses of the blocks, which are made once."""
        if not self._inverse:
            self._inverse.append(np.linalg.inv(self.blocks))
        return self._inverse[0]

    def _with(self, blocks: Complex, q: Array) -> Array:
        """Product of complex blocks with coefficients, cosines then sines."""
        count, modes = self.series.harmonics + 1, q.shape[-1]
        motion = q[..., :count, :].astype(complex)
        motion[..., 1:, :] -= 1j * q[..., count:, :]
        columns = motion.reshape(-1, count, modes).transpose(1, 2, 0)
        moved = (blocks @ columns).transpose(2, 0, 1).reshape(motion.shape)
        return np.concatenate([moved.real, -moved.imag[..., 1:, :]], axis=-2)
