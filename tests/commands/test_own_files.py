"""Files of somebody else by the names of tables: no command replaces them; its own it does."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import ROD, Ended, contents

from fenics_nnm.errors import StudyError
from fenics_nnm.output import (
    campbell_report,
    convergence_report,
    response_report,
    simulation_report,
)
from fenics_nnm.results import own_files, response_folder
from fenics_nnm.results.own_files import CAMPBELL, CONVERGENCE, SIMULATION, OwnFiles

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: Each command with its options and a study, by the names that it writes.
ASKED = {
    "convergence.csv": ("convergence",),
    "simulation.csv": ("simulate", "--frequency", "10", "--periods", "1"),
    "campbell.csv": ("campbell", "--speeds", "0:2:1"),
    "sweep.csv": ("sweep", "--set", "contact.gap=1e-4,2e-4"),
}


@pytest.fixture
def spun(study_file: StudyFile) -> Path:
    """A rod that all commands take; they end before they look at it more closely."""
    return study_file(ROD)


@pytest.mark.parametrize("name", ASKED)
def test_files_of_somebody_else_stay(spun: Path, command: Command, name: str) -> None:
    mine = spun.parent / "mine"
    mine.mkdir()
    picture = Path(name).with_suffix(".png").name
    (mine / name).write_text("name,value\nmine,1\n")
    (mine / picture).write_bytes(b"mine")
    before = contents(mine)
    command(*ASKED[name], spun, "--output", mine).assert_one_line(
        2, f"mine: has {name}, {picture} that no run of this program has written: must be another"
    )
    assert contents(mine) == before


@pytest.mark.parametrize("name", ASKED)
def test_a_folder_that_cannot_be_is_bad_input(spun: Path, command: Command, name: str) -> None:
    (spun.parent / "file").write_text("")
    command(*ASKED[name], spun, "--output", "file/out").assert_one_line(
        2, "file/out: cannot be written: Not a directory"
    )


def test_a_study_of_a_sweep_does_not_replace_a_report(spun: Path, command: Command) -> None:
    asked = *ASKED["sweep.csv"], spun, "--output", "s"
    folder = Path(command(*asked, "--list").out.split("--output ")[1].split()[0])
    folder.mkdir(parents=True)
    (folder / "report.html").write_text("mine")
    command(*asked).assert_one_line(2, "has report.html that no run of this program has written")
    assert (folder / "report.html").read_text() == "mine"


@pytest.mark.parametrize(
    ("files", "name", "columns"),
    [
        (CONVERGENCE, "convergence.csv", convergence_report._COLUMNS),
        (SIMULATION, "simulation.csv", simulation_report.COLUMNS),
        (CAMPBELL, "campbell.csv", campbell_report.COLUMNS),
        (CAMPBELL, "crossings.csv", campbell_report.OF_CROSSINGS),
    ],
)
def test_own_tables_are_known(
    tmp_path: Path, files: OwnFiles, name: str, columns: tuple[str, ...]
) -> None:
    (tmp_path / name).write_text(",".join(columns) + "\n")
    for picture in files.pictures:
        (tmp_path / picture).write_bytes(b"png")
    assert files.foreign(tmp_path) == []


def test_states_and_journals_are_known_by_what_is_in_them(tmp_path: Path) -> None:
    state, journal = tmp_path / "state.npz", tmp_path / "motions.jsonl"
    np.savez(state, q=[1.0], velocity=[0.0], omega=[2.0])
    journal.write_text('\n{"key": "a", "motions": []}\n')
    assert SIMULATION.foreign(tmp_path) == CAMPBELL.foreign(tmp_path) == []
    np.savez(state, q=[1.0])
    journal.write_text('{"name": "mine"}\n')
    assert SIMULATION.foreign(tmp_path) == ["state.npz"]
    assert CAMPBELL.foreign(tmp_path) == ["motions.jsonl"]
    journal.write_text("")
    assert CAMPBELL.foreign(tmp_path) == []


def test_a_response_replaces_no_table_of_somebody_else(tmp_path: Path) -> None:
    (tmp_path / "response.csv").write_text("frequency,value\n1,2\n")
    (tmp_path / "resonance.csv").write_text("mine\n")
    before = contents(tmp_path)
    with pytest.raises(StudyError, match=r"has response.csv, resonance.csv that no run of this"):
        response_folder.claim(tmp_path)
    assert contents(tmp_path) == before
    (tmp_path / "response.csv").write_text(",".join(response_report.COLUMNS) + "\n")
    response_folder.claim(tmp_path).leave()
    assert contents(tmp_path).keys() == before.keys()


def test_a_folder_is_not_there_after_it_was_tried(tmp_path: Path) -> None:
    own_files.assert_writable(tmp_path / "a" / "b", CONVERGENCE)
    assert list(tmp_path.iterdir()) == []
