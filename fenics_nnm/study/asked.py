"""Energies, amplitudes, stresses and frequencies that a branch is asked for, with their units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fenics_nnm.backbone.quantities import Sought
from fenics_nnm.geometry.amounts import amount, known_units

#: The quantity of each SI unit.
QUANTITIES = {"m": "amplitude", "Pa": "stress", "J": "energy", "Hz": "frequency"}

#: Keys that hold what is written with units in `report_at` and in `energies`.
REPORTED, ENERGIES = "report_values", "energy_values"

#: Most energies of a range.
_MOST = 10_000


def with_units_apart(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values of [continuation] with amounts of `report_at` and `energies` in keys of their own.

    Raises:
        ValueError: if one of them is no amount.
    """
    found = dict(values)
    reported = found.get("report_at")
    if isinstance(reported, list | tuple):
        texts = [each for each in reported if isinstance(each, str)]
        found["report_at"] = tuple(each for each in reported if not isinstance(each, str))
        for text in texts:
            _assert_amount("report_at", text)
        if texts:
            found[REPORTED] = (*found.get(REPORTED, ()), *texts)
    energies = found.get("energies")
    if isinstance(energies, list | tuple):
        if not energies:
            raise ValueError('energies = []: must have an energy at least, as in ["1.2 J"]')
        found[ENERGIES] = tuple(_joules(each, energies) for each in energies)
        del found["energies"]
    if isinstance(energies, Mapping) and any(isinstance(v, str) for v in energies.values()):
        found[ENERGIES] = _range(energies)
        del found["energies"]
    return found


def sought_amount(text: str) -> Sought:
    """What a text such as "2 mm" or "300 MPa" asks for.

    Raises:
        ValueError: if it is no positive amount.
    """
    value, unit = amount(text)
    if not 0 < value < float("inf"):
        raise ValueError("must be positive")
    return Sought(QUANTITIES[unit], value)


def _assert_amount(key: str, text: str) -> None:
    try:
        sought_amount(text)
    except ValueError as error:
        raise ValueError(f"{key} = {text!r}: {error}") from error


def _joules(each: Any, given: Any) -> float:
    """An energy of a list or a range, in J."""
    right = f'must be energies in J, as in ["1.2 J"], with units {known_units("J")}'
    if not isinstance(each, str):
        raise ValueError(f"energies = {given!r}: {right}; gamma ratios are a range from, to, step")
    try:
        value, _ = amount(each, "J")
    except ValueError as error:
        raise ValueError(f"energies = {each!r}: {error}") from error
    if not 0 < value < float("inf"):
        raise ValueError(f"energies = {each!r}: must be positive")
    return value


def _range(given: Mapping[str, Any]) -> tuple[float, ...]:
    """Energies of a range in J: equal steps no larger than the one given."""
    missing = [name for name in ("from", "to", "step") if name not in given]
    wrong = [name for name in given if name not in ("from", "to", "step")]
    if missing or wrong:
        raise ValueError(
            f"energies = {dict(given)!r}: with units must have from, to and step, each in J"
        )
    start, stop, step = (_joules(given[name], dict(given)) for name in ("from", "to", "step"))
    if not start < stop or (stop - start) / step > _MOST:
        raise ValueError(
            f"energies = {dict(given)!r}: from must be below to, with at most {_MOST} steps"
        )
    count = max(1, round((stop - start) / step + 0.5 - 1e-9))
    return tuple(start + (stop - start) * number / count for number in range(count + 1))
