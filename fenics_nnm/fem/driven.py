"""Where a body is driven: forces, dashpots and monitors."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from dolfinx import fem
from dolfinx.fem.petsc import assemble_matrix

from fenics_nnm.arrays import Array
from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.attachments import spread_form
from fenics_nnm.fem.block import product
from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.point_rows import attached_points, force_row, unit_rows
from fenics_nnm.fem.pushes import Push
from fenics_nnm.fem.solid import Solid
from fenics_nnm.mechanics.moving_gap import STILL, GapMotion
from fenics_nnm.reduction.driven import DrivenPlaces


@dataclass(frozen=True, slots=True)
class Others:
    """Places at a body besides those of forces.

    Attributes:
        dashpots: Dashpots to the ground.
        monitors: Places that are watched.
    """

    dashpots: tuple[Attachment, ...] = ()
    monitors: tuple[Attachment, ...] = ()


def driven_places(
    solid: Solid,
    interface: ContactInterface,
    pushes: Iterable[Push],
    others: Others,
    gap_motion: GapMotion = STILL,
) -> DrivenPlaces:
    """Where a body is driven, damped and watched; to be called on all ranks.

    Raises:
        MeshError: if a force acts where it has no effect, or not on the body.
    """
    found = [push.column(solid) for push in pushes]
    monitors = [force_row(solid, each) for each in others.monitors]
    dampers = Dampers.of(solid, others.dashpots)
    return DrivenPlaces(
        springs=attached_points(solid),
        excited=np.column_stack([np.zeros((solid.owned, 0)), *(column for column, _ in found)]),
        sizes=np.array([size for _, size in found], float),
        monitored=np.reshape(monitors, (-1, solid.owned)).T,
        dampers=dampers.rows,
        contact=interface.unit_forces(solid.owned),
        gap=interface.gap,
        damping=dampers.forces,
        gap_motion=gap_motion,
    )


@dataclass(frozen=True, slots=True)
class Dampers:
    """Dashpots at a body.

    Attributes:
        solid: Body.
        spread: Those over facets, which resist the velocity at each place of them.
        rows: Unit forces along each axis of each dashpot with damping, shape (n_owned, d).
        values: Damping of those at vertices in N s/m, 0 for those over facets, shape (d,).
    """

    solid: Solid
    spread: tuple[Attachment, ...]
    rows: Array
    values: Array

    @classmethod
    def of(cls, solid: Solid, dashpots: tuple[Attachment, ...]) -> Dampers:
        """Dashpots of a body.

        Raises:
            MeshError: if one is not on the body, or clamped.
        """
        rows: list[Array] = [np.zeros((solid.owned, 0))]
        values: list[Array] = [np.zeros(0)]
        held = solid.clamped[solid.clamped < solid.owned]
        for each in dashpots:
            force_row(solid, each)  # refuses what is clamped
            own, damping = unit_rows(solid, each), np.array(each.values)
            own[held] = 0.0
            moves = solid.tagged.mesh.comm.allreduce(np.abs(own).sum(axis=0)) > 0
            chosen = moves & (damping > 0)
            rows.append(own[:, chosen])
            values.append(damping[chosen] if each.point else np.zeros(chosen.sum()))
        spread = tuple(each for each in dashpots if not each.point)
        return cls(solid, spread, np.hstack(rows), np.concatenate(values))

    def forces(self, columns: Array) -> Array:
        """C u of columns u at the owned degrees of freedom; to be called on all ranks."""
        solid = self.solid
        moved = solid.tagged.mesh.comm.allreduce(self.rows.T @ columns)
        found = self.rows @ (self.values[:, None] * moved)
        for each in self.spread:
            form = spread_form(solid.space, solid.tagged, each, solid.clamped, solid.body.extent)
            matrix = assemble_matrix(fem.form(form))
            matrix.assemble()
            found += product(matrix, columns)
            matrix.destroy()
        return np.asarray(found)
