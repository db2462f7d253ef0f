"""The picture of a Campbell diagram shows how far nonlinear lines are from their linear modes."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.output.pictures.campbell import campbell_plot
from fenics_nnm.structure.campbell import AtSpeed
from fenics_nnm.structure.motions_at_speed import MotionAtSpeed, Quantity, Target


def test_change_from_the_linear_mode_has_a_panel() -> None:
    target = Target(Quantity.ENERGY, 0.5)

    def at(speed: float, ratio: float) -> AtSpeed:
        motion = MotionAtSpeed(target, "verified", "", 0.5, 1e-3, 100 * ratio)
        return AtSpeed(speed, np.array([100.0, 250.0]), 1e-4, "", 1, (motion,))

    figure = campbell_plot([at(0, 1.01), at(10, 1.03)], [], [1], "Blade")
    _, middle, gap = figure.axes
    (line,) = middle.lines
    assert line.get_ydata() == pytest.approx([1.0, 3.0])
    assert middle.get_ylabel() == "change from the linear mode  (%)"
    assert gap.get_ylabel() == "smallest gap  (mm)"


def test_linear_diagram_has_frequencies_and_gap_alone() -> None:
    points = [AtSpeed(speed, np.array([100.0]), 1e-4) for speed in (0.0, 10.0)]
    figure = campbell_plot(points, [], [1, 4], "Blade", lobes=[4])
    assert len(figure.axes) == 2
    assert [text.get_text() for text in figure.axes[0].texts] == ["1", "4 lobes"]
