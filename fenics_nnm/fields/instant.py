"""Fields of a motion at one instant, in memory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array, in_space
from fenics_nnm.fields.body import FieldBody, field_body
from fenics_nnm.fields.invariants import von_mises
from fenics_nnm.fields.motion import DISPLACEMENT, VELOCITY
from fenics_nnm.fields.parts import compact_parts
from fenics_nnm.fields.recovery import FieldMesh
from fenics_nnm.fields.shapes import MotionShapes, motion_shapes
from fenics_nnm.fields.stress_basis import stress_basis
from fenics_nnm.fields.stress_rows import VON_MISES
from fenics_nnm.results.stored_branch import PlacedMotion, StoredBranch

#: Nodes whose stresses are recovered at once.
_NODES_AT_ONCE = 8192


@dataclass(frozen=True, slots=True)
class Instant:
    """A motion at one instant.

    Attributes:
        mesh: Mesh; nodes at which materials meet are there once for each material.
        fields: Arrays at its nodes, by the names that they have in ParaView files.
    """

    mesh: FieldMesh
    fields: Mapping[str, Array]


def instant(branch: StoredBranch, point: PlacedMotion, part: float, *, stress: bool) -> Instant:
    """Displacement, velocity and, if wanted, von Mises stress of a motion.

    Args:
        branch: Branch on its mesh.
        point: Point of it.
        part: The instant as a part of the period.
        stress: Whether the stress is wanted, which includes that of steady loads.
    """
    body, shapes = field_body(branch), motion_shapes(branch, [point])
    phase = np.array([2 * np.pi * part])
    amounts, rates = shapes.amounts(point, phase), shapes.rates(point, phase)
    moved, moving = shapes.fields(np.concatenate([amounts, rates]))
    fields = {
        DISPLACEMENT: in_space(body.on_grid(moved)),
        VELOCITY: in_space(body.on_grid(moving)),
    }
    if stress:
        fields[VON_MISES] = _von_mises(body, shapes, amounts)
    return Instant(body.mesh, fields)


def _von_mises(body: FieldBody, shapes: MotionShapes, amounts: Array) -> Array:
    """Von Mises stress in Pa of amounts (1, shapes) at the nodes of the grid, shape (nodes,)."""
    found = np.empty(len(body.mesh.nodes))
    for part in compact_parts(body.mesh.nodes, _NODES_AT_ONCE):
        found[part] = von_mises(stress_basis(body, shapes, part).stress(amounts)[0])
    return found
