"""A slender cantilever of plane elements that bends far: finite elements in NumPy, by themselves.

Total Lagrangian, St. Venant-Kirchhoff, plane stress: V = 1/2 int E : C : E with the Green-Lagrange
strain E = sym(grad u) + 1/2 grad u^T grad u, so that all derivatives of V are polynomials that are
known in full. Biquadratic elements along the axis. The axis lies along x; the contact direction is
inclined to it, so that bending closes the gap in first order and opens it in second.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from bent_body import dense_operators, flat
from scipy.linalg import eigh

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.reduction.modal_derivatives import with_second_order
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.reduction.truncation import massless_truncation

LENGTH, HEIGHT, WIDTH, YOUNG, POISSON, DENSITY = 0.1, 0.002, 1.0, 210e9, 0.3, 7800.0
INCLINED, GAP, CONTACT = np.deg2rad(10.0), 1e-3, 1e7


@dataclass(frozen=True, slots=True)
class Cantilever:
    """Finite elements of the cantilever; displacements have the clamped ones left out.

    Attributes:
        elements: Number of elements along the axis.
        gradient: Displacement gradient at q quadrature points, shape (q, 2, 2, n).
        weight: Their weights, with the width, in m^3, shape (q,).
        M: Mass, shape (n, n).
        K: Stiffness at rest, shape (n, n).
        tip: Row of the displacement of the middle of the tip towards the obstacle, shape (n,).
        lift: Row of its displacement across the axis, shape (n,).
        draw: Row of its displacement along the axis, shape (n,).
    """

    elements: int
    gradient: Array = field(init=False)
    weight: Array = field(init=False)
    M: Array = field(init=False)
    K: Array = field(init=False)
    tip: Array = field(init=False)
    lift: Array = field(init=False)
    draw: Array = field(init=False)

    def __post_init__(self) -> None:
        count = 2 * self.elements + 1
        x, weight = np.polynomial.legendre.leggauss(4)
        N, dN = _quadratic(x), _quadratic_slope(x)
        long, high = LENGTH / self.elements / 2, HEIGHT / 2
        values, slopes, weights = [], [], []
        for e in range(self.elements):
            nodes = [3 * (2 * e + i) + j for i in range(3) for j in range(3)]
            for a in range(4):
                for b in range(4):
                    by_node = np.zeros((3, 3 * count))
                    by_node[0, nodes] = np.outer(N[a], N[b]).ravel()
                    by_node[1, nodes] = np.outer(dN[a] / long, N[b]).ravel()
                    by_node[2, nodes] = np.outer(N[a], dN[b] / high).ravel()
                    values.append(by_node[0])
                    slopes.append(by_node[1:])
                    weights.append(weight[a] * weight[b] * long * high * WIDTH)
        shape, slope, volume = np.array(values), np.array(slopes), np.array(weights)
        size = 2 * 3 * count
        gradient = np.zeros((len(volume), 2, 2, size))
        gradient[:, 0, :, 0::2] = slope
        gradient[:, 1, :, 1::2] = slope
        mass = np.kron(DENSITY * (shape * volume[:, None]).T @ shape, np.eye(2))
        free = slice(6, None)
        middle = 2 * (3 * (count - 1) + 1)
        draw, lift = np.eye(size)[middle, free], np.eye(size)[middle + 1, free]
        derived = {
            "gradient": gradient[..., free],
            "weight": volume,
            "M": mass[free, free],
            "tip": np.cos(INCLINED) * draw + np.sin(INCLINED) * lift,
            "lift": lift,
            "draw": draw,
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "K", self.tangent(np.zeros(len(draw))))

    def slope(self, u: Array) -> Array:
        """Displacement gradient at the quadrature points, shape (q, 2, 2)."""
        return self.gradient @ u

    def strain(self, u: Array) -> Array:
        """Green-Lagrange strain, shape (q, 2, 2)."""
        H = self.slope(u)
        return _sym(H) + np.swapaxes(H, 1, 2) @ H / 2

    def energy(self, u: Array) -> float:
        """Strain energy in J."""
        E = self.strain(u)
        return float(self.weight @ np.sum(E * _stress(E), axis=(1, 2))) / 2

    def force(self, u: Array, stress: Array | None = None) -> Array:
        """Internal force at a displacement, with its own stress or a given one, shape (n,)."""
        H = self.slope(u)
        S = _stress(self.strain(u)) if stress is None else stress
        P = (np.eye(2) + H) @ S * self.weight[:, None, None]
        return np.tensordot(P, self.gradient, ([0, 1, 2], [0, 1, 2]))

    def tangent(self, u: Array) -> Array:
        """Derivative of the internal force, shape (n, n)."""
        return self.tangent_between(u, u, _stress(self.strain(u)))

    def tangent_between(self, at: Array, towards: Array, stress: Array) -> Array:
        """Int grad v : (grad w S + F_at C : sym(F_towards^T grad w)), shape (n, n)."""
        F, G = (np.eye(2) + self.slope(u) for u in (at, towards))
        n = self.gradient.shape[-1]
        strained = _sym(np.einsum("qki,qkjn->qijn", G, self.gradient).transpose(0, 3, 1, 2))
        turned = np.einsum("qik,qnkj->qijn", F, _stress(strained))
        turned += np.einsum("qikn,qkj->qijn", self.gradient, stress)
        turned *= self.weight[:, None, None, None]
        return self.gradient.reshape(-1, n).T @ turned.reshape(-1, n)

    def second(self, a: Array, b: Array) -> Array:
        """Second derivative f''[a, b] of the internal force at rest, shape (n,)."""
        A, B = self.slope(a), self.slope(b)
        both = _stress(_sym(np.swapaxes(A, 1, 2) @ B))
        P = both + B @ _stress(_sym(A)) + A @ _stress(_sym(B))
        return np.tensordot(P * self.weight[:, None, None], self.gradient, ([0, 1, 2], [0, 1, 2]))

    def third(self, a: Array, b: Array, c: Array) -> Array:
        """Third derivative f'''[a, b, c] of the internal force, shape (n,)."""
        A, B, C = (self.slope(each) for each in (a, b, c))
        P = sum(
            X @ _stress(_sym(np.swapaxes(Y, 1, 2) @ Z))
            for X, Y, Z in ((A, B, C), (B, A, C), (C, A, B))
        )
        return np.tensordot(P * self.weight[:, None, None], self.gradient, ([0, 1, 2], [0, 1, 2]))

    def modes(self, count: int) -> tuple[Array, Array]:
        """Circular frequencies and mass-normalised modes that lift the tip."""
        squares, shapes = eigh(self.K, self.M, subset_by_index=[0, count - 1])
        return np.sqrt(squares), shapes * np.where(self.tip @ shapes < 0, -1.0, 1.0)

    def reduced(self, modes: int, masters: Indices) -> Reduction:
        """The reduction with second-order kinematics, with the spring of the contact in R."""
        omega, shapes = self.modes(modes)
        rows = self.tip[None] @ shapes
        residual = np.linalg.solve(self.K, self.tip[:, None]) - (shapes / omega**2) @ rows.T
        R = self.tip[None] @ residual + 1 / CONTACT
        operators = dense_operators(self.K, self.M, self.tip[None])
        truncation = massless_truncation(residual, operators)
        model = ReducedModel(omega, rows, R, np.array([GAP]))
        linear = Reduction(model, shapes, residual, truncation)
        deflection = flat(self.second, self.third, operators)
        return with_second_order(linear, masters, operators, deflection)


def _sym(H: Array) -> Array:
    return (H + np.swapaxes(H, -1, -2)) / 2


def _stress(E: Array) -> Array:
    """C : E in plane stress, shape (.., 2, 2)."""
    factor = YOUNG / (1 - POISSON**2)
    trace = np.trace(E, axis1=-2, axis2=-1)[..., None, None]
    return factor * ((1 - POISSON) * E + POISSON * trace * np.eye(2))


def _quadratic(x: Array) -> Array:
    return np.array([x * (x - 1) / 2, 1 - x**2, x * (x + 1) / 2]).T


def _quadratic_slope(x: Array) -> Array:
    return np.array([x - 0.5, -2 * x, x + 0.5]).T


@dataclass(slots=True)
class March:
    """Motion in time of the whole cantilever, by a scheme that conserves energy.

    J. C. Simo, N. Tarnow, Z. Angew. Math. Phys. 43 (1992) 757-792: mean stress, middle
    configuration. The contact force is the difference of its potential over that of the closing.

    Attributes:
        body: Finite elements.
        u: Displacement.
        v: Velocity.
        step: Time step in s.
        contact: Whether there is an obstacle.
    """

    body: Cantilever
    u: Array
    v: Array
    step: float
    contact: bool = True

    def advance(self) -> None:
        """Go on by a step, by Newton's iteration.

        Raises:
            AssertionError: if it does not converge.
        """
        body, dt, before = self.body, self.step, self.u
        stress, closing = _stress(body.strain(before)), float(body.tip @ before)
        inertia = 2 / dt**2 * body.M
        u = before + dt * self.v
        for _ in range(20):
            middle, mean = (before + u) / 2, (stress + _stress(body.strain(u))) / 2
            force, slope = self._pressed(closing, float(body.tip @ u))
            residual = inertia @ (u - before - dt * self.v) + body.force(middle, mean)
            tangent = inertia + body.tangent_between(middle, u, mean) / 2
            tangent += slope * np.outer(body.tip, body.tip)
            change = np.linalg.solve(tangent, residual + force * body.tip)
            u = u - change
            if np.abs(change).max() <= 1e-12 * np.abs(u).max():
                break
        else:
            raise AssertionError("no convergence in a step")
        self.v = 2 * (u - before) / dt - self.v
        self.u = u

    def energy(self) -> float:
        """Total energy in J."""
        kinetic = self.v @ self.body.M @ self.v / 2
        return (
            float(kinetic) + self.body.energy(self.u) + self._stored(float(self.body.tip @ self.u))
        )

    def _stored(self, closing: float) -> float:
        return CONTACT * max(closing - GAP, 0.0) ** 2 / 2 if self.contact else 0.0

    def _pressed(self, before: float, after: float) -> tuple[float, float]:
        """Mean force of a step, and its derivative by the closing at its end."""
        first, last, moved = max(before - GAP, 0.0), max(after - GAP, 0.0), after - before
        if not self.contact or first == last == 0:
            return 0.0, 0.0
        if first and last:
            return CONTACT * (first + last) / 2, CONTACT / 2
        force = CONTACT * (last**2 - first**2) / (2 * moved)
        return force, (CONTACT * last - force) / moved


def frequency_in_time(
    body: Cantilever, u: Array, filter_: Array, *, step: float, periods: int, contact: bool = True
) -> tuple[float, float]:
    """Frequency in Hz of a motion from rest, and the largest relative change of its energy.

    Times of rest are those at which the velocity of a filtered coordinate passes zero on its way
    down, and the frequency is that of the scheme over what it makes of a linear oscillator.

    Args:
        body: Finite elements.
        u: Displacement at the start.
        filter_: Row of the coordinate.
        step: Time step in s.
        periods: Number of periods.
        contact: Whether there is an obstacle.
    """
    march = March(body, u, np.zeros_like(u), step, contact)
    start, rates, energies = march.energy(), [0.0], []
    while len(energies) < 3 or sum(_falls(rates)) < periods:
        march.advance()
        rates.append(float(filter_ @ march.v))
        energies.append(march.energy() / start - 1)
    last = len(rates) - 2
    end = last + rates[-2] / (rates[-2] - rates[-1])
    omega = 2 * np.pi * periods / (end * step)
    return 2 * np.tan(omega * step / 2) / step / (2 * np.pi), float(np.abs(energies).max())


def _falls(rates: list[float]) -> list[bool]:
    return [a > 0 >= b for a, b in pairwise(rates)]
