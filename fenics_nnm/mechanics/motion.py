"""A periodic motion in physical units, and its contact forces at any time of the period."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.contact_points import ContactMotion
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel


@dataclass(frozen=True, slots=True)
class Motion:
    """A periodic motion of a reduced model, written in a series in time.

    Attributes:
        q: Harmonics of the modal coordinates in kg^1/2 m, shape (N + 1, J), or (2 N + 1, J) for a
            general series: cosines, then sines.
        force: Contact forces in N at the samples of the series: of the first half period, shape
            (m // 2 + 1, n_c), or of all of it, shape (m, n_c), for a general series.
        free: Harmonics of the linear part of the free displacement of the contact points in m,
            shape (N + 1, n_c), or (2 N + 1, n_c): they move by this, and what second-order
            kinematics adds, less R lambda.
        frequency: Physical frequency in Hz.
        rayleigh_frequency: sqrt(r) / 2 pi in Hz, the paper's quantity; it is not the frequency
            once there is a gap.
        energy: Total energy in J, from the state of rest.
        contact_fraction: Share of the period with contact somewhere.
    """

    q: Array
    force: Array
    free: Array
    frequency: float
    rayleigh_frequency: float
    energy: float
    contact_fraction: float


def forces_at(model: ReducedModel, series: Series, motion: Motion, phase: Array) -> Array:
    """Contact forces in N at phases omega t, not only at the samples.

    Where the contact points carry no mass the forces follow from the motion alone, by Signorini's
    conditions. Otherwise only their harmonics 0..N act on the motion, and these are given: those
    above are not determined.

    Args:
        model: Model that the motion obeys, in SI units.
        series: Series that it is written in.
        motion: Motion.
        phase: Phases, shape (s,).

    Returns:
        Shape (s, n_c).
    """
    return model.contact.forces_at(model.R, model.gap, _at(model, series, motion, phase))


def force_rates_at(model: ReducedModel, series: Series, motion: Motion, phase: Array) -> Array:
    """Derivatives of the contact forces by the phase in N, of the shape of `forces_at`.

    Without mass they follow from the slope of the contact law, and jump where a point comes into
    contact or leaves it.
    """
    return model.contact.force_rates_at(model.R, model.gap, _at(model, series, motion, phase))


def free_displacement(model: ReducedModel, series: Series, motion: Motion, phase: Array) -> Array:
    """Displacement of the contact points in m at phases, but for -R lambda, shape (s, n_c)."""
    basis = series.basis_at(phase)
    return model.kinematics.closing.displaced(basis @ motion.free, basis, motion.q)


def free_rates(model: ReducedModel, series: Series, motion: Motion, phase: Array) -> Array:
    """Derivatives of `free_displacement` by the phase, shape (s, n_c)."""
    basis, rate = series.basis_at(phase), series.rate_at(phase)
    closing = model.kinematics.closing
    return closing.displacement_rates(rate @ motion.free, basis, rate, motion.q)


def _at(model: ReducedModel, series: Series, motion: Motion, phase: Array) -> ContactMotion:
    moved = free_displacement(model, series, motion, phase)
    return ContactMotion(
        series, moved, free_rates(model, series, motion, phase), motion.force, phase
    )
