"""A sweep: many studies, one table; nothing is run twice, or taken for what it is not."""

from __future__ import annotations

import csv
import json
import shlex
from collections.abc import Callable, Sequence
from multiprocessing import Pipe
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, ROD, Ended, changed
from matplotlib.figure import Figure
from PIL import Image
from ranks import on_ranks, own_lines

import fenics_nnm.running.following
import fenics_nnm.structure.shared_analysis
import fenics_nnm.sweep.pictures
from fenics_nnm.results.staging import claim
from fenics_nnm.running.worker_process import WorkerProcess
from fenics_nnm.study import study_from
from fenics_nnm.study.settings import Setting
from fenics_nnm.study.units import unit_of
from fenics_nnm.sweep.backbones import Backbones
from fenics_nnm.sweep.dealing import Hand, LocalCounters, grouped
from fenics_nnm.sweep.plan import folder_name, plan
from fenics_nnm.sweep.variation import variations
from fenics_nnm.sweep.workers import Worker, _received

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: Few points, no shooting: a study takes a few hundredths of a second.
QUICK: dict[str, Any] = changed(
    ROD,
    {
        "continuation": {
            "energies": {"from": 0.9, "to": 1.2, "step": 0.1},
            "report_at": [],
            "shooting": False,
        }
    },
)


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "sweep.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def stamps(folder: Path) -> dict[str, int]:
    return {str(path): path.stat().st_mtime_ns for path in folder.rglob("branch.h5")}


def texts(figure: Figure) -> list[str]:
    """Title and entries of the legend."""
    (legend,) = figure.legends
    return [legend.get_title().get_text(), *(text.get_text() for text in legend.get_texts())]


@pytest.fixture(autouse=True)
def drawn(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> dict[str, Figure]:
    """Pictures of a sweep by name; they are not written but in the test of the files."""
    figures: dict[str, Figure] = {}

    def keep(figure: Figure, folder: Path, name: str, formats: Sequence[str]) -> tuple[str, ...]:
        figures[name] = figure
        return ()

    if request.function is not test_pictures_are_files:
        monkeypatch.setattr(fenics_nnm.sweep.pictures, "save", keep)
    return figures


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """Arguments of each linear analysis that is made."""
    calls: list[object] = []
    original = fenics_nnm.structure.shared_analysis.linear_analysis

    def count(*arguments: Any, **keywords: Any) -> Any:
        calls.append(arguments)
        return original(*arguments, **keywords)

    monkeypatch.setattr(fenics_nnm.structure.shared_analysis, "linear_analysis", count)
    return calls


def test_gaps_scale_energies_and_leave_frequencies_alone(
    study_file: StudyFile, command: Command, counted: list[object]
) -> None:
    """With the gap g as unit of length the equations do not depend on it: f(gamma / gamma_1)."""
    study_file(QUICK)
    gaps = (2e-4, 1e-3, 5e-3)
    lists = ("--set", "contact.gap=2e-4,1e-3,5e-3", "--gamma", "1.2")
    ended = command("sweep", "study.toml", *lists)
    assert (ended.code, ended.err) == (0, "")
    assert len(counted) == 1
    folder = Path("results/study-sweep")
    table = rows(folder)
    assert [float(row["contact.gap"]) for row in table] == list(gaps)
    assert {row["status"] for row in table} == {"complete"}
    assert all(row["message"] == "" for row in table)
    frequencies = np.array([float(row["frequency_Hz_at_1.2"]) for row in table])
    energies = np.array([float(row["energy_J_at_1.2"]) for row in table])
    linear = float(table[0]["linear_frequency_Hz"])
    assert frequencies[0] > 1.001 * linear
    assert np.ptp(frequencies) < 1e-8 * linear
    assert np.allclose(energies / np.square(gaps), energies[1] / 1e-6, rtol=1e-8)
    curves = [
        np.loadtxt(folder / row["folder"] / "backbone.csv", delimiter=",", skiprows=1, usecols=(2,))
        for row in table
    ]
    assert np.ptp(curves, axis=0).max() < 1e-8 * linear


def test_each_study_has_a_point_at_an_amplitude(study_file: StudyFile, command: Command) -> None:
    """Before contact the gamma ratio is (a / g)^2: the end of the rod moves most, by a."""
    study_file(QUICK)
    sweep = ("sweep", "study.toml", "--set", "contact.gap=1e-3,2e-3", "--amplitude", "0.95mm")
    listed = command(*sweep, "--list").out.splitlines()
    assert all("continuation.report_at=" in shlex.split(line)[4] for line in listed)
    assert command(*sweep).code == 0
    table = rows(Path("results/study-sweep"))
    assert [row["folder"] for row in table] == ["contact.gap=0.001", "contact.gap=0.002"]
    found = [float(row["gamma_ratio_at_amplitude_0.00095_m"]) for row in table]
    assert np.allclose(found, [0.95**2, 0.475**2], rtol=1e-5)
    before = stamps(Path("results/study-sweep"))
    assert command(*sweep).code == 0
    assert stamps(Path("results/study-sweep")) == before


def test_pictures_show_the_curves_with_units(
    study_file: StudyFile, command: Command, drawn: dict[str, Figure]
) -> None:
    study_file(QUICK)
    lists = ("--set", "contact.gap=1e-3,2e-3", "--gamma", "1.2")
    command("sweep", "study.toml", *lists, "--output", "s")
    left, right = drawn["sweep"].axes
    for axes, column in ((left, 1), (right, 5)):
        curves = [line.get_xydata() for line in axes.lines if len(line.get_xdata()) == 4]
        for curve, gap in zip(curves, ("0.001", "0.002"), strict=True):
            file = f"s/contact.gap={gap}/backbone.csv"
            told = np.loadtxt(file, delimiter=",", skiprows=1, usecols=(column, 2))
            assert np.array_equal(curve, told)
    assert [left.get_xlabel(), left.get_ylabel()] == ["gamma ratio  (1)", "frequency  (Hz)"]
    assert right.get_xlabel() == "total energy  (J)"
    assert texts(drawn["sweep"]) == ["contact.gap (m)", "0.001", "0.002"]
    (axes,) = drawn["sweep_values"].axes
    assert axes.get_xlabel() == "contact.gap (m)"
    assert texts(drawn["sweep_values"]) == ["", "linear mode", "gamma ratio 1.2"]
    row = rows(Path("s"))[1]
    assert list(axes.lines[1].get_xydata()[1]) == [2e-3, float(row["frequency_Hz_at_1.2"])]


def test_pictures_tell_modes_apart(
    study_file: StudyFile, command: Command, drawn: dict[str, Figure]
) -> None:
    study_file(QUICK)
    lists = ("--set", "contact.gap=1e-3,2e-3", "--set", "mode.number=1,2")
    command("sweep", "study.toml", *lists, "--output", "s")
    assert len(drawn["sweep"].axes) == 4
    ratios = drawn["sweep"].axes[2]
    assert ratios.get_ylabel() == "frequency over\nlinear frequency  (1)"
    assert {line.get_linestyle() for line in ratios.lines if len(line.get_xdata()) == 4} == {
        "-",
        "--",
    }
    told = ["", "contact.gap (m)", "0.001", "0.002", "mode.number", "1", "2"]
    assert texts(drawn["sweep"]) == told
    assert "sweep_values" not in drawn


def test_pictures_are_files(study_file: StudyFile, command: Command) -> None:
    study_file(QUICK)
    older = Path("s/sweep_values.png")
    older.parent.mkdir()
    older.touch()
    command("sweep", "study.toml", "--set", "contact.gap=1e-3", "--output", "s")
    with Image.open("s/sweep.png") as picture:
        assert np.ptp(np.asarray(picture.convert("L"))) > 200
    assert Path("s/sweep.svg").read_text().startswith("<?xml")
    assert not older.exists()  # one value is no curve


def test_a_study_of_a_sweep_is_that_of_a_lone_run(study_file: StudyFile, command: Command) -> None:
    study_file(QUICK)
    command("sweep", "study.toml", "--set", "contact.gap=5e-4,1e-3", "--output", "s")
    alone = command("run", "study.toml", "--set", "contact.gap=5e-4", "--output", "alone")
    assert alone.code == 0
    plain = command("run", "study.toml", "--output", "plain")
    assert plain.code == 0
    for gap, other in (("0.0005", "alone"), ("0.001", "plain")):
        shared = Path("s", f"contact.gap={gap}", "backbone.csv").read_bytes()
        assert shared == Path(other, "backbone.csv").read_bytes()


def test_nothing_is_run_twice(study_file: StudyFile, command: Command) -> None:
    study_file(QUICK)
    command("sweep", "study.toml", "--set", "contact.gap=5e-4", "--output", "s")
    before = stamps(Path("s"))
    more = command("sweep", "study.toml", "--set", "contact.gap=5e-4,1e-3", "--output", "s")
    assert "2 studies: 1 done, 1 to run" in more.out
    after = stamps(Path("s"))
    assert len(after) == 2
    assert before.items() <= after.items()
    again = command("sweep", "study.toml", "--set", "contact.gap=5e-4,1e-3", "--output", "s")
    assert "2 done, 0 to run" in again.out
    assert stamps(Path("s")) == after


def test_another_study_is_not_taken_for_it(study_file: StudyFile, command: Command) -> None:
    study_file(QUICK)
    sweep = ("sweep", "study.toml", "--set", "contact.gap=5e-4", "--output", "s")
    command(*sweep)
    study_file(QUICK, material={"young": 2.0e11})
    command(*sweep).assert_one_line(
        2, "contact.gap=0.0005", "material.young was 210000000000.0", "another --output"
    )
    study_file(QUICK, continuation={"energies": {"from": 0.9, "to": 1.3, "step": 0.1}})
    ended = command(*sweep)
    assert ended.code == 0
    assert "1 to run, 1 of them from points of an earlier run" in ended.out
    assert rows(Path("s"))[0]["largest_gamma_ratio"] == "1.3"


def test_a_file_that_has_changed_is_told(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    chain = {"stiffness": 4.0}

    def write() -> None:
        K = 1e6 * np.array([[chain["stiffness"], -2.0], [-2.0, 2.0]])
        np.savez(tmp_path / "chain.npz", K=K, M=np.eye(2), B=np.eye(2)[1:])

    write()
    study_file(
        QUICK,
        mesh=None,
        body=None,
        material=None,
        clamp=None,
        matrices={"file": "chain.npz"},
        contact={"=": {"gap": 1e-3}},
        reduction={"modes": 1},
    )
    sweep = ("sweep", "study.toml", "--set", "contact.gap=1e-3,2e-3", "--output", "s")
    assert command(*sweep).code == 0
    chain["stiffness"] = 5.0
    write()
    command(*sweep).assert_one_line(2, "matrices.file", "has changed", "another --output")


def test_a_failure_does_not_stop_the_others(study_file: StudyFile, command: Command) -> None:
    study_file(QUICK)
    lists = ("--set", "contact.facets=right,nowhere", "--set", "mode.number=1,2")
    ended = command("sweep", "study.toml", *lists)
    assert ended.code == 1
    lines = ended.err.splitlines()
    assert len(lines) == 2
    assert all('contact.facets = "nowhere"' in line and "failed" in line for line in lines)
    table = rows(Path("results/study-sweep"))
    assert [row["status"] for row in table] == ["complete"] * 2 + ["failed"] * 2
    assert "nowhere" in table[2]["message"]
    assert table[2]["points"] == ""
    assert not Path("results/study-sweep", table[2]["folder"]).exists()


def test_an_interrupted_study_goes_on(
    study_file: StudyFile, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    study_file(QUICK)
    count = 0
    store = fenics_nnm.running.following.store

    def interrupt(points: Any, point: Any) -> None:
        nonlocal count
        store(points, point)
        count += 1
        if count == 6:
            raise KeyboardInterrupt

    sweep = ("sweep", "study.toml", "--set", "contact.gap=1e-3,2e-3,3e-3", "--output", "s")
    with monkeypatch.context() as patch:
        patch.setattr(fenics_nnm.running.following, "store", interrupt)
        stopped = command(*sweep)
    assert stopped.code == 1
    assert "interrupted" in stopped.err
    assert [row["status"] for row in rows(Path("s"))] == ["complete", "stopped", "not run"]
    before = stamps(Path("s/contact.gap=0.001"))
    assert command(*sweep).code == 0
    assert [row["status"] for row in rows(Path("s"))] == ["complete"] * 3
    assert stamps(Path("s/contact.gap=0.001")) == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--set", "contact.gapp=1e-3"], ["contact.gapp", 'did you mean "gap"']),
        (["--set", "contat.gap=1e-3"], ["contat", 'did you mean "contact"']),
        (["--set", "contact.gap=1e-3,wide"], ['contact.gap = "wide"', "must be a number"]),
        (["--set", "mode.number=1,2,3"], ["mode.number = 3", "reduction.modes = 2"]),
        (["--set", "mode.number=1.5"], ["mode.number = 1.5", "must be an integer"]),
        (["--set", "contact.gap=1e-3,0.001"], ["contact.gap = 0.001", "twice"]),
        (["--set", "contact.gap=1e-3", "--set", "contact.gap=2e-3"], ["is set twice"]),
        (["--set", "output.folder=a,b"], ["output.folder", "--output"]),
        (["--set", "contact.gap=1e-3", "--gamma", "1.15"], ["--gamma 1.15", "1.1 and 1.2"]),
        (["--set", "contact.gap=1e-3", "--amplitude", "2MPa"], ["--amplitude 2MPa", "unit"]),
        (
            ["--set", "continuation.report_at=[1.0]", "--stress", "1MPa"],
            ["1MPa", "--set continuation.report_at", "one place"],
        ),
        (["--set", "contact.gap=1e-3", "--jobs", "0"], ["--jobs 0", "at least 1"]),
        (["--set", "mesh.model=plate"], ["mesh.", "plate"]),
        ([], ["nothing to sweep", "--set"]),
        (
            ["--zip", "--set", "contact.gap=1,2", "--set", "mode.number=1"],
            ["--zip", "contact.gap has 2, mode.number has 1"],
        ),
    ],
)
def test_bad_input_is_told_before_anything_runs(
    study_file: StudyFile, command: Command, arguments: list[str], words: list[str]
) -> None:
    study_file(QUICK)
    command("sweep", "study.toml", *arguments).assert_one_line(2, *words)
    assert not Path("results").exists()


def test_a_folder_that_cannot_be_made_is_told(study_file: StudyFile, command: Command) -> None:
    study_file(QUICK)
    Path("file").touch()
    sweep = ("sweep", "study.toml", "--set", "contact.gap=1e-3", "--output", "file/s")
    command(*sweep).assert_one_line(2, "--output file/s", "cannot be written: Not a directory")


def test_lists_are_combined_or_taken_together(study_file: StudyFile) -> None:
    file = study_file(QUICK)
    lists = ["contact.gap=1e-3,2e-3", "mode.number=1,2"]

    def values(**options: Any) -> list[tuple[Any, ...]]:
        made = plan(file, Path("s"), lists, Backbones(), **options)
        assert made.keys == ("contact.gap", "mode.number")
        for case in made.cases:
            assert (case.study.contact.gap, case.study.mode.number) == tuple(
                setting.value for setting in case.settings
            )
        return [tuple(setting.value for setting in case.settings) for case in made.cases]

    assert values() == [(1e-3, 1), (1e-3, 2), (2e-3, 1), (2e-3, 2)]
    assert values(zipped=True) == [(1e-3, 1), (2e-3, 2)]


def test_a_table_gives_one_study_a_row(study_file: StudyFile, command: Command) -> None:
    study_file(QUICK)
    Path("runs.csv").write_text(
        "# of a colleague\ncontact.gap, mode.number, title\n1e-3, 1, soft\n\n2e-3, 2, 'two words'\n"
    )
    sweep = ("sweep", "study.toml", "--table", "runs.csv", "--output", "s")
    assert command(*sweep).code == 0
    table = rows(Path("s"))
    assert [(row["contact.gap"], row["mode.number"], row["title"]) for row in table] == [
        ("0.001", "1", "soft"),
        ("0.002", "2", "two words"),
    ]
    Path("runs.csv").write_text("contact.gap,mode.number\n1e-3\n")
    command(*sweep).assert_one_line(2, "runs.csv", "line 2", "must have 2")
    Path("runs.csv").write_text("contact.gap\n")
    command(*sweep).assert_one_line(2, "runs.csv", "must have a row of keys")
    command("sweep", "study.toml", "--table", "none.csv").assert_one_line(2, "none.csv", "No such")


def test_a_list_of_commands_does_the_same(study_file: StudyFile, command: Command) -> None:
    study_file(QUICK)
    sweep = ("sweep", "study.toml", "--set", "contact.gap=1e-3,2e-3", "--output", "a b")
    listed = command(*sweep, "--list")
    assert (listed.code, listed.err) == (0, "")
    commands = listed.out.splitlines()
    assert len(commands) == 2
    assert not Path("a b").exists()
    name, *words = shlex.split(commands[0])
    assert name == "fenics-nnm"
    assert command(*words).code == 0
    collected = command(*sweep, "--collect")
    assert collected.code == 1
    assert "contact.gap = 0.002: not run" in collected.err
    assert [row["status"] for row in rows(Path("a b"))] == ["complete", "not run"]
    again = command(*sweep, "--list")
    assert again.out.splitlines() == commands[1:]


def test_one_key_can_be_set_for_a_run(study_file: StudyFile, command: Command) -> None:
    study_file(QUICK)
    command("run", "study.toml", "--set", "contact.gap=1,2").assert_one_line(2, "fenics-nnm sweep")
    command("run", "study.toml", "--set", "contact.gapp=1").assert_one_line(2, "did you mean")
    assert command("run", "study.toml", "--set", "mode.number=2", "--output", "r").code == 0
    assert json.loads(Path("r/summary.json").read_text())["mode"] == 2
    text = fenics_nnm.results.branch_file.study_text(Path("r/branch.h5"))
    assert text.startswith("# study.toml with mode.number = 2\n")
    ended = command("run", "study.toml", "--resume", "--output", "r")
    ended.assert_one_line(2, "mode.number was 2 and is 1 now")
    checked = command("check", "study.toml", "--set", "contact.gap=0.005")
    assert "0.005" in checked.out


def test_processes_and_this_one_give_the_same_table(
    study_file: StudyFile, command: Command
) -> None:
    study_file(QUICK)
    lists = ("--set", "contact.facets=right,nowhere", "--gamma", "1.2")
    alone = command("sweep", "study.toml", *lists, "--output", "one")
    both = command("sweep", "study.toml", *lists, "--output", "two", "--jobs", "2")
    assert (alone.code, both.code) == (1, 1)
    assert sorted(alone.err.splitlines()) == sorted(both.err.splitlines())
    assert Path("one/sweep.csv").read_bytes() == Path("two/sweep.csv").read_bytes()


@pytest.mark.parametrize(
    ("code", "words"),
    [(-9, "ended by SIGKILL: out of memory?"), (-11, "ended by SIGSEGV"), (3, "exit code 3")],
)
def test_the_end_of_a_process_is_told(study_file: StudyFile, code: int, words: str) -> None:
    made = plan(study_file(QUICK), Path("s"), ["contact.gap=1e-3"], Backbones())
    ours, theirs = Pipe()
    theirs.close()
    process: Any = SimpleNamespace(exitcode=code, join=lambda: None)
    hand = Hand([made.cases], LocalCounters([0]), 0)
    ran = _received(Worker(WorkerProcess(process, ours), hand, made.cases[0]))
    assert ran.number == 1
    assert words in ran.failure


def test_ranks_and_this_process_give_the_same_table(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    study_file(QUICK)
    lists = ("--set", "contact.facets=right,nowhere", "--set", "mode.number=1,2")
    alone = command("sweep", "study.toml", *lists, "--output", "one")
    words = ("-m", "fenics_nnm", "sweep", "study.toml", *lists, "--output", "two")
    ranks = on_ranks(2, *words, folder=tmp_path)
    assert (alone.code, ranks.code) == (1, 1), ranks.err
    assert own_lines(ranks) == alone.err.splitlines()
    assert ranks.out.count("4 studies: 0 done, 4 to run") == 1
    assert Path("one/sweep.csv").read_bytes() == Path("two/sweep.csv").read_bytes()


def test_a_worker_keeps_to_the_structure_that_it_holds(study_file: StudyFile) -> None:
    file = study_file(PLATE)
    made = plan(
        file,
        Path("s"),
        ["contact.gap=1e-3,2e-3,3e-3", "mesh.height=0.2,0.3", "mode.number=1,2"],
        Backbones(),
    )
    groups = grouped(made.cases)
    assert [len(group) for group in groups] == [6, 6]
    counters = LocalCounters([0, 0])
    hands = [Hand(groups, counters, 0), Hand(groups, counters, 1)]
    heights = [set(), set()]  # type: list[set[object]]
    seen = []
    for turn in range(12):
        case = hands[turn % 2].take()
        assert case is not None
        seen.append(case.number)
        heights[turn % 2].add(dict((s.key, s.value) for s in case.settings)["mesh.height"])
    assert sorted(seen) == list(range(1, 13))
    assert heights == [{0.2}, {0.3}]
    assert hands[0].take() is None


def test_a_worker_without_its_own_group_helps_another(study_file: StudyFile) -> None:
    made = plan(
        study_file(PLATE), Path("s"), ["contact.gap=1,2,3,4", "mesh.height=0.2"], Backbones()
    )
    groups = grouped(made.cases)
    counters = LocalCounters([0])
    hands = [Hand(groups, counters, 0), Hand(groups, counters, 0)]
    taken = [hand.take() for _ in range(3) for hand in hands]
    assert [case.number for case in taken if case] == [1, 2, 3, 4]


def test_casings_that_only_give_gaps_are_grouped(study_file: StudyFile) -> None:
    casing = {"shape": "plane", "origin": [0.0, 1.0], "normal": [0.0, 1.0]}
    contact = {"facets": "right", "direction": [0.0, 1.0], "casing": casing}
    file = study_file(PLATE, contact={"=": contact})
    made = plan(
        file, Path("s"), ["contact.casing.clearance=0.1,0.2", "contact.points=1,2"], Backbones()
    )
    assert [[case.number for case in group] for group in grouped(made.cases)] == [[1, 3], [2, 4]]


@pytest.mark.parametrize(
    ("settings", "name"),
    [
        ([("mode.number", 2), ("contact.gap", 1e-4)], "contact.gap=0.0001_mode.number=2"),
        ([("reduction.method", "massless")], "reduction.method=massless"),
    ],
)
def test_names_of_folders(settings: list[tuple[str, Any]], name: str) -> None:
    made = tuple(Setting(*each) for each in settings)
    assert folder_name(made) == name
    assert folder_name(made[::-1]) == name


def test_names_of_folders_differ_and_are_names() -> None:
    values = ["a/b", "a-b", "a b", "1", 1, "true", True, "x" * 300, "x" * 301, [1.0], [1.0, 2.0]]
    names = [folder_name((Setting("title", value),)) for value in values]
    assert len(set(names)) == len(values)
    assert all("/" not in name and len(name) < 120 for name in names)


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("contact.gap", "m"),
        ("material.young", "Pa"),
        ("material.density", "kg/m^3"),
        ("body.thickness", "m"),
        ("mesh.height", "mm"),
        ("mass.mass", "kg"),
        ("mass[1].mass", "kg"),
        ("continuation.energies.to", ""),
        ("mode.number", ""),
        ("groups.tip.z", "m"),
        ("material.poisson", ""),
    ],
)
def test_units(key: str, unit: str) -> None:
    values = changed(
        PLATE,
        {
            "mesh": {"length_unit": "mm"},
            "mass": {"facets": ["right"], "mass": 2.0},
            "groups": {"tip": {"z": 1.0}},
        },
    )
    assert unit_of(study_from(values, Path("study.toml")), key) == unit


def test_lengths_of_a_table_are_in_m_however_they_are_given(
    study_file: StudyFile, command: Command
) -> None:
    study_file(QUICK, length_unit="mm", mesh={"length_unit": "m"})
    values = "1 mm, 2, 3e3 um"
    given = ["--set", f"contact.gap={values}", "--gamma", "1.1", "--output", "s"]
    assert command("sweep", "study.toml", *given).code == 0
    table = rows(Path("s"))
    assert [row["contact.gap"] for row in table] == ["0.001", "0.002", "0.003"]
    energies = [float(row["energy_J_at_1.1"]) for row in table]
    assert energies == pytest.approx([energies[0] * n**2 for n in (1, 2, 3)], rel=1e-9)
    found = variations(plan(Path("study.toml"), Path("s"), [f"contact.gap={values}"], Backbones()))
    assert [(each.label, each.values) for each in found] == [
        ("contact.gap (m)", (1e-3, 2e-3, 3e-3))
    ]


def test_a_study_that_runs_elsewhere_is_left_alone(study_file: StudyFile, command: Command) -> None:
    study_file(QUICK)
    staging = claim(Path("s/contact.gap=0.001"))
    try:
        ended = command("sweep", "study.toml", "--set", "contact.gap=1e-3", "--output", "s")
    finally:
        staging.release()
    assert ended.code == 1
    assert "of a run that is going on" in ended.err
    assert rows(Path("s"))[0]["status"] == "failed"
