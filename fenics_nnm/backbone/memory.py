"""What a branch of any length may keep in memory besides its points."""

from __future__ import annotations

from typing import TypeVar

_Key = TypeVar("_Key")
_Value = TypeVar("_Value")


def forget_oldest(known: dict[_Key, _Value], most: int) -> None:
    """Drop the entries that were made first, until at most so many are left."""
    while len(known) > most:
        known.pop(next(iter(known)))


def remember(known: dict[_Key, _Value], key: _Key, value: _Value, most: int) -> None:
    """Add an entry, and drop those that were made first beyond so many."""
    known[key] = value
    forget_oldest(known, most)
