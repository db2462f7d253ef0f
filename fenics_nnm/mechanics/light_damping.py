r"""What light damping takes from an undamped motion, and the force that would keep it up.

To first order in the damping a motion in phase resonance is the undamped one: the force puts in
over a period what damping takes out (energy balance of T. L. Hill, A. Cammarano, S. A. Neild and
D. J. Wagg, *Proc. R. Soc. A* **471** (2015) 20140908). With the coefficients q_n of harmonic n,

    P = sum_n <n^2 omega^2 q_n^T C q_n + n omega q_n^T H q_n>,    H = eta Lambda

is the dissipated power, and a modal force p of harmonic h in phase with the velocity gives h omega
|p . q_h| / 2 of it for each unit of its level.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Complex
from fenics_nnm.mechanics.fourier import Series

#: A force whose work is below this part of what it may be at most is across the motion.
_NOTHING = 1e-9

#: Of the coefficients of cosine and sine of a harmonic.
_PHASES = np.array([1.0, -1j])


@dataclass(frozen=True, slots=True)
class Sustained:
    """How a motion is kept up against damping.

    Attributes:
        ratio: Damping ratio: dissipated power over 4 omega times the mean kinetic energy, zeta of a
            linear mode.
        force: Size of the force in N, 0-peak, in phase resonance; nan without one.
        exact: Whether the motion is the damped one itself; else it is the undamped one, and both
            numbers are of first order in the damping.
    """

    ratio: float
    force: float
    exact: bool = False


@dataclass(frozen=True, slots=True)
class LightDamping:
    """Damping of a structure, and a force that may keep its motions up.

    Attributes:
        rate: C in 1/s, shape (J, J).
        loss: H in 1/s^2, shape (J, J).
        push: Complex amplitude of the modal force of level 1, kg^-1/2 N, shape (J,); 0 for none.
        size: Size of the first force of level 1 in N.
        harmonic: Its harmonic h.
    """

    rate: Array
    loss: Array
    push: Complex
    size: float
    harmonic: int = 1

    def of(self, series: Series, q: Array, omega: float) -> Sustained:
        """How a motion is kept up.

        Args:
            series: Series in time.
            q: Coefficients in kg^1/2 m, shape (c, J).
            omega: Circular frequency in rad/s.
        """
        turns = omega * series.order[:, None]
        speed = turns * q
        lost = np.sum(speed * (speed @ self.rate.T), axis=1) + np.sum(speed * (q @ self.loss.T), 1)
        power = float(series.mean_square @ lost)
        kinetic = float(series.mean_square @ np.sum(speed**2, axis=1)) / 2
        own = q[series.order == self.harmonic]
        met = float(np.abs(self.push.conj() @ (own.T @ _PHASES[: len(own)])))
        least = _NOTHING * float(np.linalg.norm(self.push) * np.linalg.norm(own))
        given = self.harmonic * omega * met / 2 if met > least else 0.0
        return Sustained(
            ratio=power / (4 * omega * kinetic) if kinetic else float("nan"),
            force=self.size * power / given if given else float("nan"),
        )
