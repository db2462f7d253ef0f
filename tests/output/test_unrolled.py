"""Contact patches laid flat: lengths along them, rows, and the picture of a footprint."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from conftest import BEAM, changed, toml

from fenics_nnm.cli import main
from fenics_nnm.output.pictures.footprint import footprints
from fenics_nnm.output.pictures.results import read_results
from fenics_nnm.output.pictures.unrolled import Unrolling, ordered


def tip(count: int, thickness: float) -> np.ndarray:
    """Points on both edges of a curved tip of a radius of 1 m, in an order of chance."""
    angle = np.linspace(-0.4, 0.4, count)
    radii = 1 + thickness * np.array([-0.5, 0.5])
    places = [[r * np.sin(a), r * np.cos(a), 0.2] for r in radii for a in angle]
    return np.random.default_rng(3).permutation(np.array(places))


def test_way_along_a_curved_patch_is_its_arc() -> None:
    places = tip(9, 0.02)
    flat = Unrolling.of(places).flat(places)
    assert np.isclose(np.ptp(flat[:, 0]), 0.8, rtol=0.03)
    assert flat[:, 0].min() == 0
    np.testing.assert_allclose(np.abs(flat[:, 1]), 0.01, rtol=0.25)
    turned = places @ np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0].T
    again = Unrolling.of(turned + 5).flat(turned + 5)
    lengths, same = (np.sort(np.abs(np.subtract.outer(f[:, 0], f[:, 0]))) for f in (flat, again))
    np.testing.assert_allclose(same, lengths, atol=1e-9)


def test_points_of_both_edges_come_one_edge_after_the_other() -> None:
    places = tip(9, 0.02)
    found = ordered(places, np.zeros(18, dtype=np.int64))
    radius = np.linalg.norm(places[found.order, :2], axis=1)
    assert found.breaks == (9,)
    assert len(set((radius[:9] > 1).tolist())) == 1 and (radius[0] > 1) != (radius[9] > 1)
    for row in (found.along[:9], found.along[9:]):
        assert np.all(np.diff(row) > 0)
    assert "one side of it after the other" in found.words


def test_patches_follow_each_other_and_a_single_row_has_no_break() -> None:
    line = np.column_stack([[0.3, 0.0, 0.2, 0.1], np.zeros((4, 2))])
    both = np.vstack([line, line + np.array([0, 5.0, 0])])
    found = ordered(both, np.repeat([0, 1], 4))
    assert found.order.tolist() == [1, 3, 2, 0, 5, 7, 6, 4]
    assert found.breaks == (4,)
    np.testing.assert_allclose(found.along, 2 * [0.0, 0.1, 0.2, 0.3], atol=1e-12)


def test_a_grid_of_points_has_fewer_places_along_it_than_a_cubic_asks_for() -> None:
    grid = np.array([[0.3 * i, 0.1 * j, 0.0] for i in range(3) for j in range(3)])
    flat = Unrolling.of(grid).flat(grid)
    np.testing.assert_allclose(np.unique(flat[:, 0].round(9)), [0.0, 0.3, 0.6])
    np.testing.assert_allclose(np.unique(flat[:, 1].round(9)), [-0.1, 0.0, 0.1], atol=1e-9)


def test_one_point_is_where_it_is() -> None:
    assert ordered(np.zeros((1, 3)), np.zeros(1, dtype=np.int64)).along.tolist() == [0.0]


def test_footprint_has_the_pressures_of_the_points(tmp_path: Path) -> None:
    study = changed(BEAM, {"mesh": {"elements": [3, 2, 1]}, "contact": {"points": 4}})
    file = tmp_path / "study.toml"
    file.write_text(toml(study))
    assert main(["run", str(file), "--output", str(tmp_path / "out")]) == 0
    results = read_results(tmp_path / "out")
    (plot,) = footprints(results)
    point = results.chosen_touching[-1]
    largest = point.motion.force.max(axis=0) / results.areas
    axes = plot.figure.axes[0]
    drawn = axes.collections[-1]
    pressures = np.asarray(drawn.get_array())
    assert len(pressures) == np.count_nonzero(largest > 0) > 0
    factor = pressures.max() / largest.max()
    np.testing.assert_allclose(np.sort(pressures), factor * np.sort(largest[largest > 0]))
    assert f"the {len(pressures)} that touch" in plot.caption
    assert footprints(replace(results, body=None)) == []
