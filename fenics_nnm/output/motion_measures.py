"""Numbers that say what kind of motion it is: standing or travelling, which modes, which turn."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.results.stored_branch import StoredBranch


class StandingWave(NamedTuple):
    """How far a field in space and time is from a standing wave a(x) b(t).

    Attributes:
        travelling_ratio: Second singular value of the field over the first: 0 for a standing
            wave, 1 for a travelling wave of any shape that runs over whole wavelengths, B / (A + B)
            for the sum A cos kx cos wt + B cos(kx - wt).
        remainder: Share of the mean square that the best standing wave leaves over; 1/2 for a
            travelling sine.
    """

    travelling_ratio: float
    remainder: float


def standing(field: Array, weight: Array) -> StandingWave:
    """Compare a field with its best standing wave, by proper orthogonal decomposition.

    Args:
        field: Values such as velocities at uniform times of one period, shape (times, places).
        weight: Length, area or mass that each place stands for, shape (places,).
    """
    values = np.linalg.svd(field * np.sqrt(weight), compute_uv=False)
    square = values**2
    return StandingWave(float(values[1] / values[0]), float(square[1:].sum() / square.sum()))


def kinetic_shares(series: Series, q: Array) -> Array:
    """Share of each mode in the mean kinetic energy, shape (J,).

    Mode j has sum_n <basis_n^2> n^2 q_nj^2 of m^; residual shapes carry no mass.
    """
    kinetic = _kinetic(series, q).sum(axis=0)
    return kinetic / kinetic.sum()


def harmonic_shares(series: Series, q: Array) -> Array:
    """Share of each harmonic 0..N in the mean kinetic energy, shape (N + 1,); 0 of the mean."""
    kinetic = np.bincount(series.order.astype(np.int64), weights=_kinetic(series, q).sum(axis=1))
    return kinetic / kinetic.sum()


def _kinetic(series: Series, q: Array) -> Array:
    """Part of each coefficient of each mode in m^, of the shape of q."""
    return np.asarray((series.mean_square * series.order**2)[:, None] * q**2)


class SectionMotion(NamedTuple):
    """The rigid part of the motion of a section in its plane, by least squares.

    Attributes:
        translation: Mean displacement, shape (3,).
        angle: Rotation about the axis through the mean of the places, in rad.
        rotation_share: Share of the rotation in the mean square displacement of the section.
    """

    translation: Array
    angle: float
    rotation_share: float


def section_motion(places: Array, displacement: Array, axis: Array) -> SectionMotion:
    """Translation and rotation of a section about an axis normal to it.

    Args:
        places: Points of the section in m, shape (p, 3).
        displacement: Their displacements, shape (p, 3).
        axis: Unit vector, for a blade along its span, shape (3,).
    """
    arm = np.cross(axis, places - places.mean(axis=0))
    inertia = np.sum(arm**2)
    angle = float(np.sum(arm * displacement) / inertia)
    total = float(np.sum(displacement**2))
    share = float(angle**2 * inertia) / total if total else 0.0
    return SectionMotion(displacement.mean(axis=0), angle, share)


def first_torsion_mode(branch: StoredBranch) -> int:
    """Index of the lowest mode that turns the contact section more than it moves it otherwise.

    The section is that of the contact points, such as a blade tip, and turns about their mean
    contact direction.

    Raises:
        ModelError: if no mode does.
    """
    nodes, axis = branch.contact_nodes, branch.contact_axis
    for number in range(len(branch.shapes)):
        motion = section_motion(branch.nodes[nodes], branch.shapes[number, nodes, :], axis)
        if motion.rotation_share > 0.5:
            return number
    raise ModelError("no mode turns the contact section more than it moves it otherwise")
