"""The Python face: its examples, against the commands, and its errors."""

from __future__ import annotations

import doctest
import inspect
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import ROD, Ended, contents

import fenics_nnm as nnm
from fenics_nnm.face import study as module_of_studies
from fenics_nnm.face.tables import read_table
from fenics_nnm.output.campbell_report import write_campbell
from fenics_nnm.processes import environment_of_child
from fenics_nnm.results.tables import COLUMNS
from fenics_nnm.structure.campbell import AtSpeed

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/python.md"

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def branch() -> nnm.Branch:
    """The small rod of all tests."""
    return nnm.make_study(ROD).branch()


def run_examples(test: doctest.DocTest) -> None:
    lines: list[str] = []
    found = doctest.DocTestRunner(optionflags=FLAGS).run(test, out=lines.append)
    assert found.attempted > 0
    assert found.failed == 0, "".join(lines)


@pytest.fixture
def tables(command: Callable[..., Ended], study_file: Callable[..., Path]) -> None:
    """The Campbell diagram and the sweep that the page reads, where it reads them."""
    at = [AtSpeed(speed, np.array([1.0]), 1e-3) for speed in (0.0, 10.0)]
    write_campbell(Path("results/rod-campbell"), at, [1], title="Rod")
    some = {"energies": {"from": 0.9, "to": 1.0, "step": 0.1}, "report_at": []}
    file = study_file(continuation=some)
    gaps = ("--set", "contact.gap=3e-4,5e-4")
    assert command("sweep", file, *gaps, "--output", "results/rod-sweep").code == 0


@pytest.mark.usefixtures("tables")
def test_examples_of_the_page() -> None:
    text = re.sub(r"^```.*$", "", PAGE.read_text("utf-8"), flags=re.MULTILINE)
    run_examples(doctest.DocTestParser().get_doctest(text, {}, PAGE.name, str(PAGE), 0))


def test_examples_of_the_module() -> None:
    tests = [each for each in doctest.DocTestFinder().find(module_of_studies) if each.examples]
    assert tests
    for each in tests:
        run_examples(each)


def test_the_page_lists_all_stable_names() -> None:
    table = PAGE.read_text("utf-8").partition("## Stable names")[2]
    words = set(re.findall(r"\w+", table)) | set(re.findall(r"\w+Error", PAGE.read_text("utf-8")))
    assert not set(nnm.__all__) - words
    for name in nnm.__all__:
        members = vars(getattr(nnm, name)) if inspect.isclass(getattr(nnm, name)) else {}
        public = {m for m in members if not m.startswith("_")} if "Error" not in name else set()
        assert not public - words, name


def test_type_checkers_know_the_same_names() -> None:
    stub = (ROOT / "fenics_nnm/__init__.pyi").read_text("utf-8")
    assert {*re.findall(r" as (\w+)", stub), "__version__"} == set(nnm.__all__)
    with pytest.raises(AttributeError, match="no attribute 'read'"):
        nnm.read


def test_what_is_heavy_is_imported_when_it_is_used() -> None:
    """Version and help need the standard library alone, a study no finite elements and no plots."""
    program = (
        "import sys, fenics_nnm as nnm, fenics_nnm.cli\n"
        "fenics_nnm.cli._parser()\n"
        "assert not {'numpy', 'pydantic', 'rich'} & set(sys.modules)\n"
        "nnm.Study, nnm.StudyError\n"
        "print(*{'dolfinx', 'matplotlib', 'mpi4py', 'h5py', 'pyvista', 'rich'} & set(sys.modules))"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program],
        env=environment_of_child(),
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (ended.returncode, ended.stdout.strip()) == (0, ""), ended.stderr


def test_results_are_those_of_the_command(
    branch: nnm.Branch, study_file: Callable[..., Path], command: Callable[..., Ended]
) -> None:
    """To the last digit: one code path; and the saved folder has the same files."""
    assert command("run", study_file(), "--output", "ran").code == 0
    ran = nnm.load_branch("ran")
    assert list(ran.table) == list(COLUMNS)
    for name, values in ran.table.items():
        np.testing.assert_array_equal(branch.table[name], values)
    branch.save("saved")
    saved, there = contents(Path("saved")), contents(Path("ran"))
    assert set(saved) == set(there)
    assert saved["backbone.csv"] == there["backbone.csv"]
    assert saved["fields/view.py"] == there["fields/view.py"]


def test_motion_and_contact_agree(branch: nnm.Branch) -> None:
    """The tip of the rod is its contact point; velocities are derivatives of displacements."""
    point = branch[-1]
    tip, contact = point.motion(at=[(1.0,)], instants=256), point.contact(256)
    moved = tip.displacement_m[:, 0, 0]
    np.testing.assert_allclose(moved, contact.displacement_m[:, 0], atol=1e-12)
    np.testing.assert_allclose(contact.distance_m[:, 0], 1e-3 - moved, atol=1e-12)
    assert (contact.force_N[:, 0] > 0).mean() == pytest.approx(
        branch.table["contact_fraction"][-1], abs=1 / 32
    )
    step = point.period_s / 256
    numeric = np.gradient(np.concatenate([moved, moved, moved]), step)[256:512]
    smooth = np.abs(contact.distance_m[:, 0]) > 1e-4
    scale = np.abs(numeric).max()
    np.testing.assert_allclose(
        tip.velocity_m_per_s[smooth, 0, 0], numeric[smooth], atol=0.01 * scale
    )
    assert point.largest_displacement_m == pytest.approx(np.abs(moved).max(), rel=1e-3)


def test_a_response_is_that_of_its_table(tmp_path: Path) -> None:
    """Curves of each place are the rows of response.csv; bad requests are told in a line."""
    driven = nnm.make_study(ROD).with_values(
        {
            "damping": {"ratio": 0.01},
            "excitation": {"force": [100.0], "at": [0.5]},
            "response": {
                "frequencies": {"from": 1290, "to": 1320, "step": 15},
                "levels": [1.0, 2.0],
                "backbone": False,
            },
        }
    )
    response = driven.response(tmp_path / "response")
    table = read_table(tmp_path / "response" / "response.csv", ["monitor"])
    for place in response.places:
        for curve in response.curves(place=place):
            own = (table["monitor"] == place) & (table["level"] == curve.level)
            assert len(curve) == own.sum() == 3
            np.testing.assert_allclose(curve.frequency_Hz, table["frequency_Hz"][own], rtol=1e-11)
            np.testing.assert_allclose(curve.amplitude_m, table["amplitude_m"][own], rtol=1e-11)
            np.testing.assert_allclose(curve.phase_deg, table["phase_deg"][own], rtol=1e-11)
            np.testing.assert_allclose(curve.highest_m, table["max_m"][own], rtol=1e-11)
    assert len(response.resonances["level"]) == 0 and np.isnan(table["speed_rad_s"]).all()
    for wrong in ({"level": 3.0}, {"place": "nowhere"}):
        with pytest.raises(ValueError, match="must be one of"):
            response.curves(**wrong)
    with pytest.raises(nnm.OutputError, match="must be those of a run"):
        nnm.load_branch(tmp_path / "response")


@pytest.mark.parametrize("text", [None, "", "folder,status\n1\n", "\x00"])
def test_tables_that_are_none_are_refused(tmp_path: Path, text: str | None) -> None:
    if text is not None:
        (tmp_path / "sweep.csv").write_text(text)
    with pytest.raises(nnm.OutputError, match=r"sweep\.csv: cannot be read"):
        nnm.load_sweep(tmp_path)


def test_grid_has_the_displacement_and_the_stress(branch: nnm.Branch) -> None:
    """At rest of the cosines the stress of a rod is E times its strain."""
    grid = branch[0].grid(0.5)
    moved = grid.point_data["displacement (m)"]
    at = branch[0].motion(at=grid.points, instants=2)
    np.testing.assert_allclose(moved, at.displacement_m[1], atol=1e-15)
    strain = np.gradient(moved[np.argsort(grid.points[:, 0]), 0], 0.25)
    mises = grid.point_data["von Mises stress (Pa)"][np.argsort(grid.points[:, 0])]
    np.testing.assert_allclose(mises[1:-1], 2.1e11 * np.abs(strain[1:-1]), rtol=1e-6)
    assert "von Mises stress (Pa)" not in branch[0].grid(stress=False).point_data


def test_one_linear_analysis_for_two_gaps(monkeypatch: pytest.MonkeyPatch) -> None:
    """And the frequency depends on gap and energy by energy over gap squared alone."""
    study = nnm.make_study(ROD)
    first = study.branch()
    monkeypatch.setattr("fenics_nnm.structure.shared_analysis.linear_analysis", None)
    second = study.with_values({"contact.gap": np.float64(2e-3)}).branch()
    np.testing.assert_allclose(second.energy_J, 4 * first.energy_J, rtol=1e-9)
    np.testing.assert_allclose(second.frequency_Hz, first.frequency_Hz, rtol=1e-9)


def test_matrices_have_contact_and_no_mesh(tmp_path: Path) -> None:
    energies = {"from": 1.0, "to": 1.1, "step": 0.1}
    changes = {"continuation": {"energies": energies}, "mode.harmonics": 3, "mode.samples": 32}
    study = nnm.new_study("matrices", tmp_path).with_values(changes)
    check, branch = study.check(), study.branch()
    assert check.contact_points_m.shape == (0, 3)
    assert check.shapes_at_contact.shape == (len(check.gap_m), len(check.frequency_Hz))
    point = branch[-1]
    moved = point.contact(48).displacement_m
    assert point.largest_displacement_m == pytest.approx(np.abs(moved).max(), rel=1e-12)
    assert point.largest_displacement_m > 1e-3
    with pytest.raises(nnm.OutputError, match="motion: needs a mesh"):
        point.motion()
    with np.load(tmp_path / "matrices.npz") as file:
        rows = np.atleast_2d(file["B"])
    np.testing.assert_allclose(point.unknowns(48).displacement_m @ rows.T, moved, atol=1e-15)


def test_incomplete_branch_is_logged(caplog: pytest.LogCaptureFixture) -> None:
    """What a command ends with exit code 1 for is no silent success."""
    changes = {
        "reduction.method": "craig-bampton",
        "augmented_lagrangian.iterations": 1,
        "continuation": {"energies": {"from": 1.0, "to": 1.2, "step": 0.2}},
    }
    branch = nnm.make_study(ROD).with_values(changes).branch()
    assert not branch.complete
    assert branch.reason.startswith("no point at gamma ratio 1.2")
    assert f"incomplete: {branch.reason}" in caplog.text
    changes["continuation"] = {"energies": {"from": 1.3, "to": 1.4, "step": 0.1}}
    with pytest.raises(nnm.ConvergenceError, match="no point converged; at gamma"):
        nnm.make_study(ROD).with_values(changes).branch()


def test_errors_are_the_lines_of_the_commands(
    branch: nnm.Branch, study_file: Callable[..., Path], command: Callable[..., Ended]
) -> None:
    path = study_file(contact={"gap": -1e-3}, reduction={"method": "craig-bampton"})
    with pytest.raises(nnm.ModelError) as raised:
        nnm.read_study(path).branch()
    command("run", path).assert_one_line(2, str(raised.value))
    assert "contact.gap" in str(raised.value)  # in the words of the study file
    with pytest.raises(nnm.OutputError, match="1 m from the nearest node"):
        branch[0].motion(at=[(2.0, 0.0, 0.0)])
    with pytest.raises(nnm.OutputError, match="is missing"):
        nnm.load_branch("nothing")
    with pytest.raises(nnm.StudyError, match="kind = 'car': must be one of blade"):
        nnm.new_study("car")
    with pytest.raises(nnm.StudyError, match="is there already"):
        nnm.new_study("rod", path)
    with pytest.raises(nnm.StudyError, match="cannot be read"):
        nnm.read_study("nothing.toml")
    Path("mine").mkdir()
    Path("mine/report.html").write_text("mine")
    with pytest.raises(nnm.StudyError, match="must be another folder"):
        branch.save("mine")
    for wrong in ({}, {"energy_J": 1.0, "gamma_ratio": 1.0}, {"energy_J": float("nan")}):
        with pytest.raises(ValueError, match="must be given one value"):
            branch.nearest(**wrong)
    for wrong in ({"mass": 1.0}, {"status": 1.0}, {"damping_ratio": 1.0}):
        with pytest.raises(ValueError, match="is no column"):
            branch.nearest(**wrong)
    assert branch.nearest(von_mises_Pa=1e12).energy_J == branch.energy_J.max()
    for wrong in (0, 2.5, float("nan"), "3", 10**9):
        with pytest.raises(ValueError, match="instants = "):
            branch[0].contact(wrong)
    for wrong in ("0.5", float("inf"), None):
        with pytest.raises(ValueError, match="must be a finite number"):
            branch[0].grid(wrong)
    for wrong in ([], ["1 m"], [[]]):
        with pytest.raises(ValueError, match=r"must be (places|a place)"):
            branch[0].motion(at=wrong)
    with pytest.raises(ValueError, match="must be given one value"):
        branch.nearest(displacement_m="1 mm")
    with pytest.raises(TypeError, match="integer"):
        branch[0:2]
    with pytest.raises(nnm.StudyError, match="is no key"):
        nnm.make_study(ROD).with_values({"": 1})
    with pytest.raises(ValueError, match="must be one of 'gamma ratio'"):
        branch.plot(over="time")
    with pytest.raises(ValueError, match="must be places"):
        branch[0].motion(at=[1.0])


def test_temporary_results_go_with_their_last_user() -> None:
    branch = nnm.make_study(ROD).branch()
    folder, point = branch.folder, branch[0]
    del branch
    assert (folder / "branch.h5").exists()
    del point
    assert not folder.exists()
