"""Arguments of the face: numbers, whole numbers and lists of them, of Python or of NumPy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import isfinite
from numbers import Integral, Real
from typing import TypeVar

Read = TypeVar("Read", int, float)

#: More instants, modes or orders than this are a misprint.
MOST = 1_000_000


def number(name: str, given: object) -> float:
    """A finite number.

    Raises:
        ValueError: if it is none: a text, nan, true or false.
    """
    if not isinstance(given, Real) or isinstance(given, bool) or not isfinite(given):
        raise ValueError(f"{name} = {given!r}: must be a finite number")
    return float(given)


def integer(name: str, given: object) -> int:
    """A whole number.

    Raises:
        ValueError: if it is none: 2.5, or 2.0, too.
    """
    if not isinstance(given, Integral) or isinstance(given, bool):
        raise ValueError(f"{name} = {given!r}: must be a whole number")
    return int(given)


def whole(name: str, given: object) -> int:
    """A whole number from 1.

    Raises:
        ValueError: if it is none.
    """
    found = integer(name, given)
    if not 1 <= found <= MOST:
        raise ValueError(f"{name} = {given!r}: must be 1 or more, and {MOST} at most")
    return found


def numbers(name: str, given: object) -> list[float]:
    """Finite numbers of a list, a tuple or an array.

    Raises:
        ValueError: if one is none.
    """
    return _each(name, given, number)


def wholes(name: str, given: object) -> list[int]:
    """Whole numbers from 1 of a list, a tuple or an array.

    Raises:
        ValueError: if one is none.
    """
    return _each(name, given, whole)


def positive(name: str, given: object) -> list[float]:
    """Different positive numbers of a list, a tuple or an array.

    Raises:
        ValueError: if one is none, or is there twice.
    """
    found = numbers(name, given)
    if any(value <= 0 for value in found):
        raise ValueError(f"{name} = {found}: must be positive")
    return different(name, found)


def different(name: str, found: Sequence[Read]) -> list[Read]:
    """The same numbers.

    Raises:
        ValueError: if one is there twice.
    """
    if len(set(found)) < len(found):
        raise ValueError(f"{name} = {list(found)}: must differ")
    return list(found)


def _each(name: str, given: object, read: Callable[[str, object], Read]) -> list[Read]:
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise ValueError(f"{name} = {given!r}: must be a list of numbers")
    return [read(name, each) for each in given]
