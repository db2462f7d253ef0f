"""What the terminal shows: the table of a run, the lines of --verbose, warnings."""

from __future__ import annotations

import io
import logging
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, ROD, Ended
from ranks import on_ranks, own_lines
from rich.console import Console

from fenics_nnm.backbone.extremes import Extremes, Spot, StressPeak
from fenics_nnm.backbone.follow import Branch
from fenics_nnm.backbone.point import (
    CONVERGED,
    FAILED,
    FREQUENCY_RATIO,
    GAMMA_RATIO,
    STATUSES,
    VERIFIED,
    Balance,
    BranchPoint,
    ContinuationNotes,
    ExpectedErrors,
    Return,
    Verdict,
)
from fenics_nnm.backbone.verdict import WITH_MASS
from fenics_nnm.commands.run_table import line_of_marks, result_table
from fenics_nnm.mechanics.motion import Motion
from fenics_nnm.processes import environment_of_child
from fenics_nnm.run import RunResult
from fenics_nnm.running.trust import warn_of_points
from fenics_nnm.study import read_study

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

POINT = BranchPoint(
    position=1.0625,
    at={GAMMA_RATIO: 1.0625, FREQUENCY_RATIO: 1.123456},
    motion=Motion(
        q=np.zeros((2, 1)),
        force=np.zeros((3, 1)),
        free=np.zeros((2, 1)),
        frequency=123456.789,
        rayleigh_frequency=1.0,
        energy=1.0,
        contact_fraction=0.0,
    ),
    balance=Balance(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    expected=ExpectedErrors(reduction=None, series=None),
    notes=ContinuationNotes(iterations=3, slope_ratio=0.5),
    returned=Return(0.5, 1.0, 0.0),
    verdict=Verdict(FAILED, "after one period the motion misses its start by 50%"),
)


def branch_of(*points: BranchPoint) -> Branch:
    return Branch(points, (), "reached gamma ratio 3")


def test_table_fits_on_a_narrow_terminal(study_file: StudyFile, tmp_path: Path) -> None:
    points = [replace(POINT, verdict=Verdict(status)) for status in STATUSES]
    result = RunResult(tmp_path, branch_of(*points), {})
    text = io.StringIO()
    Console(file=text, width=60).print(result_table(result, read_study(study_file())))
    lines = text.getvalue().splitlines()
    assert max(map(len, lines)) <= 60
    assert "…" not in text.getvalue()
    assert [line.split()[0] for line in lines].count("1.0625") == len(STATUSES)
    for words in ("gamma ratio", "frequency (Hz)", "123456.7890", "1.12346", *STATUSES):
        assert words in text.getvalue()


def printed(study: Path, *points: BranchPoint, width: int = 100) -> list[str]:
    """Lines of the table of such points."""
    text, result = io.StringIO(), RunResult(Path(), branch_of(*points), {})
    table = result_table(result, read_study(study), width)
    Console(file=text, width=width).print(table)
    return text.getvalue().splitlines()[2:]


def numbered(count: int) -> list[BranchPoint]:
    return [replace(POINT, at={**POINT.at, GAMMA_RATIO: 1 + n / 100}) for n in range(count)]


def test_short_branches_are_shown_whole_and_long_ones_by_ends_and_reported_points(
    study_file: StudyFile,
) -> None:
    reported = study_file(continuation={"report_at": [1.02, 1.1]})
    assert len(printed(reported, *numbered(20))) == 20
    ratios = [float(line.split()[0]) for line in printed(reported, *numbered(21))]
    assert ratios == [1.0, 1.02, 1.1, 1.2]
    spread = [
        line.split()[0]
        for line in printed(study_file(continuation={"report_at": []}), *numbered(100))
    ]
    assert (spread[0], spread[1], spread[-1], len(spread)) == ("1", "1.1", "1.99", 11)


def test_points_beyond_yield_are_marked_whatever_their_status(study_file: StudyFile) -> None:
    """A verdict is about the equations, not about the metal."""
    extremes = Extremes(
        displacement=Spot(2e-3), von_mises=StressPeak(away=Spot(5e9)), yield_margin=Spot(0.2)
    )
    sound, broken = replace(POINT, verdict=Verdict(VERIFIED)), replace(POINT, extremes=extremes)
    for width in (60, 100):
        lines = printed(
            study_file(), sound, replace(broken, verdict=Verdict(VERIFIED)), width=width
        )
        assert [line.split()[-1] for line in lines] == ["verified", "*"]
    assert "2      5000" in lines[1]
    assert line_of_marks([sound, sound]) == ""
    assert line_of_marks([sound, broken]).startswith("* beyond yield, 1 of 2 points: ")


def warned(caplog: pytest.LogCaptureFixture, *points: BranchPoint) -> str:
    caplog.clear()
    warn_of_points(branch_of(*points))
    (message,) = caplog.messages
    return message


def test_failed_points_are_warned_of(caplog: pytest.LogCaptureFixture) -> None:
    worse = replace(
        POINT,
        at={**POINT.at, GAMMA_RATIO: 2.0},
        returned=Return(0.75, 1.0, 0.0),
        verdict=Verdict(FAILED, "misses its start by 75%"),
    )
    message = warned(caplog, POINT, worse)
    assert "2 of 2 points failed: at gamma ratio 2 misses its start by 75%" in (message)


def test_points_without_a_check_in_time_are_warned_of(caplog: pytest.LogCaptureFixture) -> None:
    massive = replace(POINT, returned=None, verdict=Verdict(CONVERGED, WITH_MASS))
    message = warned(caplog, massive, replace(massive, at={**POINT.at, GAMMA_RATIO: 2.0}))
    assert "2 of 2 points solve their equations, but are not verified in time: contact" in message
    assert "nan" not in message


def test_a_run_shows_its_table_and_place_without_a_terminal(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    first = command("run", study_file(), "--output", "out")
    lines = first.out.splitlines()
    assert sum(bool(re.match(r" +1\.1 +\d+\.\d{4} ", line)) for line in lines) == 1  # report_at
    assert re.search(r"^reached gamma ratio 1.1; results in out \([\d.]+ [kM]B\)$", lines[-1])
    assert first.err == ""
    again = command("run", study_file(), "--output", "out").out.splitlines()
    assert again[:-1] == lines
    assert again[-1].startswith('they replace "Small rod", 4 points, of 20')
    assert again[-1].endswith("in out: branch.h5, backbone.csv, summary.json, backbone.png, fields")


def test_verbose_tells_stages_and_points(
    study_file: StudyFile, command: Command, caplog: Any
) -> None:
    assert command("run", study_file(), "--output", "out", "-v").code == 0
    told = [record.getMessage() for record in caplog.records if record.levelno == logging.INFO]
    stages = [line.split(":")[0] for line in told if re.fullmatch(r"\w+: \d+\.\d\d s", line)]
    assert stages == [
        *("mesh", "assembly", "factors", "modes", "attachments"),
        *("output", "backbone", "stress", "output"),
    ]
    points = [line for line in told if re.match(r"gamma ratio [\d.]+: [\d.]+ Hz, ", line)]
    assert len(points) == 4
    caplog.clear()
    assert command("run", study_file(), "--output", "out").code == 0
    assert not [record for record in caplog.records if record.levelno == logging.INFO]


def test_verbose_tells_once_on_two_ranks(study_file: StudyFile, tmp_path: Path) -> None:
    ended = on_ranks(
        2, "-m", "fenics_nnm", "run", study_file(PLATE), "--output", "out", "-v", folder=tmp_path
    )
    assert ended.code == 0, ended.err
    lines = own_lines(ended)
    assert sum("assembly: " in line for line in lines) == 1
    assert sum("gamma ratio 1.1: " in line for line in lines) == 1


def test_help_lists_the_commands_in_the_order_of_their_use(
    command: Command, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        command("--help")
    assert ended.value.code == 0
    told = capfd.readouterr().out
    names = "new check run plot export report convergence sweep response simulate campbell"
    assert re.findall(r"^    ([a-z]+) ", told, re.MULTILINE) == [*names.split(), "cache"]
    (example,) = (line for line in told.splitlines() if "&&" in line)
    assert [part.split()[1] for part in example.split("&&")] == ["new", "run", "report"]


def test_reader_that_goes_away_ends_nothing(study_file: StudyFile, tmp_path: Path) -> None:
    """As with `fenics-nnm sweep ... | head -1`."""
    command = [sys.executable, "-P", "-m", "fenics_nnm", "sweep", str(study_file(ROD))]
    command += ["--set", "contact.gap=1e-4,2e-4", "--output", str(tmp_path / "out")]
    with subprocess.Popen(
        command,
        env=environment_of_child(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None and process.stderr is not None
        assert process.stdout.readline() == "2 studies: 0 done, 2 to run\n"
        process.stdout.close()
        assert not [line for line in process.stderr if not line.startswith("fenics-nnm: ")]
    assert process.returncode in (0, 1)
    assert len(list((tmp_path / "out").rglob("branch.h5"))) == 2
