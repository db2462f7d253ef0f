"""Modes over speed: which is which by their shapes, and where engine orders meet them."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.reduction.mode_lines import crossings, same_modes


def test_an_engine_order_meets_the_mode_of_the_closed_form() -> None:
    """w^2 = 1 + 1.17 Om^2 meets 4 Om at 1 / sqrt(16 - 1.17) = 0.259675, whatever the steps."""
    speeds = np.array([0.0, 0.2, 0.5, 1.2])
    lines = np.sqrt(1 + 1.17 * speeds**2)[:, None] / (2 * np.pi)
    (found,) = crossings(speeds, lines, 4)
    assert found.speed == pytest.approx(1 / np.sqrt(16 - 1.17), rel=1e-12)
    assert found.speed == pytest.approx(0.259675, abs=5e-7)
    assert found.frequency == pytest.approx(4 * found.speed / (2 * np.pi))
    assert list(crossings(speeds, lines, 1)) == []


def test_modes_keep_their_names_where_lines_cross() -> None:
    """Two shapes change places in the order of frequencies, and a third one comes between."""
    turn = 0.1
    mixed = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    products = np.array([[0.0, *mixed[0][::-1]], [0.0, *mixed[1][::-1]]])
    assert list(same_modes(products)) == [2, 1]
    assert list(same_modes(-np.eye(3))) == [0, 1, 2]
