"""Linear constraints on the nodes of a body, as mesh files and studies give them.

Nodes follow a reference point as a rigid body, or the point follows their weighted mean motion;
equations join single displacements. All of them are homogeneous and linear: rotations are small.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np

from fenics_nnm.arrays import Array, Indices

#: Mass or stiffness of a point along its axes x, y, z, rx, ry, rz.
Six = tuple[tuple[float, ...], ...]

NOTHING: Six = ((0.0,) * 6,) * 6

#: Axes of a point that a body of each dimension has: displacements, then rotations.
AXES = {1: (0,), 2: (0, 1, 5), 3: (0, 1, 2, 3, 4, 5)}


@dataclass(frozen=True, slots=True)
class Reference:
    """A point that moves along x, y, z and turns about them: axes 0 to 5.

    Attributes:
        key: What it is and where it is named, for messages.
        point: Coordinates, shape (3,).
        names: Names of sets of nodes it belongs to, by which a clamp can hold it.
        mass: Mass and inertia about it in kg, kg m and kg m^2.
        stiffness: Springs to the ground in N/m, N and N m.
        held: Axes along which it does not move.
        node: Row of the node of the mesh that it is, -1 for a point of its own.
    """

    key: str
    point: tuple[float, ...]
    names: tuple[str, ...] = ()
    mass: Six = NOTHING
    stiffness: Six = NOTHING
    held: tuple[int, ...] = ()
    node: int = -1

    @property
    def attached(self) -> bool:
        """Whether it has mass or springs."""
        return self.mass != NOTHING or self.stiffness != NOTHING

    def with_mass(self, mass: Six) -> Reference:
        """The same with more mass."""
        return replace(self, mass=_sum(self.mass, mass))

    def with_stiffness(self, stiffness: Six) -> Reference:
        """The same with more springs."""
        return replace(self, stiffness=_sum(self.stiffness, stiffness))


@dataclass(frozen=True, slots=True)
class Coupling:
    """Nodes and a reference point that move together.

    Attributes:
        key: The line of a mesh file, or the study's section.
        kind: "rigid": nodes follow the point along `axes`; "mean": the point follows the nodes
            along `axes`, in the weighted least-squares sense.
        reference: Place of the point among the references.
        axes: Axes from 0 to 5.
        nodes: Rows of the points of the mesh.
        facets: Names of groups of facets whose nodes are meant besides.
        followers: Places of other references that follow as nodes do.
        weights: Weight of each node along x, y and z, for "mean".
    """

    key: str
    kind: Literal["rigid", "mean"]
    reference: int
    axes: tuple[int, ...]
    nodes: tuple[int, ...] = ()
    facets: tuple[str, ...] = ()
    followers: tuple[int, ...] = ()
    weights: tuple[tuple[float, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class Equation:
    """Sum of coefficients times displacements = 0; the first one is preferred as dependent.

    Attributes:
        key: The line of a mesh file.
        terms: Node, axis and coefficient of each; the node is a row of the points of the mesh, or
            -1 - r of reference r.
    """

    key: str
    terms: tuple[tuple[int, int, float], ...]


@dataclass(frozen=True, slots=True)
class LinearConstraints:
    """All constraints of a body.

    Attributes:
        references: Points of their own.
        couplings: Nodes that move with them.
        equations: Equations between nodes.
    """

    references: tuple[Reference, ...] = ()
    couplings: tuple[Coupling, ...] = ()
    equations: tuple[Equation, ...] = ()

    @property
    def keys(self) -> tuple[str, ...]:
        """Where they are named, each once."""
        named = [each.key for each in self.couplings] + [each.key for each in self.equations]
        held = [each.key for each in self.references if each.held]
        return tuple(dict.fromkeys([*named, *held]))

    @property
    def joining(self) -> bool:
        """Whether there is anything to follow."""
        return bool(self.references or self.couplings or self.equations)

    def assert_rows(self, count: int) -> None:
        """Refuse rows of points or references that are not there.

        Args:
            count: Number of points of the mesh.

        Raises:
            IndexError: if there are some.
        """
        points = len(self.references)
        nodes = [node for each in self.couplings for node in each.nodes]
        nodes += [node for each in self.equations for node, _, _ in each.terms if node >= 0]
        nodes += [each.node for each in self.references if each.node != -1]
        own = [-1 - n for each in self.equations for n, _, _ in each.terms if n < 0]
        own += [place for each in self.couplings for place in (each.reference, *each.followers)]
        if any(not 0 <= n < count for n in nodes) or any(not 0 <= place < points for place in own):
            raise IndexError("constraints name a row that is not there")

    def renumbered(self, row: Indices) -> LinearConstraints:
        """The same for points that stand elsewhere.

        Args:
            row: New row of each point.
        """

        def new(node: int) -> int:
            return int(row[node]) if node >= 0 else node

        return LinearConstraints(
            tuple(replace(each, node=new(each.node)) for each in self.references),
            tuple(_of_nodes(each, row) for each in self.couplings),
            tuple(
                replace(each, terms=tuple((new(n), axis, value) for n, axis, value in each.terms))
                for each in self.equations
            ),
        )

    def widened(self, wider: Callable[[Indices], Indices]) -> LinearConstraints:
        """The same with more nodes in each rigid coupling, as `wider` says of its own."""
        return replace(
            self,
            couplings=tuple(
                replace(each, nodes=_whole(wider(np.array(each.nodes, dtype=np.int64))))
                if each.kind == "rigid" and each.nodes
                else each
                for each in self.couplings
            ),
        )

    def scaled(self, metres: float) -> LinearConstraints:
        """The same with lengths in m in place of a unit of `metres` m."""
        return replace(
            self,
            references=tuple(
                replace(each, point=tuple(metres * x for x in each.point))
                for each in self.references
            ),
            equations=tuple(
                replace(each, terms=tuple(_in_metres(term, metres) for term in each.terms))
                for each in self.equations
            ),
        )

    def and_also(self, other: LinearConstraints) -> LinearConstraints:
        """These and others, whose references come after these."""
        before = len(self.references)
        return LinearConstraints(
            (*self.references, *other.references),
            (*self.couplings, *(_moved(each, before) for each in other.couplings)),
            (*self.equations, *(_moved_equation(each, before) for each in other.equations)),
        )

    def holding(self, names: tuple[str, ...], axes: tuple[int, ...]) -> LinearConstraints:
        """The same with the references of some sets held along some axes."""
        return replace(
            self,
            references=tuple(
                replace(each, held=tuple(sorted({*each.held, *axes})))
                if set(names) & set(each.names)
                else each
                for each in self.references
            ),
        )


#: None at all.
NO_CONSTRAINTS = LinearConstraints()


def diagonal(values: tuple[float, ...]) -> Six:
    """Six by six numbers from those on the diagonal."""
    return as_six(np.diag(values))


def as_six(matrix: Array) -> Six:
    """Six by six numbers from an array."""
    return tuple(tuple(float(x) for x in row) for row in matrix)


def inertia_at(mass: float, offset: Array, inertia: Array) -> Six:
    """Mass matrix about a point of a rigid body whose centre of mass lies beside it.

    With x the offset and u = r + theta x x of the centre of mass,

        [m I, -m X; m X, J - m X X],  X y = x x y.

    Args:
        mass: Mass m.
        offset: From the point to the centre of mass, shape (3,).
        inertia: Inertia J about the centre of mass, shape (3, 3).
    """
    x, y, z = offset
    X = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    top = np.hstack([mass * np.eye(3), -mass * X])
    return as_six(np.vstack([top, np.hstack([mass * X, inertia - mass * X @ X])]))


def to_json(constraints: LinearConstraints) -> dict[str, Any]:
    """As what JSON can hold."""
    return asdict(constraints)


def from_json(words: Mapping[str, Any]) -> LinearConstraints:
    """From what `to_json` made, written and read, which knows no tuples."""
    kinds = {"references": Reference, "couplings": Coupling, "equations": Equation}
    return LinearConstraints(
        **{
            name: tuple(
                kind(**{key: _tuples(value) for key, value in each.items()}) for each in words[name]
            )
            for name, kind in kinds.items()
        }
    )


def _tuples(value: Any) -> Any:
    return tuple(_tuples(each) for each in value) if isinstance(value, list) else value


def _sum(first: Six, second: Six) -> Six:
    return as_six(np.array(first) + np.array(second))


def _of_nodes(coupling: Coupling, row: Indices) -> Coupling:
    """A coupling of nodes that stand elsewhere; where two became one, it counts once."""
    new = row[np.array(coupling.nodes, dtype=np.int64)]
    nodes, first = np.unique(new, return_index=True)
    weights = tuple(coupling.weights[i] for i in first) if coupling.weights else ()
    return replace(coupling, nodes=_whole(nodes), weights=weights)


def _whole(nodes: Indices) -> tuple[int, ...]:
    return tuple(int(node) for node in nodes)


def _in_metres(term: tuple[int, int, float], metres: float) -> tuple[int, int, float]:
    """A term of a displacement in m; angles have no unit."""
    node, axis, value = term
    return node, axis, value / metres if axis < 3 else value


def _moved(coupling: Coupling, before: int) -> Coupling:
    followers = tuple(each + before for each in coupling.followers)
    return replace(coupling, reference=coupling.reference + before, followers=followers)


def _moved_equation(equation: Equation, before: int) -> Equation:
    terms = tuple((n - before if n < 0 else n, axis, value) for n, axis, value in equation.terms)
    return replace(equation, terms=terms)
