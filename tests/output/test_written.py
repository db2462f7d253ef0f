"""Pictures write titles and names as they stand, and powers of ten as formulas."""

from __future__ import annotations

from pathlib import Path

from fenics_nnm.output.pictures.style import label, legend_below, new_figure, save


def test_dollars_begin_no_formula(tmp_path: Path) -> None:
    figure = new_figure()
    axes = figure.subplots()
    axes.plot([1, 2], [1e-9, 1.0], label="$\\frac{$")
    axes.set_yscale("log")
    label(axes, "of $\\x$", "of $a_$")
    axes.set_title("costs 3 $, not 5 $")
    legend_below(figure, axes)
    save(figure, tmp_path, "drawn", ["svg"])
    text = (tmp_path / "drawn.svg").read_text()
    assert "<!-- costs 3 $, not 5 $ -->" in text
    assert "<!-- $\\frac{$ -->" in text
    assert "<!-- $\\mathdefault{10^{-6}}$ -->" in text  # drawn as 10 with an exponent
