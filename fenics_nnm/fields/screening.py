"""Which nodes can have the largest stress or displacement: found in single precision, and fast.

In coordinates d of deviatoric stress von Mises' square is a sum of five squares,

    q^2 = 3/4 (s_xx - s_yy)^2 + (s_zz - (s_xx + s_yy) / 2)^2 + 3 (s_xy^2 + s_yz^2 + s_xz^2),

so that a matrix product gives it at some instants; what others may add is bounded (`thinned`). No
principal stress is above the mean one and 2/3 of q (Lode angle zero). What may be largest by this
is then looked at in double precision, at all instants.
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
        blocks: Deviatoric numbers and mean stress of each shape at a few nodes after others, each
            of shape (shapes, 6 m).
        sizes: Von Mises stress of each shape, and the bound of its tension to either side, each of
            shape (shapes, n).
        rest: Numbers of the state of rest, each of shape (6, m).
        steady: Those of steady loads, each of shape (6, m).
    """

    blocks: tuple[Single, ...]
    sizes: tuple[Single, Single]
    rest: tuple[Single, ...]
    steady: tuple[Single, ...]

    def bounds(self, motions: Sequence[Thinned]) -> list[Bounds]:
        """Bounds at all nodes of each motion: of several in one go, which reads shapes once."""
        few, starts = _few(motions)
        parts = [
            _bounds(np.add((few @ block).reshape(len(few), 6, -1), steady), rest, starts)
            for block, rest, steady in zip(self.blocks, self.rest, self.steady, strict=True)
        ]
        mises, tension, change = (np.concatenate(each, axis=1) for each in zip(*parts, strict=True))
        between, pulled = (_bent(motions) @ size for size in self.sizes)
        found = zip(mises + between, tension + pulled, change + between, strict=True)
        return [Bounds(*each) for each in found]


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
    few = slices(count)
    blocks = [_numbers(stresses[..., each]) for each in few]
    sizes = zip(*map(_sizes, blocks), strict=True)
    mises, tension = (np.concatenate(each, axis=1) for each in sizes)
    return StressScreen(
        tuple(block.reshape(len(block), -1) for block in blocks),
        (mises, tension),
        tuple(_numbers(rest[:, each]) for each in few),
        tuple(_numbers(steady[:, each]) for each in few),
    )


def _numbers(stress: Array) -> Single:
    """Deviatoric numbers and mean stress of stresses (..., 6, m)."""
    return np.ascontiguousarray(_TO_DEVIATORIC @ stress, dtype=np.float32)


def _sizes(numbers: Single) -> tuple[Single, Single]:
    """`StressScreen.sizes` of numbers (shapes, 6, m)."""
    mises = _length(numbers[:, :5])
    return mises, np.float32(2 / 3) * mises + np.abs(numbers[:, 5])


@dataclass(frozen=True, slots=True)
class LengthScreen:
    """Displacements of shapes in single precision.

    Attributes:
        blocks: Displacement of each shape at a few nodes after others, each (shapes, dim m).
        sizes: Length of each shape, shape (shapes, n).
        dim: Number of components.
    """

    blocks: tuple[Single, ...]
    sizes: Single
    dim: int

    def bounds(self, motions: Sequence[Thinned]) -> list[Array]:
        """What lengths over time are not above, at all nodes (n,) of each motion."""
        few, starts = _few(motions)
        moved = ((few @ block).reshape(len(few), self.dim, -1) for block in self.blocks)
        found = [np.maximum.reduceat(_length(each), starts) for each in moved]
        largest = np.concatenate(found, axis=1) + _bent(motions) @ self.sizes
        return [np.asarray(each) for each in largest]


def length_screen(count: int, dim: int, at: Callable[[slice], Array]) -> LengthScreen:
    """Prepare it.

    Args:
        count: Number of nodes.
        dim: Number of components.
        at: Displacement of shapes at some nodes, shape (shapes, m, dim).
    """
    parts = (np.swapaxes(at(few), 1, 2) for few in slices(count))
    blocks = [np.ascontiguousarray(part, dtype=np.float32) for part in parts]
    sizes = np.concatenate([_length(block) for block in blocks], axis=1)
    return LengthScreen(tuple(block.reshape(len(block), -1) for block in blocks), sizes, dim)


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


def _few(motions: Sequence[Thinned]) -> tuple[Single, Indices]:
    """Amounts at few instants of one motion after the other, and where each begins."""
    ends = np.cumsum([len(motion.few) for motion in motions])
    few = np.concatenate([motion.few for motion in motions]).astype(np.float32)
    return few, np.concatenate([[0], ends[:-1]])


def _bent(motions: Sequence[Thinned]) -> Single:
    return np.array([motion.bent for motion in motions], dtype=np.float32)


def _length(numbers: Single) -> Single:
    """Length over the second axis of numbers (t, m, n), shape (t, n)."""
    return np.sqrt(np.einsum("tmn,tmn->tn", numbers, numbers))
