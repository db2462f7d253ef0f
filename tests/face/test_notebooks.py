"""The notebooks run, in order and from nothing, and are kept without outputs."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest

FOLDER = Path(__file__).parents[2] / "demos/notebooks"


def cells_of(name: str) -> list[dict[str, Any]]:
    read: dict[str, Any] = json.loads((FOLDER / f"{name}.ipynb").read_text("utf-8"))
    assert (read["nbformat"], read["nbformat_minor"]) == (4, 5)
    return list(read["cells"])


def ran(name: str, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Names that the cells of a notebook leave, run where it lies as Jupyter does."""
    from matplotlib import pyplot

    mpl.use("Agg")
    monkeypatch.chdir(FOLDER)
    monkeypatch.setattr(sys, "path", [str(FOLDER), *sys.path])
    names: dict[str, Any] = {"__name__": "__main__"}
    for number, cell in enumerate(cells_of(name), start=1):
        if cell["cell_type"] == "code":
            code = compile("".join(cell["source"]), f"{name}.ipynb, cell {number}", "exec")
            exec(code, names)
    pyplot.close("all")
    return names


@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.glob("*.ipynb")))
def test_no_outputs_are_kept(name: str) -> None:
    cells = cells_of(name)
    assert all(cell["id"] for cell in cells)
    for cell in cells:
        if cell["cell_type"] == "code":
            assert (cell["outputs"], cell["execution_count"]) == ([], None)


def test_rod(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside the exact rod, by as many harmonics as it says."""
    names = ran("rod", monkeypatch)
    assert len(names["error"]) == 4
    assert 1e-4 < np.abs(names["error"]).max() < 8e-3
    assert len(names["axes"].lines) > 4


def test_blade(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Twice the gap takes more than four times the energy, as bending shortens the blade."""
    names = ran("blade", monkeypatch)
    assert 4.2 < names["second"] / names["first"] < 6
    assert all(branch.complete for branch in names["branches"].values())
    assert names["hardest"].max() > 0
    assert "second order in mode 1" in capsys.readouterr().out
