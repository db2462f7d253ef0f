"""Which nodes can have the largest stress or displacement: found in single precision, and fast.

In coordinates d of deviatoric stress von Mises' square is a sum of five squares,

    q^2 = 3/4 (s_xx - s_yy)^2 + (s_zz - (s_xx + s_yy) / 2)^2 + 3 (s_xy^2 + s_yz^2 + s_xz^2),

so that a matrix product gives it at some instants; what others may add is bounded (`thinned`). No
principal stress is above the mean one and 2/3 of q (Lode angle zero). What may be largest by this
is then looked at in double precision, at all instants.

Squares in single precision end at 1e38, and shapes of a body of micrometres, of modes of mass 1,
have stresses beyond 1e19 Pa. So shapes are kept over their largest number, and motions are looked
at over the largest number that they may reach.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fields.thinned import Thinned

Single = NDArray[np.float32]

#: More than the relative error of sums in single precision.
_ROUND_OFF = 1e-4

#: Nodes whose stress at all instants is in memory at once.
_NODES_AT_ONCE = 1000

_ROOT = np.sqrt(3.0)

#: From stresses xx, yy, zz, xy, yz, xz to the five numbers d, and the mean stress.
_TO_DEVIATORIC = np.array(
    [
        [_ROOT / 2, -_ROOT / 2, 0, 0, 0, 0],
        [-1 / 2, -1 / 2, 1, 0, 0, 0],
        [0, 0, 0, _ROOT, 0, 0],
        [0, 0, 0, 0, _ROOT, 0],
        [0, 0, 0, 0, 0, _ROOT],
        [1 / 3, 1 / 3, 1 / 3, 0, 0, 0],
    ]
)


@dataclass(frozen=True, slots=True)
class Bounds:
    """What the stress of nodes reaches at most over a period in Pa, each of shape (n,).

    Attributes:
        mises: Von Mises stress.
        tension: Bound of the largest principal stress.
        change: Von Mises stress of the change from the state of rest.
    """

    mises: Array
    tension: Array
    change: Array


@dataclass(frozen=True, slots=True)
class StressScreen:
    """Stresses of shapes in single precision.

    Attributes:
        scales: Largest number of each shape in Pa, shape (shapes,).
        blocks: Deviatoric numbers and mean stress of each shape over its scale at a few nodes after
            others, each of shape (shapes, 6 m).
        sizes: Von Mises stress of each shape, and the bound of its tension to either side, over its
            scale, each of shape (shapes, n).
        rest: Numbers of the state of rest, each of shape (6, m).
        steady: Those of steady loads, each of shape (6, m).
    """

    scales: Array
    blocks: tuple[Single, ...]
    sizes: tuple[Single, Single]
    rest: tuple[Array, ...]
    steady: tuple[Array, ...]

    def bounds(self, motions: Sequence[Thinned]) -> list[Bounds]:
        """Bounds at all nodes of each motion: of several in one go, which reads shapes once."""
        steps = _Steps.of(motions, self.scales, _largest([*self.rest, *self.steady]))
        parts = [
            _bounds(steps.sums(block, 6) + steps.over(steady), steps.over(rest), steps.starts)
            for block, rest, steady in zip(self.blocks, self.rest, self.steady, strict=True)
        ]
        mises, tension, change = (np.concatenate(each, axis=1) for each in zip(*parts, strict=True))
        between, pulled = (steps.bent @ size for size in self.sizes)
        found = zip(mises + between, tension + pulled, change + between, strict=True)
        return [Bounds(*(steps.unit * each for each in of_one)) for of_one in found]


def _bounds(numbers: Single, rest: Single, starts: Indices) -> tuple[Single, Single, Single]:
    """The fields of `Bounds` of numbers (t, 6, m) at their instants alone, each (motions, m)."""
    mises = _length(numbers[:, :5])
    largest = change = np.maximum.reduceat(mises, starts)
    if rest.any():
        change = np.maximum.reduceat(_length(numbers[:, :5] - rest[:5]), starts)
    mises *= np.float32(2 / 3)
    mises += numbers[:, 5]
    return largest, np.maximum.reduceat(mises, starts), change


def stress_screen(stresses: Array, rest: Array, steady: Array) -> StressScreen:
    """Prepare the screen of a part of a body.

    Args:
        stresses: Stress of each shape in Pa, shape (shapes, 6, n).
        rest: That of the state of rest, shape (6, n).
        steady: That of steady loads, shape (6, n), or (6, 0) without them.
    """
    count = stresses.shape[2]
    steady = steady if steady.size else np.zeros((6, count))
    few, scales = slices(count), _scales(stresses)
    blocks = [_single(_numbers(stresses[..., each]) / scales[:, None, None]) for each in few]
    sizes = zip(*map(_sizes, blocks), strict=True)
    mises, tension = (np.concatenate(each, axis=1) for each in sizes)
    return StressScreen(
        scales,
        tuple(block.reshape(len(block), -1) for block in blocks),
        (mises, tension),
        tuple(_numbers(rest[:, each]) for each in few),
        tuple(_numbers(steady[:, each]) for each in few),
    )


def _numbers(stress: Array) -> Array:
    """Deviatoric numbers and mean stress of stresses (..., 6, m)."""
    return np.asarray(_TO_DEVIATORIC @ stress)


def _sizes(numbers: Single) -> tuple[Single, Single]:
    """`StressScreen.sizes` of numbers (shapes, 6, m)."""
    mises = _length(numbers[:, :5])
    return mises, np.float32(2 / 3) * mises + np.abs(numbers[:, 5])


@dataclass(frozen=True, slots=True)
class LengthScreen:
    """Displacements of shapes in single precision.

    Attributes:
        scales: Largest component of each shape, shape (shapes,).
        blocks: Displacement of each shape over its scale at a few nodes after others, each
            (shapes, dim m).
        sizes: Length of each shape over its scale, shape (shapes, n).
        dim: Number of components.
    """

    scales: Array
    blocks: tuple[Single, ...]
    sizes: Single
    dim: int

    def bounds(self, motions: Sequence[Thinned]) -> list[Array]:
        """What lengths over time are not above, at all nodes (n,) of each motion."""
        steps = _Steps.of(motions, self.scales)
        moved = (steps.sums(block, self.dim) for block in self.blocks)
        found = [np.maximum.reduceat(_length(each), steps.starts) for each in moved]
        largest = np.concatenate(found, axis=1) + steps.bent @ self.sizes
        return [np.asarray(steps.unit * each) for each in largest]


def length_screen(count: int, dim: int, at: Callable[[slice], Array]) -> LengthScreen:
    """Prepare it.

    Args:
        count: Number of nodes.
        dim: Number of components.
        at: Displacement of shapes at some nodes, shape (shapes, m, dim).
    """
    few = slices(count)
    scales = np.maximum.reduce([_scales(at(each)) for each in few])
    parts = (np.swapaxes(at(each), 1, 2) for each in few)
    blocks = [_single(part / scales[:, None, None]) for part in parts]
    sizes = np.concatenate([_length(block) for block in blocks], axis=1)
    return LengthScreen(
        scales, tuple(block.reshape(len(block), -1) for block in blocks), sizes, dim
    )


def with_largest(
    bound: Array, exact: Callable[[Indices], Array], count: int, least: float = -np.inf
) -> tuple[Indices, Array]:
    """Nodes among which those of the largest values of a kind are, and the values there.

    Args:
        bound: What the value of each node is not above, apart from round-off, shape (n,).
        exact: Values at nodes.
        count: Number of the largest values that are wanted.
        least: Values below this one are not.

    Returns:
        Nodes and values, each of shape (m,); m >= min(count, n) unless values are below `least`.
    """
    highest = bound + _ROUND_OFF * np.abs(bound)
    start = min(2 * count, len(bound))
    first = np.sort(np.argpartition(-bound, start - 1)[:start])
    first = first[~(highest[first] < least)]
    if not len(first):
        return first, np.empty(0)
    values = exact(first)
    level = max(least, np.sort(values)[-count]) if len(values) >= count else least
    reach = highest >= level
    reach[first] = False
    more = np.flatnonzero(reach)
    if len(more):
        first, values = np.concatenate([first, more]), np.concatenate([values, exact(more)])
    return first, values


def slices(count: int) -> list[slice]:
    """Nodes that are looked at together."""
    return [slice(at, at + _NODES_AT_ONCE) for at in range(0, count, _NODES_AT_ONCE)]


@dataclass(frozen=True, slots=True)
class _Steps:
    """Motions at few instants, one after the other, over the largest number that they may reach.

    Attributes:
        few: Amounts of scaled shapes, shape (k, shapes).
        bent: Largest differences from straight lines of each motion, shape (motions, shapes).
        starts: Where each motion begins in `few`.
        unit: What all numbers are over.
    """

    few: Single
    bent: Single
    starts: Indices
    unit: float

    @classmethod
    def of(cls, motions: Sequence[Thinned], scales: Array, least: float = 0.0) -> _Steps:
        """Those of motions of shapes with the given scales; the unit is not below the least."""
        few = scales * np.concatenate([motion.few for motion in motions])
        bent = scales * np.array([motion.bent for motion in motions])
        ends = np.cumsum([len(motion.few) for motion in motions])
        reached = max(float(np.abs(each).sum(axis=1).max()) for each in (few, bent))
        unit = max(reached, least) or 1.0
        starts = np.concatenate([[0], ends[:-1]])
        return cls(_single(few / unit), _single(bent / unit), starts, unit)

    def sums(self, block: Single, components: int) -> Single:
        """Sums of scaled shapes (shapes, components m) at the instants, (k, components, m)."""
        return (self.few @ block).reshape(len(self.few), components, -1)

    def over(self, numbers: Array) -> Single:
        """Numbers over the unit."""
        return _single(numbers / self.unit)


def _scales(shapes: Array) -> Array:
    """Largest number of each shape, 1 of one that is zero."""
    high, low = shapes.max(axis=(1, 2), initial=0.0), shapes.min(axis=(1, 2), initial=0.0)
    largest = np.maximum(high, -low)
    return np.where(largest > 0, largest, 1.0)


def _largest(parts: Sequence[Array]) -> float:
    return max((float(np.abs(part).max(initial=0.0)) for part in parts), default=0.0)


def _single(numbers: Array) -> Single:
    return np.ascontiguousarray(numbers, dtype=np.float32)


def _length(numbers: Single) -> Single:
    """Length over the second axis of numbers (t, m, n), shape (t, n)."""
    return np.sqrt(np.einsum("tmn,tmn->tn", numbers, numbers))
