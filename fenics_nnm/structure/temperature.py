"""From the section of a study about temperature to the warming of its body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.fem.solid import Solid
from fenics_nnm.fem.warming import UniformWarming, Warming, WarmingField, scalar_field
from fenics_nnm.geometry.temperature import HOTTEST, Temperatures
from fenics_nnm.study.loading import LoadSection

_KEY = "load.temperature_field"


def warming_of(load: LoadSection, solid: Solid) -> Warming:
    """The warming of a body; to be called on all ranks.

    Raises:
        GeometryError: if its table cannot be read.
        ModelError: if a temperature is not given where the body is, or is that of no solid.
    """
    if load.temperature_field is None:
        return UniformWarming(load.warming)
    given = load.temperature_field.temperatures()
    found = _read_at_nodes(given, solid)
    low, high = found.span
    if not 0 < low <= high <= HOTTEST:
        raise ModelError(
            f"{_KEY}: is {low:.6g} to {high:.6g} K in the body: must be above absolute zero and at "
            f"most {HOTTEST:g} K"
        )
    reference = load.reference_temperature
    if low == high == reference:
        raise ModelError(
            f"{_KEY}: is reference_temperature = {reference:g} everywhere in the body, so has no "
            "effect: must differ"
        )
    found.field.x.array[:] -= reference
    return replace(found, span=(low - reference, high - reference))


def _read_at_nodes(given: Temperatures, solid: Solid) -> WarmingField:
    """Temperatures in K at the nodes of a body.

    Raises:
        ModelError: if they are given for more dimensions, or not where the body is.
    """
    tagged, comm = solid.tagged, solid.tagged.mesh.comm
    if given.needs > tagged.dim:
        raise ModelError(
            f"{_KEY}: depends on {'xyz'[given.needs - 1]}: must depend on coordinates of the mesh "
            f"alone, which has {tagged.dim} dimensions"
        )
    beyond: list[Array] = []

    def values(places: Array) -> Array:
        kelvin, outside = given.at(places)
        beyond.append(outside)
        return kelvin

    field, span = scalar_field(tagged.mesh, solid.body.degree, values)
    (away,) = beyond
    too_far = int(comm.allreduce(int(np.count_nonzero(away > given.allowed))))
    nodes = int(comm.allreduce(int(np.count_nonzero(away))))
    farthest = float(comm.allreduce(np.max(away, initial=0.0), op=MPI.MAX))
    if too_far:
        raise ModelError(
            f"{_KEY}.outside = {given.allowed:.4g} m: {too_far} nodes lie farther outside of the "
            f"points of the table, up to {farthest:.4g} m: points must surround the body; check "
            "their unit"
        )
    around = f"; {nodes} nodes up to {farthest:.4g} m outside of it" if nodes else ""
    return WarmingField(field, span, f"{given.words}{around}")
