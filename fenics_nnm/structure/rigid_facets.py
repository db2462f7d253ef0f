"""From the sections [[rigid]] of a study to constraints, and lines about them."""

from __future__ import annotations

from fenics_nnm.errors import ModelError
from fenics_nnm.fem.constraint_builder import ALL
from fenics_nnm.fem.constraints import (
    AXES,
    Coupling,
    LinearConstraints,
    Reference,
    Six,
    diagonal,
)
from fenics_nnm.materials.elasticity import listed
from fenics_nnm.study import MeshStudy
from fenics_nnm.study.record import fitted
from fenics_nnm.study.rigid import AXIS_NAMES, RigidSection

#: Number of moments of inertia of a body of each dimension.
_MOMENTS = {1: 0, 2: 1, 3: 3}


def rigid_facets(study: MeshStudy, dim: int) -> LinearConstraints:
    """The rigid facets of a study on a mesh of some dimension.

    Raises:
        ModelError: if a point, an inertia or a direction does not go with the dimension.
    """
    references: list[Reference] = []
    couplings: list[Coupling] = []
    for number, each in enumerate(study.rigid, start=1):
        key = f"rigid[{number}]" if len(study.rigid) > 1 else "rigid"
        point = (*fitted(each.at, dim, f"{key}.at"), 0.0, 0.0)[:3]
        mass = _mass(each, dim, f"{key}.inertia")
        held = _held(each, dim, f"{key}.directions")
        couplings.append(Coupling(key, "rigid", len(references), ALL, facets=each.facets))
        references.append(Reference(key, point, mass=mass, held=held))
    return LinearConstraints(tuple(references), tuple(couplings))


def rigid_lines(constraints: LinearConstraints) -> list[str]:
    """One line for each group of rigid facets: point, mass and what is held."""
    lines = []
    for coupling in constraints.couplings:
        if coupling.facets:
            point = constraints.references[coupling.reference]
            words = f"{', '.join(coupling.facets)} about ({listed(point.point)}) m"
            words += f", {point.mass[0][0]:.6g} kg" if point.mass[0][0] else ""
            held = ", ".join(AXIS_NAMES[axis] for axis in point.held)
            words += f", held along {held}" if held else ""
            lines.append(f"{coupling.key:<17}{words}")
    return lines


def _mass(section: RigidSection, dim: int, key: str) -> Six:
    mass, moments = section.mass or 0.0, section.inertia or ()
    if moments and len(moments) != _MOMENTS[dim]:
        raise ModelError(
            f"{key} = {list(moments)}: must have {_MOMENTS[dim]} numbers on a mesh of dimension "
            f"{dim}"
        )
    about = {1: (0.0,) * 3, 2: (0.0, 0.0, *moments), 3: moments}[dim] if moments else (0.0,) * 3
    return diagonal((mass,) * 3 + tuple(about))


def _held(section: RigidSection, dim: int, key: str) -> tuple[int, ...]:
    found = sorted(AXIS_NAMES.index(name) for name in section.directions or ())
    beyond = [axis for axis in found if axis not in AXES[dim]]
    if beyond:
        raise ModelError(
            f'{key}: "{AXIS_NAMES[beyond[0]]}" is no direction of a mesh of dimension {dim}'
        )
    return tuple(found)
