"""The largest displacement, stress and contact force of each point of a branch.

Stresses are those of exported files: recovered at the nodes and sought at the same instants, so
that the largest one is the largest one of peak_stress_RATIO.vtu.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from fenics_nnm.arrays import Array, Indices
from fenics_nnm.backbone.extremes import Extremes, PatchExtremes, Spot
from fenics_nnm.fields.body import FieldBody, field_body
from fenics_nnm.fields.frames import Frames
from fenics_nnm.fields.invariants import von_mises
from fenics_nnm.fields.kept_bases import KeptBases
from fenics_nnm.fields.largest import Largest, Nodes, first_of_largest
from fenics_nnm.fields.parts import NODES_OF_PART, compact_parts
from fenics_nnm.fields.peak import largest_tension
from fenics_nnm.fields.screening import (
    Bounds,
    LengthScreen,
    StressScreen,
    length_screen,
    stress_screen,
    with_largest,
)
from fenics_nnm.fields.shapes import MotionShapes, motion_shapes
from fenics_nnm.fields.singular import singular_kinds
from fenics_nnm.fields.strength import Strengths
from fenics_nnm.fields.stress_basis import StressBasis, stress_basis, used_shapes
from fenics_nnm.fields.thinned import Thinned, thinned
from fenics_nnm.mechanics.force_history import force_history
from fenics_nnm.mechanics.motion import Motion
from fenics_nnm.results.stored_branch import PlacedMotion, StoredBranch

#: Motions that are screened together.
_AT_ONCE = 8

#: Bytes that the stress of a shape takes at a node, and how many are kept at most.
_BYTES, _MOST = 6 * 12, 2**30


@dataclass(frozen=True, slots=True)
class _Placed:
    """A motion that has no place on a branch."""

    motion: Motion
    position: float = float("nan")


@dataclass(slots=True)
class _Stresses:
    """Largest stresses of one point, and how near they come to what materials bear."""

    mises: Largest
    principal: Largest
    yields: Largest
    goodman: Largest


@dataclass(frozen=True, slots=True)
class _Part:
    """A part of the body with the stresses of shapes."""

    basis: StressBasis
    screen: StressScreen
    nodes: Nodes
    static: Array  # (n, 6), stress of the state of rest

    def bounds(self, motions: Sequence[Thinned]) -> list[Bounds]:
        """Bounds at all nodes of each motion."""
        return self.screen.bounds([motion.of(self.basis.used) for motion in motions])

    def mises(self, amounts: Array, few: Indices) -> Array:
        """Largest von Mises stress over time of some nodes."""
        return von_mises(self.basis.stress(amounts, few)).max(axis=0)


@dataclass(frozen=True, slots=True)
class ExtremesOf:
    """Finds extremes of motions of a branch with a mesh.

    Attributes:
        branch: Branch; its points are not needed.
        body: Its body.
        shapes: What its motions are made of.
        kinds: Number in `KINDS` of each node of the body.
        region: Number of the material of each.
        strengths: Strengths of the materials.
        phase: Instants at which displacement and stress are sought, as phases.
        patches: Nodes of each contact patch.
        bases: Keeps stresses of the shapes.
    """

    branch: StoredBranch
    body: FieldBody
    shapes: MotionShapes
    kinds: Indices
    region: Indices
    strengths: Strengths
    phase: Array
    patches: tuple[Indices, ...]
    bases: KeptBases
    _asked: list[_Part] = field(default_factory=list)

    def of(self, points: Sequence[PlacedMotion]) -> tuple[Extremes, ...]:
        """Extremes of points, in their order."""
        motions = [self._thinned(point) for point in points]
        lengths, patches = self._lengths(), self._shapes_of_patches()
        moved = [
            self._moved(each, bound, patches)
            for few in _together(motions)
            for each, bound in zip(few, lengths.bounds(few), strict=True)
        ]
        stresses = self._stresses(motions)
        forces = [self._forces(point) for point in points]
        return tuple(_extremes(*each) for each in zip(moved, stresses, forces, strict=True))

    def amplitude(self, motion: Motion) -> float:
        """Largest displacement of a motion in m."""
        thin = self._thinned(_Placed(motion))
        return self._largest_moved(thin, self._lengths().bounds([thin])[0]).value

    def stress(self, motion: Motion) -> float:
        """Largest von Mises stress of a motion in Pa, away from singular places."""
        thin, mises = self._thinned(_Placed(motion)), Largest(len(self.body.mesh.nodes))
        for part in self._for_many():
            (bounds,) = part.bounds([thin])
            mises.add_regular(part.nodes, bounds.mises, partial(part.mises, thin.amounts))
        return mises.away.value

    def _for_many(self) -> Iterable[_Part]:
        """The parts of the body, kept for the next motion unless they are large."""
        shapes, nodes = self.branch.shapes, len(self.body.mesh.nodes)
        if _BYTES * nodes * (len(shapes) + len(self.branch.residual_shapes)) > _MOST:
            return self._parts(np.arange(self.shapes.count))
        if not self._asked:
            self._asked.extend(self._parts(np.arange(self.shapes.count)))
        return self._asked

    def of_mode(self, mode: int, amplitude: float) -> Extremes:
        """Extremes of a linear mode about the state of rest, at both its reversals.

        Second-order displacement is left out: most of its stress is that of stretching, which the
        other modes take back when they follow.

        Args:
            mode: Its index, from 0.
            amplitude: Its amplitude in kg^1/2 m.
        """
        rest = self.branch.header.model.at_rest()
        swings = [sign * amplitude for sign in (1, -1)]
        amounts = np.array(
            [
                self.shapes.of(
                    rest.q + swing * rest.shapes[:, mode], rest.force + swing * rest.pull[:, mode]
                )
                for swing in swings
            ]
        )
        motion = thinned(amounts, np.arange(2.0))
        (bound,) = self._lengths().bounds([motion])
        moved, of_patches = self._moved(motion, bound, self._shapes_of_patches())
        (stresses,) = self._stresses([motion])
        none = np.zeros((1, len(of_patches)))
        return _extremes((moved, of_patches), stresses, (none, none[0]))

    def _thinned(self, point: PlacedMotion) -> Thinned:
        return thinned(self.shapes.amounts(point, self.phase), self.phase)

    def _lengths(self) -> LengthScreen:
        """Displacements of the shapes in single precision."""
        branch = self.branch
        return length_screen(len(branch.nodes), branch.shapes.shape[2], self.shapes.at)

    def _shapes_of_patches(self) -> list[Array]:
        """Displacements of the shapes at the nodes of each patch, each (shapes, nodes, dim)."""
        return [self.shapes.at(nodes) for nodes in self.patches]

    def _moved(self, motion: Thinned, bound: Array, patches: Sequence[Array]) -> tuple[Spot, Array]:
        """The largest displacement, and that of the nodes of each patch, shape (patches,)."""
        of_patches = [
            _lengths_of(motion.amounts, own).max() if own.size else np.nan for own in patches
        ]
        return self._largest_moved(motion, bound), np.array(of_patches)

    def _largest_moved(self, motion: Thinned, bound: Array) -> Spot:
        """The largest displacement, which is not above a bound at each node, shape (n,)."""

        def exact(few: Indices) -> Array:
            return _lengths_of(motion.amounts, self.shapes.at(few))

        found, values = with_largest(bound, exact, 1)
        at = first_of_largest(values, found)
        x, y, z = (float(each) for each in self.branch.nodes[found[at]])
        return Spot(float(values[at]), int(found[at]), (x, y, z))

    def _forces(self, point: PlacedMotion) -> tuple[Array, Array]:
        """Forces of each patch in N, (instants, patches), and its impulse a period in N s."""
        branch, series = self.branch, self.branch.series
        forces = force_history(branch.header.model, series, point.motion)
        of_patch = branch.contact_patches[:, None] == np.arange(len(self.patches))
        mean = series.weight @ point.motion.force
        return forces @ of_patch, mean @ of_patch / point.motion.frequency

    def _stresses(self, motions: Sequence[Thinned]) -> list[_Stresses]:
        """Stresses of motions, part by part of the body."""
        total = len(self.body.mesh.nodes)
        found = [_Stresses(*(Largest(total) for _ in range(4))) for _ in motions]
        used = used_shapes(self.shapes, [self._rest, *(each.amounts for each in motions)])
        for part in self._parts(used):
            own = iter(found)
            for few in _together(motions):
                for each, bounds in zip(few, part.bounds(few), strict=True):
                    self._add(next(own), each.amounts, bounds, part)
        return found

    @property
    def _rest(self) -> Array:
        """Amounts of the state of rest, shape (1, shapes)."""
        state = self.branch.header.model.at_rest()
        return self.shapes.of(state.q, state.force)[None]

    def _parts(self, used: Indices) -> Iterator[_Part]:
        """The parts of the body, with the stresses of some shapes at least."""
        mesh, rest = self.body.mesh, self._rest
        for number, part in enumerate(compact_parts(mesh.nodes, NODES_OF_PART)):
            make = partial(stress_basis, self.body, self.shapes, part, used)
            basis = self.bases.get(number, used, make)
            static = basis.stress(rest)[0]
            yield _Part(
                basis,
                stress_screen(basis.stresses, static.T, basis.steady),
                Nodes(mesh.origin[part], mesh.nodes[part], self.kinds[part], self.region[part]),
                static,
            )

    def _add(self, found: _Stresses, amounts: Array, bounds: Bounds, part: _Part) -> None:
        """Take a part of the body into account, for a motion of amounts (t, shapes)."""
        nodes, strengths = part.nodes, self.strengths

        def stress(few: Indices) -> Array:
            return part.basis.stress(amounts, few)

        def tension(few: Indices) -> Array:
            own = stress(few)
            return largest_tension(own, von_mises(own))[0]

        def goodman(few: Indices) -> Array:
            change = von_mises(stress(few) - part.static[few]).max(axis=0)
            return strengths.goodman_share(change, steady[few], nodes.region[few])

        found.mises.add(nodes, bounds.mises, partial(part.mises, amounts))
        found.principal.add(nodes, bounds.tension, tension)
        found.yields.add_regular(
            nodes,
            strengths.yield_share(bounds.mises, nodes.region),
            lambda few: strengths.yield_share(part.mises(amounts, few), nodes.region[few]),
        )
        if strengths.any_fatigue:
            steady = von_mises(part.static)
            bound = strengths.goodman_share(bounds.change, steady, nodes.region)
            found.goodman.add_regular(nodes, bound, goodman)


def extremes_of(
    branch: StoredBranch, frames: int, strengths: Strengths, bases: KeptBases
) -> ExtremesOf:
    """Prepare what finds extremes of motions.

    Args:
        branch: Branch.
        frames: Frames of a period of its files, at whose instants stress is sought besides others.
        strengths: Strengths of the materials of its body, by their number.
        bases: Keeps stresses of its shapes.
    """
    body, shapes = field_body(branch), motion_shapes(branch, ())
    region = np.empty(len(body.mesh.nodes), dtype=np.int64)
    region[body.mesh.cells] = branch.region[:, None]
    times, _ = Frames(frames, reversible=not branch.series.free_phase).searched()
    return ExtremesOf(
        branch=branch,
        body=body,
        shapes=shapes,
        kinds=singular_kinds(branch, body.mesh),
        region=region,
        strengths=strengths,
        phase=2 * np.pi * times,
        patches=_patches(branch),
        bases=bases,
    )


def _together(motions: Sequence[Thinned]) -> list[Sequence[Thinned]]:
    """Motions that are screened in one go."""
    return [motions[start : start + _AT_ONCE] for start in range(0, len(motions), _AT_ONCE)]


def _lengths_of(amounts: Array, shapes: Array) -> Array:
    """Largest displacement over time of amounts (t, shapes) of shapes (shapes, n, dim), (n,)."""
    field = np.tensordot(amounts, shapes, 1)
    return np.sqrt(np.einsum("tni,tni->tn", field, field).max(axis=0))


def _extremes(
    moved: tuple[Spot, Array], stresses: _Stresses, forces: tuple[Array, Array]
) -> Extremes:
    """Extremes of displacements, stresses, and forces (instants, patches) with their impulses."""
    displacement, of_patches = moved
    force, impulses = forces
    listed = zip(of_patches, force.max(axis=0), impulses, strict=True)
    return Extremes(
        displacement=displacement,
        patches=tuple(PatchExtremes(*map(float, each)) for each in listed),
        force=float(force.sum(axis=1).max()),
        impulse=float(impulses.sum()),
        von_mises=stresses.mises.peak,
        principal=stresses.principal.peak,
        yield_margin=_margin(stresses.yields.away),
        goodman_margin=_margin(stresses.goodman.away),
    )


def _patches(branch: StoredBranch) -> tuple[Indices, ...]:
    """Nodes of each contact patch, on its own side."""
    own = branch.facet_side == 0
    return tuple(
        np.unique(branch.contact_facets[own & (branch.facet_patch == number)])
        for number in range(int(branch.contact_patches.max()) + 1)
    )


def _margin(share: Spot) -> Spot:
    """The margin of the largest share of a strength."""
    if not share.known:
        return Spot()
    return Spot(1 / share.value if share.value else float("inf"), share.node, share.place)
