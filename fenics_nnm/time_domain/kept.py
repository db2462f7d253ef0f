"""Things that are made once and kept, up to a number and a size."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Generic, Protocol, TypeVar

from fenics_nnm.arrays import Array, Complex

#: Bytes that are kept.
_MOST_BYTES = 200_000_000


class Sized(Protocol):
    """What knows its size."""

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""


S = TypeVar("S", bound=Sized)


class Kept(Generic[S]):
    """Things by what they were made of; all are forgotten when there are too many, or too large."""

    def __init__(self, most: int, most_bytes: int = _MOST_BYTES) -> None:
        """Nothing yet.

        Args:
            most: So many things are kept at most.
            most_bytes: So many bytes are.
        """
        self._most, self._most_bytes = most, most_bytes
        self._known: dict[Hashable, S] = {}
        self._nbytes = 0

    def at(self, key: Hashable, made: Callable[[], S]) -> S:
        """What there is of a key, or else what is made."""
        if key not in self._known:
            self._keep(key, made())
        return self._known[key]

    def _keep(self, key: Hashable, new: S) -> None:
        if len(self._known) >= self._most or self._nbytes + new.nbytes > self._most_bytes:
            self._known.clear()
            self._nbytes = 0
        self._known[key] = new
        self._nbytes += new.nbytes


def bytes_of(*arrays: Array | Complex) -> int:
    """Bytes of arrays."""
    return sum(each.nbytes for each in arrays)
