"""A small part of `tests/fuzz.py`."""

from __future__ import annotations

from fuzz import fuzz


def test_hostile_inputs_end_with_a_line() -> None:
    assert fuzz(few=True) == []
