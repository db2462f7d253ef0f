"""fenics-nnm new: every template runs from end to end, and nothing is overwritten."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Ended, contents

from fenics_nnm.templates import KINDS

Command = Callable[..., Ended]

CASES = [(kind,) for kind in KINDS] + [("blade", "--rotor", "67")]

#: Changes that make a template fast enough for a test, by its kind.
COARSE = {
    "blade": {"element_size": "16.0", "edge_size": "8.0", "modes": "8", "points": "6"},
    "mesh": {"modes": "8"},
}


def coarsen(study: Path, kind: str) -> None:
    text = study.read_text()
    for key, value in COARSE.get(kind, {}).items():
        text, count = re.subn(rf"^{key} = \S+", f"{key} = {value}", text, flags=re.MULTILINE)
        assert count == 1, key
    study.write_text(text)


@pytest.mark.parametrize("arguments", CASES, ids=" ".join)
def test_every_template_runs_from_end_to_end(
    command: Command, tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    kind = arguments[0]
    ended = command("new", kind, "begin", *arguments[1:])
    assert (ended.code, ended.err) == (0, "")
    study = tmp_path / "begin" / f"{kind}.toml"
    assert f"wrote {Path('begin') / study.name}" in ended.out
    coarsen(study, kind)
    ended = command("run", study, "--output", "results")
    assert (ended.code, ended.err) == (0, "")
    with (tmp_path / "results" / "backbone.csv").open() as file:
        rows = list(csv.DictReader(file))
    touching = [float(row["frequency_ratio"]) for row in rows if float(row["gamma_ratio"]) > 1.01]
    assert touching and min(touching) > 1
    summary = json.loads((tmp_path / "results" / "summary.json").read_text())
    assert summary["linear_frequencies_Hz"][0] > 10


def test_the_matrices_are_those_of_a_fixed_free_chain(command: Command, tmp_path: Path) -> None:
    """Without its pad, of n equal masses: omega_1 = 2 sqrt(k/m) sin(pi / (2 (2 n + 1)))."""
    import numpy as np

    command("new", "matrices")
    with np.load(tmp_path / "matrices.npz") as matrices:
        K, mass = matrices["K"], matrices["M"][0, 0]
        assert matrices["M"][-1, -1] == 0  # the end of the pad, which is condensed
        chain = K[:-1, :-1] - K[:-1, -1:] @ K[-1:, :-1] / K[-1, -1]
        lowest, stiffness = np.linalg.eigvalsh(chain).min() / mass, -K[0, 1]
    expected = 4 * stiffness / mass * np.sin(np.pi / (2 * 17)) ** 2
    assert lowest == pytest.approx(expected, rel=1e-9)


def test_a_file_name_may_be_given(command: Command, tmp_path: Path) -> None:
    assert command("new", "rod", "studies/mine.toml").code == 0
    text = (tmp_path / "studies" / "mine.toml").read_text()
    assert "fenics-nnm run mine.toml" in text
    assert "rod.toml" not in text


@pytest.mark.parametrize("name", ["mesh.toml", "bracket.msh"])
def test_nothing_is_overwritten(command: Command, tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine")
    before = contents(tmp_path)
    command("new", "mesh").assert_one_line(2, name, "is not overwritten")
    assert contents(tmp_path) == before


def test_a_rotor_belongs_to_a_blade(command: Command) -> None:
    command("new", "rod", "--rotor", "67").assert_one_line(2, "--rotor 67: belongs to blade")


def test_a_folder_that_cannot_be_made_is_told_in_a_line(command: Command, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    command("new", "rod", "file/inside").assert_one_line(1, "file")
