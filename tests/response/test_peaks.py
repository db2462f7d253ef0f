"""Peaks of a response: where amplitudes rise and fall again by more than round-off."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fenics_nnm.response.peaks import peaks


def points(*columns: Any) -> Any:
    """Points at 0, 1, .. Hz with the amplitudes of each place."""
    rows = np.array(columns).T
    return [
        SimpleNamespace(frequency=float(at), amplitude=row, phase=np.zeros(len(row)), level=1.0)
        for at, row in enumerate(rows)
    ]


@pytest.mark.parametrize(
    ("amplitude", "at"),
    [
        ([1.0, 2.0, 1.0], [1]),
        ([1.0, 2.0, 2.0, 1.0], [1]),
        ([1.0, 1.0 + 1e-6, 1.0], [1]),  # a peak of heavy damping
        ([1.0, 1.0 + 1e-15, 1.0, 1.0 + 1e-15, 1.0], []),  # a level curve
        ([1.0, 3.0, 3.0 - 1e-15, 3.0, 1.0], [1]),  # one top, not two
        ([1.0, 2.0, 1.5, 3.0, 1.0], [1, 3]),
        ([1.0, np.nan, 2.0, 1.0], []),  # beside a point without amplitude
        ([np.nan, 1.0, 2.0, 1.0], [2]),
    ],
)
def test_peaks_stand_out(amplitude: list[float], at: list[int]) -> None:
    assert [peak.frequency for peak in peaks(points(amplitude), 0)] == at


def test_a_place_that_does_not_move_has_no_peaks() -> None:
    moving, held = [1.0, 2.0, 1.0], [1e-19, 2e-19, 1e-19]
    assert not list(peaks(points(moving, held), 1))
    assert [peak.frequency for peak in peaks(points(held, held), 1)] == [1]
