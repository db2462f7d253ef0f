"""The materials of a body, and what is attached to it, in words."""

from __future__ import annotations

import numpy as np

from fenics_nnm.fem.contact import ContactInterface
from fenics_nnm.fem.solid import Solid
from fenics_nnm.materials.elasticity import listed
from fenics_nnm.materials.material import STRENGTHS, Material


def material_lines(solid: Solid) -> list[str]:
    """One or two lines a material: its cells, the values used and their source."""
    lines = []
    for region in solid.body.regions:
        material = region.material
        cells = f"cells {', '.join(region.groups)}: " if region.groups else ""
        name = f"{material.name}, " if material.name else ""
        values = f"{material.law.words}, density {material.density:.6g} kg/m^3"
        lines.append(f"material         {cells}{name}{values}")
        if material.law.directional:
            lines.append(f"                 {material.orientation.words}")
        if material.source:
            lines.append(f"                 source: {material.source}")
        lines += [f"                 {line}" for line in _strengths(material)]
    return lines


def _strengths(material: Material) -> list[str]:
    """Strengths of a material in MPa, those that are known, and their source."""
    given = ((name, getattr(material, name)) for name in STRENGTHS)
    known = [(name, value) for name, value in given if value]
    if not known:
        return ["strengths: not known (material.yield_strength, .fatigue_strength)"]
    words = (f"{name.replace('_strength', '')} {value / 1e6:.6g} MPa" for name, value in known)
    source = [f"from: {material.strength_source}"] if material.strength_source else []
    return [f"strengths: {', '.join(words)}", *source]


def attachment_lines(solid: Solid, interface: ContactInterface) -> list[str]:
    """One line for each mass and spring: values and place."""
    lines = []
    for each in solid.body.attachments:
        axes = "xyz"[: len(each.values)]
        amount = f"{each.values[0]:.6g} kg"
        if each.kind == "spring":
            unit = "N/m^3" if each.per_area else "N/m"
            amount = f"{listed(each.values)} {unit} along {', '.join(axes)}"
        place = f"spread over {', '.join(each.facets)}"
        if each.point:
            vertex = solid.vertices[each.key].point
            place = f"at the vertex ({listed(vertex)}) m"
            away = np.linalg.norm(interface.points - vertex, axis=1)
            if each.kind == "mass" and not away.min():
                place += ", a contact point: contact there is an impact, see the theory"
        lines.append(f"{each.key:<17}{amount} {place}")
    return lines
