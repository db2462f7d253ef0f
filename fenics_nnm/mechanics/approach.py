r"""How near a linear motion brings places of a structure to their obstacles, contact points or not.

A place v of the structure, with its direction and gap, moves by

    w_v = Phi_v q - R_v lambda

towards its obstacle, with R_v the residual flexibility between the place and the contact points.
About the state of rest q_s, lambda_s a linear mode of shape x and amplitude a has

    w_v = Phi_v q_s - R_v lambda_s + a cos(nu t) (Phi_v x - R_v pull),

so a place with the clearance c_v at rest meets its obstacle at the amplitude c_v / |motion_v|, and
where the closing is quadratic in the amplitude at the smaller root, see `mechanics.reach`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fenics_nnm.arrays import Array, Indices, Mask
from fenics_nnm.mechanics.reach import reach
from fenics_nnm.mechanics.rest import RestState

#: Clearance below this part of the largest gap is none.
_ROUND_OFF = 1e-9

#: A place that moves less than this part of the largest motion holds still.
_STILL = 1e-10

#: Places between contact points may lie beyond the obstacle by this part of the interference.
_BETWEEN_POINTS = 0.05


@dataclass(frozen=True, slots=True)
class Approach:
    """Clearance and motion of places.

    Attributes:
        clearance: Distance from the obstacle at rest in m, not positive where a place touches it or
            lies beyond it, infinite where there is nothing to be met anew, shape (n,).
        motion: Displacement towards the obstacle per unit of the mode, 0 where it holds still,
            shape (n,).
        curvature: Second derivative of the closing by the amplitude, 0 in linear kinematics, shape
            (n,) or ().
    """

    clearance: Array
    motion: Array
    curvature: Array = field(default_factory=lambda: np.zeros(()))

    @classmethod
    def of_mode(cls, gap: Array, Phi: Array, mode: int) -> Approach:
        """The approach of a linear mode where nothing touches at rest.

        Args:
            gap: Gaps in m, positive, shape (n,).
            Phi: Displacement of the places per modal coordinate, kg^-1/2, shape (n, J).
            mode: Index of the mode, from 0.
        """
        return cls(gap, _moving(Phi[:, mode], Phi))

    @classmethod
    def at_rest(cls, gap: Array) -> Approach:
        """No motion: places whose gap is not positive are met at rest, and no other ones."""
        return cls(np.where(gap > 0, np.inf, gap), np.zeros_like(gap))

    def of_some(self, some: Indices | slice) -> Approach:
        """That of some of the places."""
        curvature = np.broadcast_to(self.curvature, self.motion.shape)
        return Approach(self.clearance[some], self.motion[some], curvature[some])

    def without(self, left_out: Mask) -> Approach:
        """That with nothing to be met at some places."""
        return replace(self, clearance=np.where(left_out, np.inf, self.clearance))

    @property
    def reach(self) -> Array:
        """Amplitude of the mode at which each place meets its obstacle, shape (n,), kg^1/2 m.

        Infinite where it never does, and where it is at the obstacle, or beyond it, at rest.
        """
        moves = (self.motion != 0) | (self.curvature > 0)
        meets = moves & (self.clearance > 0) & np.isfinite(self.clearance)
        clearance = np.where(meets, self.clearance, 1.0)
        return np.where(meets, reach(clearance, self.motion, self.curvature), np.inf)


@dataclass(frozen=True, slots=True)
class Places:
    """Places where contact can be, some of which are contact points.

    Attributes:
        Phi: Displacement per modal coordinate, kg^-1/2, shape (n, J).
        R: Residual flexibility between places and contact points in m/N, shape (n, n_c).
        gap: Gaps in m, shape (n,).
        point: Contact point that each place belongs to, shape (n,).
    """

    Phi: Array
    R: Array
    gap: Array
    point: Indices

    def approach(self, rest: RestState, mode: int) -> Approach:
        """The approach of a linear mode about the state of rest.

        Places that belong to a point which touches at rest meet nothing anew. Of the others, those
        that lie beyond the obstacle by no more than the curve between contact points accounts for
        are left out as well.

        Args:
            rest: State of rest of the model with the contact points.
            mode: Index of its mode, from 0.
        """
        clearance = self.gap - self.Phi @ rest.q + self.R @ rest.force
        motion = self.Phi @ rest.shapes - self.R @ rest.pull
        known = np.isfinite(self.gap)
        none = _ROUND_OFF * np.abs(self.gap[known]).max(initial=0.0)
        clearance = np.where(np.abs(clearance) <= none, 0.0, clearance)
        interference = max(-float(self.gap.min()), 0.0)
        shallow = (clearance <= 0) & (clearance > -_BETWEEN_POINTS * interference)
        left_out = (rest.closed | rest.touching)[self.point] | shallow
        return Approach(np.where(left_out, np.inf, clearance), _moving(motion[:, mode], motion))


def _moving(motion: Array, all_motions: Array) -> Array:
    """Motion of a mode, 0 where it is round-off beside the motions of all modes."""
    return np.where(np.abs(motion) > _STILL * np.abs(all_motions).max(initial=0.0), motion, 0.0)
