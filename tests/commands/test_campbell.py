"""fenics-nnm campbell: lines, crossings and files of a beam at speed, and bad arguments."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import PLATE, ROD, Ended

from fenics_nnm.commands.campbell import orders_of, speeds_from
from fenics_nnm.errors import StudyError

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: Speeds of the tests in rad/s; the beam bends along the axis and flaps.
SPIN = {"axis": "y", "speed": 100.0, "origin": [-0.5, 0.0, 0.0]}


def rows(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text().splitlines()))


def test_lines_and_crossings_of_a_beam(study_file: StudyFile, command: Command) -> None:
    """Stiffening raises f^2 with Omega^2; crossings lie on the lines; the gap closes."""
    growing = {
        "gap": None,
        "direction": [1.0, 0.0],
        "points": 1,
        "casing": {
            "shape": "cylinder",
            "axis": "y",
            "origin": [-0.5, 0.0],
            "radius": 1.51,
            "growth": 1e-4,
        },
    }
    study = study_file(PLATE, rotation=SPIN, mesh={"height": 0.05}, contact=growing)
    ended = command(
        *("campbell", study, "--speeds", "0:400:200", "--modes", 2, "--orders", "1,2,4"),
        *("--output", "out"),
    )
    assert ended.code == 0, ended.err
    lines = rows(Path("out/campbell.csv"))
    assert [row["mode"] for row in lines] == ["1", "2"] * 3
    f = np.array([float(row["frequency_Hz"]) for row in lines]).reshape(3, 2)
    raised = (f[1:] ** 2 - f[0] ** 2) / (np.array([200.0, 400.0])[:, None] / 2 / np.pi) ** 2
    assert raised[1] == pytest.approx(raised[0], rel=0.02)  # Southwell
    assert 1.5 < raised[1, 0] < 2.5  # 1.19 + 1.57 R/L of a slender cantilever about its root
    shown = command("check", study, "--set", "rotation.speed=400.0").out
    assert f"    1   {f[2, 0]:14.6g}" in shown
    gaps = [float(row["smallest_gap_m"]) for row in lines[::2]]
    assert gaps[0] == pytest.approx(1e-2, rel=1e-9)
    # the casing grows by 1.6 mm at four times its speed, a rod by k^2 (R L^2 / 2 + L^3 / 3)
    k = 400.0 / np.sqrt(2.1e11 / 7800.0)
    assert 1e-2 + 16e-4 - gaps[2] == pytest.approx(k**2 * (0.25 + 1 / 3), rel=2e-2)
    crossed = rows(Path("out/crossings.csv"))
    assert crossed and {row["engine_order"] for row in crossed} <= {"1", "2", "4"}
    for row in crossed:
        speed, hertz, mode = (float(row[name]) for name in ("speed_rad_s", "frequency_Hz", "mode"))
        assert hertz == pytest.approx(float(row["engine_order"]) * speed / 2 / np.pi, rel=1e-9)
        on_line = np.sqrt(np.interp(speed**2, [0, 4e4, 16e4], f[:, int(mode) - 1] ** 2))
        assert hertz == pytest.approx(on_line, rel=1e-9)
    assert all(Path(f"out/campbell.{ending}").stat().st_size for ending in ("png", "svg"))


def test_speeds_that_a_body_cannot_bear_are_missing(
    study_file: StudyFile, command: Command
) -> None:
    """A body on springs flies away where Omega^2 is above k / m, 7.02 kg here."""
    springs = [{"at": [x], "stiffness": [7.02 / 2 * 50**2]} for x in (0.0, 1.0)]
    rotation = {"axis": "z", "origin": [0.5, 0.0, 0.0], "speed": 10.0}
    study = study_file(ROD, clamp=None, spring=springs, rotation=rotation, mode={"harmonics": 7})
    arguments = ("campbell", study, "--speeds", "0:80:40", "--modes", 1, "--energies", 1e-6)
    ended = command(*arguments, "--output", "out")
    assert ended.code == 1
    assert "incomplete: 1 of 3 speeds without frequencies, the first at 80 rad/s" in ended.err
    found = rows(Path("out/campbell.csv"))
    f = [float(row["frequency_Hz"]) for row in found[:4]]
    assert 2 * np.pi * np.array(f) == pytest.approx([50, 50, 30, 30], rel=1e-4)
    reason = "failed: static state: 38.9% of the steady loads"  # 2500 / 6400
    assert found[4]["status"].startswith(reason)
    by_two = command(*arguments, "--output", "two", "--jobs", 2)
    assert (by_two.code, by_two.err) == (1, ended.err)
    assert Path("two/campbell.csv").read_bytes() == Path("out/campbell.csv").read_bytes()
    kept = [sorted(Path(name, "motions.jsonl").read_text().split("\n")) for name in ("out", "two")]
    assert kept[0] == kept[1]


@pytest.mark.parametrize(
    "text",
    [
        "1:2",
        "0:10:0",
        "5:1:1",
        "-1:3:1",
        "a:b:c",
        "0:inf:1",
        "0:1:1e-9",
        "0:1:1e-300",
        "0:1e300:1e299",
    ],
)
def test_speeds_that_are_none(text: str) -> None:
    with pytest.raises(StudyError, match=r"^--speeds .*must"):
        speeds_from(text)


def test_arguments(study_file: StudyFile, command: Command) -> None:
    assert speeds_from("0:60:40", turns=True) == pytest.approx([0, np.pi, 2 * np.pi])
    assert orders_of("1, 4") == [1, 4]
    for text in ("0", "1,1", "1,01", "x", "1.5", "9" * 5000):
        with pytest.raises(StudyError, match="must be different positive integers"):
            orders_of(text)
    asked = ("campbell", study_file(ROD), "--speeds", "0:1:1")
    command(*asked).assert_one_line(2, "rotation: is")
    command(*asked, "--jobs", 0).assert_one_line(2, "--jobs 0: must be at least 1")


def test_wrong_arguments_are_one_line(capfd: pytest.CaptureFixture[str], command: Command) -> None:
    with pytest.raises(SystemExit) as ended:
        command("campbell", "study.toml", "--speeds", "0:1:1", "--modes", "x")
    said = "argument --modes: invalid int value: 'x': see fenics-nnm campbell --help"
    assert (ended.value.code, capfd.readouterr().err) == (2, f"fenics-nnm: {said}\n")
