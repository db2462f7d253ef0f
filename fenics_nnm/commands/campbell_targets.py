"""Nonlinear lines that fenics-nnm campbell is asked for."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

from fenics_nnm.errors import StudyError
from fenics_nnm.geometry.lengths import KNOWN, converted, length_in_metres
from fenics_nnm.structure.motions_at_speed import Target, ascending


def targets_of(energies: str, amplitudes: str, unit: str = "m") -> tuple[Target, ...]:
    """Energies and amplitudes of two lists with commas, which may be empty.

    Args:
        energies: Numbers, in J.
        amplitudes: Numbers, or numbers with a unit of length.
        unit: Unit of lengths without one.

    Raises:
        StudyError: if they are not positive, each once.
    """

    def metres(text: str) -> float:
        try:
            return converted(float(text), unit, "m")
        except ValueError:
            return length_in_metres(text)

    by_energy = _values("--energies", energies, float, "positive numbers in J, as in 0.5,1")
    by_amplitude = _values(
        "--amplitudes", amplitudes, metres, f'positive lengths, as in "1 mm,2 mm", in {KNOWN}'
    )
    return ascending(by_energy, by_amplitude)


def _values(name: str, text: str, read: Callable[[str], float], right: str) -> list[float]:
    """Values of a list."""
    try:
        found = [read(part) for part in text.split(",") if part.strip()]
    except ValueError as error:
        raise StudyError(f"{name} {text}: must be different {right}") from error
    if not all(0 < value < inf for value in found) or len(set(found)) < len(found):
        raise StudyError(f"{name} {text}: must be different {right}")
    return found
