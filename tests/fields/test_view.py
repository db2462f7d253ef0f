"""The ready view for ParaView: where it looks from, and its colours."""

from __future__ import annotations

import ast
from importlib import resources

import numpy as np
import pytest

from fenics_nnm.fields.view import _camera


@pytest.mark.parametrize(
    ("size", "across", "up"),
    [((0.1, 0.004, 0.3), 1, 2), ((0.004, 0.2, 0.1), 0, 2), ((0.3, 0.2, 0.01), 2, 1)],
)
def test_a_thin_body_is_looked_at_across_its_plane(
    size: tuple[float, ...], across: int, up: int
) -> None:
    places = np.random.default_rng(0).uniform(-0.5, 0.5, (2000, 3)) * size
    looked, upright = _camera(places)
    assert np.linalg.norm(looked) == pytest.approx(1)
    assert np.argmax(np.abs(looked)) == across and abs(looked[across]) > 0.9
    assert np.argmax(np.abs(upright)) == up
    assert abs(looked @ upright) < 0.5  # upwards is not towards the viewer


def test_the_view_is_python_and_its_quantile_is_that_of_an_instant() -> None:
    text = resources.files("fenics_nnm.fields").joinpath("view_template.py").read_text()
    (work,) = (
        node
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.FunctionDef) and node.name == "quantile"
    )
    assert "np.quantile(sizes, HIGHEST)" in ast.unparse(work)
    assert "HIGHEST = 0.995" in text
