"""The materials of a body, and what is attached to it, in words."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.solid import Solid
from fenics_nnm.materials.elasticity import Isotropic
from fenics_nnm.materials.material import Material
from fenics_nnm.materials.orientation import Axes


def material_lines(solid: Solid) -> list[str]:
    """One or two lines a material: its cells, the values used and their source."""
    lines = []
    for region in solid.body.regions:
        material = region.material
        cells = f"cells {', '.join(region.groups)}: " if region.groups else ""
        name = f"{material.name}, " if material.name else ""
        lines.append(f"material         {cells}{name}{_values(material)}")
        if not isinstance(material.law, Isotropic):
            lines.append(f"                 {_axes(material)}")
        if material.source:
            lines.append(f"                 source: {material.source}")
    return lines


def attachment_lines(solid: Solid, interface: ContactInterface) -> list[str]:
    """One line for each mass and spring: values and place."""
    lines = []
    for each in solid.body.attachments:
        axes = "xyz"[: len(each.values)]
        amount = f"{each.values[0]:.6g} kg"
        if each.kind == "spring":
            unit = "N/m^3" if each.per_area else "N/m"
            amount = f"{_listed(each.values)} {unit} along {', '.join(axes)}"
        place = f"spread over {', '.join(each.facets)}"
        if each.point:
            vertex = solid.vertices[each.key].point
            place = f"at the vertex ({_listed(vertex)}) m"
            away = np.linalg.norm(interface.points - vertex, axis=1)
            if each.kind == "mass" and not away.min():
                place += ", a contact point: contact there is an impact, see the theory"
        lines.append(f"{each.key:<17}{amount} {place}")
    return lines


def _values(material: Material) -> str:
    law, density = material.law, f"density {material.density:.6g} kg/m^3"
    if isinstance(law, Isotropic):
        return f"E {law.young / 1e9:.6g} GPa, Poisson's ratio {law.poisson:g}, {density}"
    return (
        f"E1, E2, E3 {_listed(law.young, 1e9)} GPa, nu12, nu23, nu13 {_listed(law.poisson)}, "
        f"G12, G23, G13 {_listed(law.shear, 1e9)} GPa, {density}"
    )


def _axes(material: Material) -> str:
    turning = material.orientation
    if isinstance(turning, Axes):
        rows = [f"({_listed(row)})" for row in np.round(turning.matrix, 12) + 0.0]
        return f"axes 1, 2, 3 along {', '.join(rows)}"
    return (
        f"axes 1, 2, 3 radial, circumferential, along ({_listed(turning.axis)}) through "
        f"({_listed(turning.origin)}) m"
    )


def _listed(values: Iterable[float], unit: float = 1.0) -> str:
    return ", ".join(f"{value / unit:.5g}" for value in values)
