"""The journeys of the user guide, run from its text on small meshes."""

from __future__ import annotations

import csv
import re
import runpy
import shlex
import shutil
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Ended

from fenics_nnm.files.cache import VARIABLE
from fenics_nnm.output.pictures.backbone import frequency_plots
from fenics_nnm.output.pictures.scene import Scene
from fenics_nnm.study import read_study

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "docs/user_guide.md").read_text("utf-8")

Command = Callable[..., Ended]

#: Numbers in the place of those of the page, by key: small meshes, few modes and harmonics.
SMALLER = {
    "order": "1",
    "element_size": "16.0",
    "edge_size": "8.0",
    "modes": "3",
    "points": "4",
    "harmonics": "5",
    "samples": "48",
}

#: Words of commands in the place of those of the page: two speeds in place of thirteen.
FEWER = {"0:18000:1500": "0:18000:18000"}

#: Column and unit of backbone.csv by what a point was asked for.
COLUMNS = {"amplitude": "displacement_m", "stress": "von_mises_Pa", "energy": "energy_J"}


def blocks(heading: str) -> Iterator[tuple[str, str]]:
    """Language and text of the blocks of code below a heading, in their order."""
    (part,) = re.findall(rf"^## {heading}\n(.*?)(?=^## )", GUIDE, re.MULTILINE | re.DOTALL)
    yield from re.findall(r"^```(\w*)\n(.*?)^```", part, re.MULTILINE | re.DOTALL)


def smaller(text: str) -> str:
    for key, value in SMALLER.items():
        text = re.sub(rf"^{key} = [\d.]+", f"{key} = {value}", text, flags=re.MULTILINE)
    return re.sub(r"size = 3\.0, distance = 15\.0", "size = 10.0, distance = 5.0", text)


def with_sections(study: str, sections: str) -> str:
    """A study with some sections in the place of its own, or after them."""
    for name in re.findall(r"^\[(\w+)\]", sections, re.MULTILINE):
        study = re.sub(rf"^\[{name}\].*?(?=^\[|\Z)", "", study, flags=re.MULTILINE | re.DOTALL)
    return f"{study}\n{sections}"


class Walk:
    """A walk through the blocks of a journey.

    Attributes:
        command: Calls the command line.
        study: The study of the journey.
        fitted: Makes a study as small as a test needs it.
    """

    def __init__(
        self,
        command: Command,
        monkeypatch: pytest.MonkeyPatch,
        study: str,
        fitted: Callable[[str], str] = smaller,
    ) -> None:
        self.command, self.study, self.fitted = command, Path(study).resolve(), fitted
        self._chdir = monkeypatch.chdir

    def along(self, heading: str) -> None:
        """Do what the blocks below a heading say."""
        for language, text in blocks(heading):
            if language == "toml":
                self._toml(text)
            elif not language:
                self._lines(text)

    def _toml(self, text: str) -> None:
        """A whole study is written; sections of one take their place in it."""
        whole = "[contact]" in text
        study = text if whole else with_sections(self.study.read_text(), text)
        if "[mesh]" in text and not whole:  # another body: its study is read, and not run
            self.study.with_name("design.toml").write_text(study)
            assert read_study(self.study.with_name("design.toml"))
            return
        self.study.write_text(self.fitted(study))

    def _lines(self, text: str) -> None:
        for line in text.splitlines():
            words = [FEWER.get(word, word) for word in shlex.split(line, comments=True)]
            match words:
                case ["cd", folder]:
                    self._chdir(folder)
                case ["paraview", state]:
                    assert Path(state.partition("=")[2]).is_file()
                case ["fenics-nnm", *arguments]:
                    self._called(arguments)

    def _called(self, arguments: list[str]) -> None:
        ended = self.command(*arguments)
        assert ended.code == 0, (arguments, ended.err)
        if arguments[0] == "new":
            self.study.write_text(self.fitted(self.study.read_text()))


@pytest.fixture
def walk(command: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., Walk]:
    """A function that begins a walk with a study, in an empty folder.

    Bodies are not drawn, and of the plots those of the frequency alone: others are slow.
    """
    monkeypatch.setenv(VARIABLE, str(tmp_path / "kept"))
    monkeypatch.setattr("fenics_nnm.output.gallery._PLOTS", (frequency_plots,))
    for module in ("gallery", "pictures.groups"):
        monkeypatch.setattr(f"fenics_nnm.output.{module}.render", blank)
    return partial(Walk, command, monkeypatch)


def blank(scenes: list[Scene]) -> list[Any]:
    """Empty pictures of the right sizes."""
    shapes = ((*each.camera.pixels[::-1], 3) for each in scenes)
    return [np.full(shape, 255, dtype=np.uint8) for shape in shapes]


def rows(path: str) -> list[dict[str, str]]:
    with Path(path).open() as file:
        return list(csv.DictReader(file))


def assert_asked(folder: str, *asked: str) -> None:
    """Points have the values that they were asked for."""
    found = {row["asked_for"]: row for row in rows(f"{folder}/backbone.csv") if row["asked_for"]}
    for text in asked:
        (row,) = (row for said, row in found.items() if said.startswith(text))
        kind, value = text.split()[:2]
        assert float(row[COLUMNS[kind]]) == pytest.approx(float(value), rel=1e-4), text


def test_step_file(walk: Callable[..., Walk], tmp_path: Path, monkeypatch: Any) -> None:
    made = runpy.run_path(str(ROOT / "demos/step/blade.py"))["RESULTS"] / "blade.step"
    shutil.copy(made, tmp_path)
    walk("blade.toml").along("My STEP file")
    assert_asked("results/asked", "amplitude 0.00035 m", "stress 2.5e+07 Pa")
    for name in ("frequency_amplitude.png", "frequency_stress.png"):
        assert Path("results/asked/pictures", name).stat().st_size > 10_000
    assert len(list(Path("stresses").glob("motion_*_contact.pvd"))) == 2
    assert "<img" in Path("results/blade/report.html").read_text("utf-8")


def test_parametric_blade(walk: Callable[..., Walk]) -> None:
    walk("blade/blade.toml").along("The parametric blade")
    assert_asked("results/blade", "amplitude 0.002 m", "amplitude 0.0025 m", "stress 3e+08 Pa")
    names = {path.name for path in Path("results/blade/pictures").iterdir()}
    assert {"frequency_amplitude.png", "frequency_stress.svg"} <= names
    assert len(list(Path("stresses").glob("motion_*_contact.pvd"))) == 2
    for row in rows("results/blade-sweep/sweep.csv"):
        assert row["status"] == "complete"
        assert float(row["von_mises_Pa_at_stress_3e+08_Pa"]) == pytest.approx(3e8, rel=1e-4)
        assert float(row["displacement_m_at_amplitude_0.002_m"]) == pytest.approx(2e-3, rel=1e-4)


def test_matrices(walk: Callable[..., Walk], command: Command, tmp_path: Path) -> None:
    assert command("new", "matrices").code == 0
    with np.load("matrices.npz") as given:
        named = dict(given)
    Path("matrices.npz").unlink()
    Path("matrices.toml").unlink()
    ((_, script),) = (each for each in blocks("Matrices from another code") if each[0] == "python")
    exec(script, named)
    walk("matrices.toml", fitted=str).along("Matrices from another code")
    assert_asked("results/matrices", "amplitude 0.0012 m")
    found = rows("results/matrices/backbone.csv")
    assert {row["status"] for row in found} == {"verified"}
    first, last = found[0], found[-1]
    (asked,) = (row for row in found if row["asked_for"])
    for row, words in (
        (first, "until its pad meets the stop"),
        (asked, "at 1.2 mm"),
        (last, "at a gamma ratio of 1.5"),
    ):
        said = f"{float(row['frequency_Hz']):.2f} Hz {words}"
        assert said in " ".join(GUIDE.split()), said


def test_a_blade_at_speed(walk: Callable[..., Walk], command: Command) -> None:
    assert command("new", "blade", "rotor37.toml").code == 0
    Path("rotor37.toml").write_text(smaller(Path("rotor37.toml").read_text()))
    walk("rotor37.toml").along("A rotating blade")
    found = rows("results/rotor37-campbell/campbell.csv")
    lines = [row for row in found if row["status"] != "linear"]
    speeds = list(dict.fromkeys(row["speed_rad_s"] for row in found))
    for column, values in (("energy_J", (0.5, 1.0, 2.0)), ("amplitude_m", (1e-3, 2e-3))):
        for value in values:
            hits = [row for row in lines if float(row[column]) == pytest.approx(value, rel=1e-4)]
            assert [row["speed_rad_s"] for row in hits] == speeds, (column, value)
