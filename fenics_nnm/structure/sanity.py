"""Values of a study that look like a wrong unit or a wrong direction, in a line each.

None of them is refused: soft gels, long bridges and small resonators exist. The limits lie beyond
what displacements that are small allow, and beyond what engineering materials have.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.outwards import Leaving, leavings
from fenics_nnm.study import MeshStudy
from fenics_nnm.study.casing import AnyCasing
from fenics_nnm.study.contact import PatchSection
from fenics_nnm.study.messages import shown

#: Gap or interference, and motion at first contact, over the body's largest dimension.
MOST_GAP, MOST_MOTION = 0.05, 0.1

#: Largest dimension of a body in m; Young's moduli in Pa; densities in kg/m^3.
SIZES, MODULI, DENSITIES = (1e-5, 100.0), (1e5, 2e12), (1.0, 3e4)

#: Temperatures in K of solids that are of use; extent of a table over the body's largest dimension.
TEMPERATURES, MOST_EXTENT = (50.0, 2500.0), 20.0

#: Mean angles in degrees to the outward normal: from the first on a contact direction is along the
#: surface, beyond the second into the body. The half degree is for rounding of flat facets.
ALONG, INTO = 80.0, 90.5

#: A small end face may meet a stop sideways, with its edge: of the body's largest dimension, the
#: length of such a face along its direction, and how far the body goes on from there.
END_LENGTH, END_BEYOND = 0.3, 0.05

#: Keys of a casing that say how far it is, the first of those that are given.
_PLACE_OF_CASING = ("radius", "profile", "file", "origin")


def mesh_warnings(study: MeshStudy, linear: LinearAnalysis, mode: int) -> list[str]:
    """What to check in a study of a mesh, a line each; to be called on all ranks.

    Args:
        study: Study.
        linear: All that is linear of its body.
        mode: Index of the mode that is followed, from 0.
    """
    size = float(np.ptp(linear.solid.tagged.bounds(), axis=0).max())
    return [
        *_of_size(study, size),
        *_of_materials(study),
        *_of_temperature(study, linear, size),
        *_of_gaps(study, linear, size),
        *_of_motion(study, linear, mode, size),
        *_of_directions(study, linear, size),
    ]


def _of_size(study: MeshStudy, size: float) -> Iterator[str]:
    smallest, largest = SIZES
    if not smallest <= size <= largest:
        yield (
            f'mesh.length_unit = "{study.mesh.length_unit}": the largest dimension of the body is '
            f"{size:.4g} m, outside {smallest:g} to {largest:g} m: check the unit"
        )


def _of_materials(study: MeshStudy) -> Iterator[str]:
    for number, section in enumerate(study.material, start=1):
        key = "material" if len(study.material) == 1 else f"material[{number}]"
        material = section.material
        yield from _outside(f"{key}.young", material.law.moduli, MODULI, "Pa")
        yield from _outside(f"{key}.density", (material.density,), DENSITIES, "kg/m^3")


def _of_temperature(study: MeshStudy, linear: LinearAnalysis, size: float) -> Iterator[str]:
    load, state = study.load, linear.solid.state
    if load is None or state is None or not state.loads.warming.any:
        return
    yield from _outside(
        "load.reference_temperature", (load.reference_temperature,), TEMPERATURES, "K"
    )
    if load.temperature is not None:
        yield from _outside("load.temperature", (load.temperature,), TEMPERATURES, "K")
        return
    span = tuple(load.reference_temperature + value for value in state.loads.warming.span)
    yield from _outside("load.temperature_field: in the body", span, TEMPERATURES, "K")
    extent = load.extent
    if extent > MOST_EXTENT * size:
        yield (
            f"load.temperature_field.file: its points extend over {extent:.4g} m, "
            f"{_share(extent, size)}: check the unit"
        )


def _outside(
    key: str, values: tuple[float, ...], limits: tuple[float, float], unit: str
) -> Iterator[str]:
    low, high = limits
    if not all(low <= value <= high for value in values):
        listed = ", ".join(f"{value:g}" for value in values)
        text = f"[{listed}]" if len(values) > 1 else listed
        yield f"{key} = {text} {unit}: is outside {low:g} to {high:g} {unit}: check the unit"


def _of_gaps(study: MeshStudy, linear: LinearAnalysis, size: float) -> Iterator[str]:
    """The smallest gap of each patch, or its largest interference.

    Distances between facets of the mesh have no unit of their own: of them only facets that lie
    behind the contact points are told, such as the other end of the body.
    """
    interface = linear.interface
    for number, (key, patch) in enumerate(study.contact.patches.items()):
        gap = float(interface.gap[interface.patch == number].min())
        measured = patch.gap is None and patch.casing is None
        if measured and -gap > MOST_GAP * size:
            yield (
                f"{_given(key, patch)}: lies up to {-gap:.4g} m behind the contact points, "
                f"{_share(-gap, size)}: such an interference is not small: check contact.facets, "
                "against and direction"
            )
        if abs(gap) > MOST_GAP * size and not measured:
            what = "smallest gap" if gap > 0 else "largest interference"
            yield (
                f"{_given(key, patch)}: the {what} is {abs(gap):.4g} m, "
                f"{_share(abs(gap), size)}: {_advice(study)}"
            )


def _of_motion(study: MeshStudy, linear: LinearAnalysis, mode: int, size: float) -> Iterator[str]:
    """The largest displacement at gamma ratio 1."""
    model, interface = linear.model, linear.interface
    rest, amplitude = model.at_rest(), model.grazing_amplitude(mode)
    moved = linear.largest_displacement(
        amplitude * rest.shapes[:, mode], amplitude * rest.pull[:, mode]
    )
    if moved <= MOST_MOTION * size:
        return
    place = f"contact.reference_displacement = {study.contact.reference_displacement} m"
    if rest.is_linear(mode):
        patches = list(study.contact.patches.items())
        place = _given(*patches[interface.patch[rest.first(mode)]])
    yield (
        f"{place}: the largest motion at gamma ratio 1 is {moved:.4g} m, {_share(moved, size)}, "
        f"which is not small: {_advice(study)}, contact.direction and mode.number = {mode + 1}"
    )


def _of_directions(study: MeshStudy, linear: LinearAnalysis, size: float) -> Iterator[str]:
    found = leavings(linear.solid, linear.interface)
    for leaving, (key, patch) in zip(found, study.contact.patches.items(), strict=True):
        if leaving.mean >= ALONG and not _is_end(leaving, size):
            where = "points into the body" if leaving.mean > INTO else "runs along its surface"
            yield (
                f"{key}.direction = {_plain(patch.direction)}: {where}, on average "
                f"{leaving.mean:.3g} degrees away from the outward normal of {key}.facets: must "
                "point from the body to the obstacle: check direction and facets"
            )


def _is_end(leaving: Leaving, size: float) -> bool:
    """Whether a patch is a small end face that moves sideways."""
    sideways = leaving.lowest >= ALONG and leaving.highest <= 180.0 - ALONG
    small = leaving.length <= END_LENGTH * size and leaving.beyond <= END_BEYOND * size
    return sideways and small


def _given(key: str, patch: PatchSection) -> str:
    """What the gap of a patch comes from, with its value."""
    if patch.casing is not None:
        return f"{key}.casing.{_place_of(patch.casing)}"
    if patch.gap is not None:
        return f"{key}.gap = {patch.gap:g} m"
    return f"{key}.against = {_plain(patch.against)}"


def _place_of(casing: AnyCasing) -> str:
    """Key of a casing that says how far it is, with its value."""
    given = {key: getattr(casing, key, None) for key in _PLACE_OF_CASING}
    key, value = next((key, value) for key, value in given.items() if value is not None)
    return f"{key} = {_plain(value)}{'' if key == 'file' else ' m'}"


def _plain(value: Any) -> str:
    """A value as it stands in the study file."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(_plain, value))}]"
    return f"{value:g}" if isinstance(value, float) else shown(value)


def _share(length: float, size: float) -> str:
    """A length in words, by the body's largest dimension."""
    ratio = length / size
    words = f"{100 * ratio:.3g} % of" if ratio < 2 else f"{float(f'{ratio:.3g}'):.15g} times"
    return f"{words} the largest dimension of the body ({size:.4g} m)"


def _advice(study: MeshStudy) -> str:
    return f"check the unit (a number without one is in {study.length_unit})"
