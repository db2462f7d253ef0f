"""Stresses of motions in a part of a body, as sums of those of the shapes they are made of.

Stress is linear in Green and Lagrange's strain sym(grad u) + 1/2 grad u^T grad u of the motion.
With the second-order displacement of masters i, j its parts of second order are those of the pairs,

    sym(grad theta_ij) + sym(grad phi_i^T grad phi_j),

which belong together: where a beam bends, both are large along it, and nothing is left of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.fields.body import FieldBody
from fenics_nnm.fields.shapes import MotionShapes

#: Shapes whose stresses are recovered together.
_AT_ONCE = 8


@dataclass(frozen=True, slots=True)
class StressBasis:
    """Recovered stress of shapes of a branch: its change is linear in their amounts.

    A motion at many instants, or several motions, then cost a matrix product.

    Attributes:
        shapes: Shapes.
        used: Numbers of those whose stresses are known, ascending.
        stresses: Stress of each in Pa at the nodes of the part, shape (used, 6, nodes).
        steady: Stress of steady loads there, shape (6, nodes); none, shape (6, 0), without them.
    """

    shapes: MotionShapes
    used: Indices
    stresses: Array
    steady: Array

    def stress(self, amounts: Array, nodes: slice | Indices = slice(None)) -> Array:
        """Stress in Pa of amounts (k, shapes) at nodes of the part, shape (k, nodes, 6).

        Raises:
            ValueError: if there is some of a shape whose stress is not known.
        """
        own = amounts[:, self.used]
        if np.count_nonzero(own) != np.count_nonzero(amounts):
            raise ValueError("amounts of shapes whose stresses are not known: must be zero")
        changes = own @ self.stresses[..., nodes].swapaxes(0, 1)  # (6, k, nodes)
        if self.steady.size:
            changes += self.steady[:, None, nodes]
        return np.moveaxis(changes, 0, 2)


def used_shapes(shapes: MotionShapes, amounts: Iterable[Array]) -> Indices:
    """Numbers of the shapes that some motions of amounts (k, shapes) are made of, ascending.

    Of all contact points few touch, and the shapes of the others need no stresses. With
    second-order displacement all shapes count.
    """
    if shapes.pairs.first.size:
        return np.arange(shapes.count)
    return np.flatnonzero(np.logical_or.reduce([each.any(axis=0) for each in amounts]))


def stress_basis(
    body: FieldBody, shapes: MotionShapes, nodes: Indices, used: Indices | None = None
) -> StressBasis:
    """Recover the stresses of shapes at some nodes of the grid, in ascending order.

    Args:
        body: Body.
        shapes: Shapes.
        nodes: Nodes.
        used: Numbers of the shapes, as of `used_shapes`; all of them if not given.
    """
    recovery = body.recovery(nodes)
    displacements = shapes.at(body.mesh.origin[recovery.nodes])
    known = np.arange(len(displacements)) if used is None else used
    stresses = np.empty((len(known), 6, len(nodes)))
    for start in range(0, len(known), _AT_ONCE):
        few = slice(start, start + _AT_ONCE)
        stresses[few] = np.swapaxes(recovery.at_nodes_of_each(displacements[known[few]]), 1, 2)
    if shapes.pairs.first.size:
        modes = (displacements[each] for each in shapes.masters_of_pairs)
        stresses[shapes.of_pairs] += np.swapaxes(recovery.at_nodes_of_pairs(*modes), 1, 2)
    steady = recovery.of_samples(body.steady).T if len(body.steady) else np.empty((6, 0))
    return StressBasis(shapes, known, stresses, steady)
