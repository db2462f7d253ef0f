r"""The state of rest of a structure, and its linear motions about it.

At rest the forces of the contact points obey the linear complementarity problem

    0 <= lambda  _|_  S lambda + gap >= 0,      S = R + Phi diag(1/omega^2) Phi^T,

with S the static flexibility. Points are *closed* (force without clearance: interference), *open*
(clearance without force), or *touching* (neither: no gap, and nothing that presses). Where all gaps
are positive all points are open and nothing is displaced.

As long as no closed point lifts off and no open point closes, the motion about the state of rest is
linear, q = q_s + a x cos(nu t), with the closed points held at their gaps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from fenics_nnm.arrays import Array
from fenics_nnm.errors import Code, ModelError
from fenics_nnm.mechanics.closed import ClosedPoints
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.flexible_points import FlexiblePoints
from fenics_nnm.mechanics.reach import nearest, reach

#: Clearance, or deflection under a force, below this part of the largest gap is none.
_ROUND_OFF = 1e-9

#: A mode whose contact points move less than this part of the largest motion holds them still.
_STILL = 1e-10

#: Round-off mixes the shapes of modes by `_STILL` over the distance of their squared frequencies,
#: relative; of all but double modes by at most this multiple of it.
_MOST_MIXED = 1e4

#: Points that move alike: their motions differ by less than this part.
_ALIKE = 1e-6


@dataclass(frozen=True, slots=True)
class RestState:
    """State of rest and linear modes about it.

    Attributes:
        q: Modal coordinates at rest, shape (J,).
        force: Contact forces at rest, shape (n_c,).
        clearance: Distances of the contact points from their obstacles at rest, shape (n_c,).
        closed: Points with force, shape (n_c,).
        touching: Points with neither force nor clearance, shape (n_c,).
        omega: Circular frequencies with the closed points held, ascending, shape (J,).
        shapes: Modes with these frequencies as orthonormal columns, shape (J, J).
        margin: Margins at rest as in `mechanics.closed`, zero for touching points, shape (n_c,).
        gradient: Margins per unit of each mode, shape (n_c, J).
        pull: Change of the contact forces per unit of each mode, shape (n_c, J).
        motion: Free displacement Phi of the contact points per unit of each mode, shape (n_c, J).
        curvature: Second derivative of their closing along each mode, shape (n_c, J).
        reference: What stands for the margin of touching points, if it is given.
    """

    q: Array
    force: Array
    clearance: Array
    closed: NDArray[np.bool_]
    touching: NDArray[np.bool_]
    omega: Array
    shapes: Array
    margin: Array
    gradient: Array
    pull: Array
    motion: Array
    curvature: Array
    reference: float | None

    @property
    def scale(self) -> float:
        """The reference, or 0 where there is none."""
        return self.reference or 0.0

    def motion_from(self, q: Array) -> Array:
        """Coefficients of the motion about the state of rest, shape of q (c, J)."""
        motion = q.copy()
        motion[0] -= self.q
        return motion

    def scaled(self, q: Array, factor: float) -> Array:
        """Coefficients of a motion of the same shape, with its displacements from rest scaled."""
        scaled = factor * self.motion_from(q)
        scaled[0] += self.q
        return scaled

    @property
    def pressed(self) -> bool:
        """Whether not all points are open."""
        return bool((self.closed | self.touching).any())

    @property
    def homogeneous(self) -> bool:
        """Whether all points touch: a motion scaled by any factor is a motion then."""
        return bool(self.touching.all())

    def is_linear(self, mode: int) -> bool:
        """Whether small motions of a mode are linear: it moves no touching point."""
        return not np.any(self._moved(mode) & self.touching)

    def touches(self, mode: int) -> bool:
        """Whether a mode moves any contact point towards its obstacle."""
        return not self._is_still(mode)

    def amplitude(self, mode: int) -> float:
        """Amplitude at which a linear mode comes to its first event: a point closes or lifts off.

        Where touching points move there is no linear range; then it is the amplitude at which the
        first of them, taken as open, moves by the reference displacement. Where second-order
        displacement keeps all points away from their obstacles it is that of the nearest approach.

        Raises:
            ModelError: if the mode moves no contact point, or the reference is missing.
        """
        if self._is_still(mode):
            raise ModelError(
                f"mode {mode + 1} does not move any contact point in the contact direction: "
                "it never touches the obstacle; choose another mode or contact direction",
                code=Code.STILL_MODE,
            )
        if self.is_linear(mode):
            return self._amplitude_of_event(mode)
        return self._amplitude_of_reference(mode)

    def _amplitude_of_event(self, mode: int) -> float:
        closing = self.margin, self.gradient[:, mode], self.curvature[:, mode]
        return float(np.min(reach(*closing))) if self._approaches(mode) else nearest(*closing)[0]

    def _amplitude_of_reference(self, mode: int) -> float:
        """Amplitude at which the first touching point moves by the reference displacement."""
        if self.reference is None:
            raise ModelError(
                "the reference displacement is missing: contact points touch without force "
                "at rest, so there is no linear motion to scale energies by: must be the "
                "displacement in m of these points at gamma ratio 1",
                code=Code.REFERENCE,
            )
        moved = np.abs(self.gradient[:, mode])[self._moved(mode) & self.touching]
        with np.errstate(divide="ignore", over="ignore"):
            return float(np.min(np.full(len(moved), self.reference) / moved))

    def at_one(self, mode: int) -> str:
        """What happens at gamma ratio 1.

        First contact is static where a motion bends in second order: other modes, which follow it
        in time, are taken to follow statically.
        """
        if not self.is_linear(mode):
            return "reference displacement"
        if not self._approaches(mode):
            return "nearest approach"
        if self.closed[self.first(mode)]:
            return "lift-off"
        return "static first contact" if self.curvature[:, mode].any() else "first contact"

    def first(self, mode: int) -> int:
        """The contact point of the first event, or the first touching point to move that far."""
        slope, curvature = self.gradient[:, mode], self.curvature[:, mode]
        if not self._approaches(mode):
            return nearest(self.margin, slope, curvature)[1]
        steep = np.maximum(np.abs(slope), 1e-300)
        if not self.is_linear(mode):
            return int(np.argmin(np.where(self.touching, self.scale, np.inf) / steep))
        margin = np.where(self.touching, self.scale, self.margin)
        return int(np.argmin(reach(margin, steep, curvature)))

    def _is_still(self, mode: int) -> bool:
        """Whether a mode moves no contact point towards its obstacle, in second order neither."""
        motions = np.abs(self.motion).max(axis=0)
        largest = motions.max()
        moves = motions[mode] > _STILL * (_mixing(self.omega, mode) * motions).max()
        bend = self.curvature[:, mode].max() * np.abs(self.clearance).max()
        return not moves and bool(bend <= _STILL * largest**2)

    def _approaches(self, mode: int) -> bool:
        """Whether a mode, with what second order adds, brings any point to its event."""
        slope, curvature = self.gradient[:, mode], self.curvature[:, mode]
        return bool(np.isfinite(reach(self.margin, slope, curvature)).any())

    def _moved(self, mode: int) -> NDArray[np.bool_]:
        return np.asarray(np.abs(self.gradient[:, mode]) > _STILL * np.abs(self.gradient).max())


def rest_state(model: FlexiblePoints) -> RestState:
    """The state of rest of a model.

    Raises:
        ModelError: if a gap is not positive where contact points carry mass: their motion after
            lift-off would need an impact law; or with second-order kinematics.
    """
    points, modes = model.points, model.modes
    nothing, none = np.zeros(points), np.zeros(points, dtype=bool)
    if model.gap.min() > 0:
        return RestState(
            q=np.zeros(modes),
            force=nothing,
            clearance=model.gap,
            closed=none,
            touching=none,
            omega=model.omega,
            shapes=np.eye(modes),
            margin=model.gap,
            gradient=-model.Phi,
            pull=np.zeros((points, modes)),
            motion=model.Phi,
            curvature=model.kinematics.curvature(model),
            reference=model.reference,
        )
    if not model.massless:
        raise ModelError(
            f"gap = {model.gap.min():g}: must be positive where contact points carry mass; gaps of "
            "any sign need the massless reduction",
            code=Code.GAP_WITH_MASS,
        )
    if model.kinematics.forces:
        raise ModelError(
            f"gap = {model.gap.min():g}: must be positive with second-order kinematics, whose "
            "masters are modes about a state of rest without contact",
            code=Code.GAP_WITH_KINEMATICS,
        )
    return _pressed(model)


def _pressed(model: FlexiblePoints) -> RestState:
    """The state of rest where some gaps are not positive."""
    flexible = model.Phi / model.omega
    S = model.R + flexible @ flexible.T
    force = Complementarity(S, model.gap)(np.zeros((1, model.points))).force[0]
    clearance = S @ force + model.gap
    nothing = _ROUND_OFF * np.abs(model.gap).max()
    closed = force * np.diagonal(S) > nothing
    touching = ~closed & (clearance <= nothing)
    force, clearance = np.where(closed, force, 0.0), np.where(closed | touching, 0.0, clearance)
    omega, shapes, gradient = model.omega, np.eye(model.modes), -model.Phi
    margin, pull = clearance, np.zeros((model.points, model.modes))
    if closed.any():
        held = ClosedPoints.of(model, closed)
        squares, shapes = eigh(held.stiffness)
        signs = towards_obstacle(model.Phi @ shapes)
        omega, shapes = np.sqrt(squares), shapes * signs
        inverse = np.linalg.inv(model.R[np.ix_(closed, closed)])
        margin = clearance.copy()
        margin[closed] = force[closed] / np.diagonal(inverse)
        gradient = held.gradient @ shapes
        pull[closed] = inverse @ model.Phi[closed] @ shapes
    return RestState(
        q=-(force @ model.Phi) / model.omega**2,
        force=force,
        clearance=clearance,
        closed=closed,
        touching=touching,
        omega=omega,
        shapes=shapes,
        margin=margin,
        gradient=gradient,
        pull=pull,
        motion=model.Phi @ shapes,
        curvature=model.kinematics.curvature(model),
        reference=model.reference,
    )


def towards_obstacle(Phi: Array) -> Array:
    """Signs that make the contact point that moves most move towards its obstacle, shape (J,).

    Of points that move alike, as by symmetry, the first one, so that round-off decides nothing.

    Args:
        Phi: Displacement of the contact points per modal coordinate, shape (n_c, J).
    """
    size = np.abs(Phi)
    first = np.argmax(size >= (1 - _ALIKE) * size.max(axis=0, initial=0.0), axis=0)
    largest = Phi[first, np.arange(Phi.shape[1])]
    return np.where(largest < 0, -1.0, 1.0)


def _mixing(omega: Array, mode: int) -> Array:
    """How much of each mode round-off brings into the shape of one, over `_STILL`, shape (J,).

    An error e of K - s M mixes two modes by e s over the distance of their squared frequencies.
    """
    squares = omega**2
    apart = np.abs(squares - squares[mode])
    mixing = np.asarray(squares[mode] / np.maximum(apart, squares[mode] / _MOST_MIXED))
    return np.maximum(np.where(np.arange(len(mixing)) == mode, 1.0, mixing), 1.0)
