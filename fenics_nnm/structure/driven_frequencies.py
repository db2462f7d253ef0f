"""At which frequencies a study drives its structure, and at which harmonics of them."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import StudyError
from fenics_nnm.study import Study
from fenics_nnm.study.driven import base_order

#: Frequencies that differ by less than this part are the same.
_SAME = 1e-9


def response_frequencies(study: Study) -> Array:
    """Frequencies in Hz of the response, with those whose motions are reported, shape (f,)."""
    wanted = wanted_frequencies(study)
    far = [each for each in reported_frequencies(study) if np.abs(wanted / each - 1).min() > _SAME]
    return np.sort([*wanted, *far])


def reported_frequencies(study: Study) -> tuple[float, ...]:
    """Frequencies in Hz whose motions a study wants files of; none: the highest peaks."""
    assert study.response is not None  # refused by `driven_linear`
    unit = 1.0 if study.response.frequencies is not None else speed_per_hertz(study)
    return tuple(value / unit for value in study.response.report_at)


def wanted_frequencies(study: Study) -> Array:
    """Frequencies in Hz that a study asks for, shape (f,)."""
    assert study.response is not None  # refused by `driven_structure`
    if study.response.frequencies is not None:
        return study.response.frequencies.values
    assert study.response.speeds is not None  # one of the two is given
    return study.response.speeds.values / speed_per_hertz(study)


def speed_per_hertz(study: Study) -> float:
    """Speed in rad/s that goes with a frequency of 1 Hz; nan where they are not tied."""
    orders = driving_orders(study)
    return 2 * np.pi / base_order(orders) if orders else float("nan")


def driving_orders(study: Study) -> tuple[int, ...]:
    """Multiples of the speed that drive it, none where frequencies are given."""
    engine = (each.order for each in study.excitation if each.order is not None)
    return (*engine, *study.contact.passing_orders)


def drive_harmonics(study: Study) -> tuple[int, ...]:
    """Harmonics of the frequency of the response at which the forces act.

    Raises:
        StudyError: if engine orders and speeds do not go together, or no force changes.
    """
    assert study.response is not None  # refused before
    orders, by_speed = driving_orders(study), study.response.speeds is not None
    passing = study.contact.passing_orders
    if by_speed and len(orders) - len(passing) < len(study.excitation):
        raise StudyError("response.speeds: needs excitation.order in every [[excitation]]")
    if passing and not by_speed:
        raise StudyError(
            "response.frequencies: gaps that move follow the speed of rotation: needs "
            "response.speeds"
        )
    if orders and not by_speed:
        raise StudyError(
            f"excitation.order = {orders[0]}: is a multiple of the speed: needs response.speeds"
        )
    base = base_order(orders) if orders else 1
    found = tuple(
        each.harmonic if each.order is None else each.order // base for each in study.excitation
    )
    if not any(found) and not passing:
        raise StudyError("excitation.harmonic = 0: must be positive in one [[excitation]] at least")
    return found
