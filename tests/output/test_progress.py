"""Lines about long stages, and how long many contact points are going to take."""

from __future__ import annotations

import io
from threading import Event

import numpy as np
import pytest
from rich.console import Console

from fenics_nnm.progress import WHAT, Lines, progress
from fenics_nnm.stages import Stages, duration
from fenics_nnm.structure.expected_time import Costs, expectation


def test_a_long_stage_tells_how_far_it_is_and_a_short_one_nothing() -> None:
    told: list[str] = []
    now = [0.0]
    lines = Lines(told.append, clock=lambda: now[0])
    for name, at, done in [
        ("modes", 0, 0.0),
        ("modes", 15, 0.5),
        ("modes", 19, 1.0),
        ("backbone", 20, 0.0),
        ("backbone", 50, 0.25),
        ("backbone", 60, 0.3),
        ("backbone", 140, 0.5),
        ("backbone", 170, 1.0),
    ]:
        now[0] = at
        lines.hear(name, done)
    assert told == [
        f"backbone ({WHAT['backbone']}): 25% after 30 s, about 1.5 min left",
        f"backbone ({WHAT['backbone']}): 50% after 2 min, about 2 min left",
    ]


def test_a_stage_that_reports_nothing_is_told_of_every_half_minute() -> None:
    told: list[str] = []
    now = [0.0]
    lines = Lines(told.append, clock=lambda: now[0])
    lines.tick()  # before the first stage
    lines.hear("mesh", 0.0)
    for at in (10, 31, 50, 62, 93, 123):
        now[0] = at
        lines.tick()
    lines.hear("mesh", 1.0)
    now[0] = 200
    lines.tick()
    spent = ("31 s", "62 s", "1.5 min", "2 min")
    assert told == [f"mesh ({WHAT['mesh']}): not done after {time}" for time in spent]


def test_a_stage_that_checks_what_it_found_is_told_of_until_its_end() -> None:
    told: list[str] = []
    now = [0.0]
    lines = Lines(told.append, clock=lambda: now[0])
    stages = Stages(lines.hear)
    with stages.stage("backbone"):
        now[0] = 20
        stages.report(1.0)
        now[0] = 40
        lines.tick()
    now[0] = 100
    lines.tick()
    assert told == [f"backbone ({WHAT['backbone']}): found after 40 s, and checked now"]


def test_the_clock_goes_on_beside_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fenics_nnm.progress._PATIENCE", 0.02)
    monkeypatch.setattr("fenics_nnm.progress._PAUSE", 0.01)
    told, heard = [], Event()

    def tell(line: str) -> None:
        told.append(line)
        heard.set()

    with progress(Console(file=io.StringIO()), tell) as stages, stages.stage("modes"):
        assert heard.wait(10)
    assert told[0].startswith("modes (linear modes")


def test_lines_go_where_there_is_no_terminal_and_none_from_a_quiet_rank() -> None:
    for quiet in (False, True):
        told: list[str] = []
        with progress(Console(file=io.StringIO(), quiet=quiet), told.append) as stages:
            stages.tell("2000 contact points")
        assert told == ([] if quiet else ["2000 contact points"])


def test_expected_time_is_that_of_the_measured_costs() -> None:
    costs = Costs(solution=4e-3, operation=1e-10)
    assert costs.attachments(2000, 12_000) == 2 * 2000 * 4e-3 + 8 * 12_000 * 2000**2 * 1e-10
    assert np.isclose(costs.branch(2000, 10), costs.branch(1000, 10) * 8)
    line = expectation(costs, 2000, 12_000, 3)
    assert line.startswith("2000 contact points: about ") and "for 3 motions" in line
    assert expectation(costs, 300, 12_000, 3) == ""


def test_costs_are_measured_with_a_few_columns() -> None:
    asked: list[int] = []

    def static(forces: np.ndarray) -> np.ndarray:
        asked.append(forces.shape[1])
        return forces

    costs = Costs.measured(static, np.ones((5, 40)))
    assert asked == [16, 16]
    assert 0 < costs.operation < 1e-6 and costs.solution > 0


def test_durations_are_round() -> None:
    assert [duration(seconds) for seconds in (0.2, 40, 200)] == ["1 s", "40 s", "3.5 min"]
    assert [duration(seconds) for seconds in (90, 125, 640)] == ["1.5 min", "2 min", "11 min"]
