"""The page and the pictures of a response: with the numbers of its tables, whole and escaped."""

import csv
import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Ended
from web_page import Element, read_page

from fenics_nnm.output.response_report import COLUMNS, write_response
from fenics_nnm.response.levels import CurveEnd, Response

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

HOSTILE = "</title><script>alert('1')</script> & $title"

STOP: dict[str, Any] = {
    "title": HOSTILE,
    "matrices": {"file": "stop.npz"},
    "contact": {"gap": 1.0},
    "reduction": {"modes": 1},
    "mode": {"harmonics": 6, "samples": 32},
    "damping": {"ratio": 0.01},
    "excitation": {"unknown": 1, "force": 0.05},
    "response": {"frequencies": {"from": 0.14, "to": 0.2, "step": 0.01}, "levels": [0.3, 1.0]},
}


def section(page: Element, name: str) -> Element:
    (found,) = [each for each in page.all("section") if each.attributes["id"] == name]
    return found


@pytest.fixture
def results(tmp_path: Path, study_file: StudyFile, command: Command) -> Path:
    """A response through both folds of an oscillator with an elastic stop."""
    K, M = [[5.0, -4.0], [-4.0, 4.0]], [[1.0, 0.0], [0.0, 0.0]]
    np.savez(tmp_path / "stop.npz", K=K, M=M, B=[[0.0, 1.0]])
    command("response", study_file(STOP), "--output", "out")
    return Path("out")


def test_page_has_the_numbers_of_the_tables(results: Path, command: Command) -> None:
    ended = command("report", results)
    assert ended.code == 0 and ended.err == ""
    page = read_page((results / "report.html").read_text("utf-8"))
    assert not page.all("script")
    assert page.all("h1")[0].text == HOSTILE
    with (results / "response.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["monitor"] == "excitation"]
    headings, *levels = section(page, "trust").all("table")[0].rows()
    for level, *cells in levels:
        own = [row for row in rows if float(row["level"]) == float(level)]
        found = dict(zip(headings[1:], cells, strict=True))
        statuses = Counter(row["status"] for row in own)
        assert {name: int(found[name]) for name in statuses} == statuses
        assert int(found["stable"]) == sum(row["stability"] == "stable" for row in own)
        assert sum(int(found[name]) for name in ("stable", "unstable", "stability not known")) == (
            len(own)
        )
    events = section(page, "events").all("table")[0].rows()[1:]
    marked = [row for row in rows if row["event"]]
    assert [(each[2], float(each[3])) for each in events] == [
        (row["event"], pytest.approx(float(row["frequency_Hz"]), rel=1e-6)) for row in marked
    ]
    assert [each[2] for each in events].count("fold in omega") == 2
    with (results / "resonance.csv").open() as file:
        (resonance,) = (row for row in csv.DictReader(file) if row["level"] == "1")
    shown = [each for each in section(page, "backbone").all("table")[0].rows() if each[0] == "1"]
    assert float(shown[0][2]) == pytest.approx(float(resonance["frequency_Hz"]), rel=1e-6)
    assert len(section(page, "curve").all("img")) == 3


def test_plot_draws_all_levels_and_each(results: Path, command: Command) -> None:
    assert command("plot", results, "--formats", "svg").code == 0
    listed = json.loads((results / "pictures/pictures.json").read_text())["pictures"]
    assert [each["file"] for each in listed] == [
        "response.svg",
        "response_level0.3.svg",
        "response_level1.svg",
    ]
    assert all((results / "pictures" / each["file"]).exists() for each in listed)


def test_response_without_a_motion_has_an_empty_table_and_no_picture(tmp_path: Path) -> None:
    (tmp_path / "response.png").write_bytes(b"of before")
    none = Response((), reasons=(CurveEnd("no first motion"),))
    write_response(tmp_path, ("excitation",), none, title="")
    assert (tmp_path / "response.csv").read_text() == ",".join(COLUMNS) + "\n"
    assert [path.name for path in tmp_path.iterdir()] == ["response.csv"]


def test_a_response_beside_a_run_is_named_by_its_file(
    results: Path, study_file: StudyFile, command: Command
) -> None:
    """A folder with both files is one of a run."""
    assert command("run", study_file(STOP), "--output", results).code == 0
    command("report", results / "response.h5", "--output", "response.html")
    command("report", results, "--output", "run.html")
    kickers = [Path(f"{name}.html").read_text("utf-8") for name in ("response", "run")]
    assert ["Nonlinear mode 1" in each for each in kickers] == [False, True]
    drawn = [
        command("plot", each, "--formats=svg", f"--output={number}").code
        for number, each in enumerate((results / "response.h5", results / "branch.h5"))
    ]
    assert drawn == [0, 0]
    assert [(Path(name) / "response.svg").exists() for name in "01"] == [True, False]
    start = ("--start", results, "--point=1:2", "--periods=1", "--frequency=0.15")
    ended = command("simulate", study_file(STOP), *start, "--output=sim")
    assert ended.code == 0 and "starts from level 1, branch 1, point 2" in ended.out
    words = f"the response of this folder is in {results / 'response.h5'}"
    command("export", results, "--at=0.15").assert_one_line(2, "--at: is for a response", words)
