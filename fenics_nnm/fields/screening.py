"""Which nodes can have the largest stress or displacement: found in single precision, and fast.

In coordinates d of deviatoric stress von Mises' square is a sum of five squares,

    q^2 = 3/4 (s_xx - s_yy)^2 + (s_zz - (s_xx + s_yy) / 2)^2 + 3 (s_xy^2 + s_yz^2 + s_xz^2),

so that a matrix product gives it at all instants. No principal stress is above the mean one and 2/3
of q (Lode angle zero). What may be largest by this is then looked at in double precision.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_nnm.arrays import Array, Indices

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
        rest: Those of the state of rest, each of shape (6, m).
        steady: Those of steady loads, each of shape (6, m).
    """

    blocks: tuple[Single, ...]
    rest: tuple[Single, ...]
    steady: tuple[Single, ...]

    def bounds(self, amounts: Array) -> Bounds:
        """Bounds at all nodes of a motion with amounts (t, shapes)."""
        few = amounts.astype(np.float32)
        parts = [
            _bounds(np.add((few @ block).reshape(len(few), 6, -1), steady, dtype=np.float32), rest)
            for block, rest, steady in zip(self.blocks, self.rest, self.steady, strict=True)
        ]
        return Bounds(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _bounds(numbers: Single, rest: Single) -> tuple[Array, Array, Array]:
    """The fields of `Bounds` of numbers (t, 6, m)."""
    mises = _length(numbers[:, :5])
    largest = change = mises.max(axis=0)
    if rest.any():
        change = _length(numbers[:, :5] - rest[:5]).max(axis=0)
    mises *= np.float32(2 / 3)
    mises += numbers[:, 5]
    return largest, mises.max(axis=0), change


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
    return StressScreen(
        tuple(_numbers(stresses[..., each]).reshape(len(stresses), -1) for each in few),
        tuple(_numbers(rest[:, each]) for each in few),
        tuple(_numbers(steady[:, each]) for each in few),
    )


def _numbers(stress: Array) -> Single:
    """Deviatoric numbers and mean stress of stresses (..., 6, m)."""
    return np.ascontiguousarray(_TO_DEVIATORIC @ stress, dtype=np.float32)


@dataclass(frozen=True, slots=True)
class LengthScreen:
    """Displacements of shapes in single precision.

    Attributes:
        blocks: Displacement of each shape at a few nodes after others, each (shapes, dim m).
        dim: Number of components.
    """

    blocks: tuple[Single, ...]
    dim: int

    def bound(self, amounts: Array) -> Array:
        """Largest length over time at all nodes of a motion with amounts (t, shapes)."""
        few = amounts.astype(np.float32)
        moved = ((few @ block).reshape(len(few), self.dim, -1) for block in self.blocks)
        return np.concatenate([_length(each).max(axis=0) for each in moved])


def length_screen(count: int, dim: int, at: Callable[[slice], Array]) -> LengthScreen:
    """Prepare it.

    Args:
        count: Number of nodes.
        dim: Number of components.
        at: Displacement of shapes at some nodes, shape (shapes, m, dim).
    """
    parts = (np.swapaxes(at(few), 1, 2) for few in slices(count))
    blocks = (np.ascontiguousarray(part, dtype=np.float32) for part in parts)
    return LengthScreen(tuple(block.reshape(len(block), -1) for block in blocks), dim)


def with_largest(
    bound: Array, exact: Callable[[Indices], Array], count: int
) -> tuple[Indices, Array]:
    """Nodes among which those of the largest values of a kind are, and the values there.

    Args:
        bound: What the value of each node is not above, apart from round-off, shape (n,).
        exact: Values at nodes.
        count: Number of the largest values that are wanted.

    Returns:
        Nodes and values, each of shape (m,) with m >= min(count, n).
    """
    start = min(2 * count, len(bound))
    first = np.sort(np.argpartition(-bound, start - 1)[:start])
    values = exact(first)
    level = np.sort(values)[-min(count, start)]
    reach = bound + _ROUND_OFF * np.abs(bound) >= level
    reach[first] = False
    more = np.flatnonzero(reach)
    if len(more):
        first, values = np.concatenate([first, more]), np.concatenate([values, exact(more)])
    return first, values


def slices(count: int) -> list[slice]:
    """Nodes that are looked at together."""
    return [slice(at, at + _NODES_AT_ONCE) for at in range(0, count, _NODES_AT_ONCE)]


def _length(numbers: Single) -> Single:
    """Length over the second axis of numbers (t, m, n), shape (t, n)."""
    return np.sqrt(np.einsum("tmn,tmn->tn", numbers, numbers))
