"""Which vertices of the patches of a body become contact points, by the mode that is followed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.fem.contact_sites import Chosen, ContactSites
from fenics_nnm.fem.obstacle_curvature import obstacle_closing
from fenics_nnm.mechanics.approach import Approach, Places
from fenics_nnm.mechanics.pairs import Pairs
from fenics_nnm.reduction.linear_modes import LinearModes
from fenics_nnm.reduction.point_choice import PointChoice
from fenics_nnm.reduction.reduction import Reduction

Choices = tuple[PointChoice, ...]
"""The choice of each patch."""


def chosen_of(choices: Choices) -> Chosen:
    """Which vertices of each patch become contact points."""
    return tuple(choice.chosen for choice in choices)


def same_points(first: Choices, second: Choices) -> bool:
    """Whether two choices have the same contact points."""
    pairs = zip(chosen_of(first), chosen_of(second), strict=True)
    return all(np.array_equal(one, other) for one, other in pairs)


def evenly_spread(sites: ContactSites) -> Choices:
    """As many vertices of each patch as are asked for, evenly spread."""
    return tuple(PointChoice.evenly(part.points, part.count) for part in sites.parts)


def chosen_by_mode(choices: Choices, sites: ContactSites, modes: LinearModes, mode: int) -> Choices:
    """The choices with what a linear mode brings to the obstacle first; called on all ranks.

    Where a gap is not positive the motion is one about the state of rest, which is not known yet:
    then the choices have what touches first at rest.

    Args:
        choices: Choices to improve.
        sites: Vertices of the patches.
        modes: Linear modes.
        mode: Index of the mode that is followed, from 0.
    """
    if not sites.limited:
        return choices
    if sites.gap.min() <= 0:
        return _improved(choices, sites, Approach.at_rest(sites.gap))
    Phi = sites.displacement(modes.shapes)
    return _improved(choices, sites, Approach.of_mode(sites.gap, Phi, mode))


def chosen_about_rest(
    choices: Choices, sites: ContactSites, reduction: Reduction, mode: int
) -> Choices:
    """The choices with what a mode about the state of rest brings to the obstacle first.

    The state of rest depends on the choices, so they may have to be improved again. To be called
    on all ranks.

    Args:
        choices: Choices that the reduced model was made with.
        sites: Vertices of the patches.
        reduction: Reduced model.
        mode: Index of its mode about the state of rest, from 0.

    Raises:
        ModelError: if a gap is not positive and contact points carry mass.
    """
    bends = len(reduction.model.kinematics.masters) > 0
    if not sites.limited or (sites.gap.min() > 0 and not bends):
        return choices
    return _improved(choices, sites, approach_of(sites, chosen_of(choices), reduction, mode))


def approach_of(sites: ContactSites, chosen: Chosen, reduction: Reduction, mode: int) -> Approach:
    """How a mode about the state of rest brings all vertices to the obstacle; on all ranks."""
    places = Places(
        Phi=sites.displacement(reduction.shapes),
        R=sites.displacement(reduction.residual_shapes),
        gap=sites.gap,
        point=sites.point_of_each(chosen),
    )
    found = places.approach(reduction.model.at_rest(), mode)
    return replace(found, curvature=_curvature(sites, reduction, mode))


def _curvature(sites: ContactSites, reduction: Reduction, mode: int) -> Array:
    """Second derivative of the closing of all vertices along a mode, shape (n,); on all ranks."""
    masters = reduction.model.kinematics.masters
    own = np.flatnonzero(masters == mode)
    if not len(own):
        return np.zeros(len(sites.gap))
    pair = Pairs.of(len(masters)).place[own, own]
    every = tuple(np.arange(len(part.gap)) for part in sites.parts)
    shapes, following = reduction.shapes, reduction.model.kinematics.following(reduction.model)
    obstacle = obstacle_closing(sites, sites, every, shapes[:, [mode]])
    bent = reduction.bent_shapes[:, pair] + shapes @ following[:, [mode]]
    return np.asarray(sites.displacement(bent)[:, 0] + obstacle[:, 0, 0])


def _improved(choices: Choices, sites: ContactSites, approach: Approach) -> Choices:
    own = np.split(np.arange(len(sites.gap)), sites.ends)
    found = list(choices)
    for number, rows in enumerate(own):
        taken = sites.taken(number, chosen_of(tuple(found)))
        part = approach.of_some(rows).without(taken)
        found[number] = found[number].improved(sites.parts[number].points, part, taken)
    return tuple(found)
