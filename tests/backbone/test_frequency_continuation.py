"""Continuation in frequency, and what a branch is told to meet on its way."""

from __future__ import annotations

import importlib
import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, Ended
from mpi4py import MPI

from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.follow import EnergyContinuation, FrequencyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.outlook import Outlook, outlook
from fenics_nnm.backbone.resonance import Meeting, passing
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.augmented_lagrangian import MultiplierLoop
from fenics_nnm.output.description import near_energy
from fenics_nnm.output.html_report.words import warnings
from fenics_nnm.output.pictures.backbone import frequency_plots
from fenics_nnm.output.pictures.results import read_results
from fenics_nnm.results import branch_file
from fenics_nnm.structure.analysis import linear_analysis, nonlinear_mode
from fenics_nnm.study import study_from

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

DEMOS = Path(__file__).parents[2] / "demos"
SWEEP = {"parameter": "frequency", "frequencies": {"from": 1.01, "to": 1.05, "step": 0.02}}
BY_FREQUENCY = {"continuation": {"=": SWEEP}}


def bilinear(monkeypatch: pytest.MonkeyPatch) -> tuple[ReducedModel, Any]:
    monkeypatch.syspath_prepend(DEMOS / "bilinear")
    demo = importlib.import_module("bilinear")
    omega = np.sqrt(demo.SPRING / demo.MASS)
    return ReducedModel([omega], [[demo.MASS**-0.5]], [[1 / demo.STOP]], [demo.GAP]), demo


def test_bilinear_oscillator(monkeypatch: pytest.MonkeyPatch) -> None:
    """Frequencies as asked for, of the energies of the closed form, and an energy to report."""
    model, demo = bilinear(monkeypatch)
    wanted = FrequencyContinuation(1.01, 1.3, 0.05, report_at=(1.5,))
    branch = follow(model, wanted, HarmonicBalance(21, 512), mode=0)
    linear = model.omega[0] / (2 * np.pi)
    assert branch.complete
    assert branch.reason == "reached frequency ratio 1.3"
    swept = [point for point in branch.points if point.gamma_ratio != 1.5]
    expected = wanted.targets()
    np.testing.assert_allclose([p.motion.frequency / linear for p in swept], expected, rtol=1e-12)
    assert len(branch.points) == len(swept) + 1
    for point in branch.points:
        assert point.position == pytest.approx(point.frequency_ratio, rel=1e-9)
        assert point.motion.frequency == pytest.approx(
            demo.exact_frequency(point.motion.energy), rel=5e-6
        )


def test_frequency_that_contact_cannot_give(monkeypatch: pytest.MonkeyPatch) -> None:
    """The zero-gap limit of the bilinear oscillator is 2 / (1 + (1 + K / k)^-1/2) = 1.42."""
    model, demo = bilinear(monkeypatch)
    limit = 2 / (1 + (1 + demo.STOP / demo.SPRING) ** -0.5)
    wanted = FrequencyContinuation(1.3, 1.05 * limit, 0.1)
    branch = follow(model, wanted, HarmonicBalance(5, 64), mode=0)
    assert not branch.complete
    assert branch.points[-1].frequency_ratio < limit
    assert "the followed mode alone has no motion of this frequency" in branch.reason


def test_mode_above_another_one_is_followed_by_frequency() -> None:
    """Mode 2 of a rod: alone, with mode 1 static, it has far larger energies, or none."""
    omega = (np.arange(8) + 0.5) * np.pi * (1 + 1e-5 * np.arange(8) ** 2)
    Phi = np.sqrt(2) * (-1.0) ** np.arange(8)
    model = ReducedModel(omega, Phi[None, :], [[1 - np.sum(Phi**2 / omega**2)]], [1.0])
    balance = HarmonicBalance(8, 64)
    branch = follow(model, FrequencyContinuation(1.005, 1.045, 0.01), balance, mode=1)
    assert branch.complete, branch.reason
    assert len(branch.points) >= 5
    for point in branch.points[1:3]:
        at = EnergyContinuation(point.gamma_ratio, point.gamma_ratio * 1.001, 1.0)
        again = follow(model, at, balance, mode=1).points[0]
        assert again.frequency_ratio == pytest.approx(point.frequency_ratio, rel=1e-6)


def rod(**continuation: Any) -> Branch:
    values = tomllib.loads((DEMOS / "rod" / "fine.toml").read_text())
    values["mesh"]["elements"] = 50
    values["reduction"]["modes"] = 30
    values["continuation"] = continuation
    study = study_from(values, DEMOS / "rod" / "fine.toml")
    return nonlinear_mode(study, linear_analysis(study, MPI.COMM_SELF))


def test_rod_is_swept_across_its_resonances(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DEMOS / "rod")
    exact_rod = importlib.import_module("exact_rod")
    branch = rod(
        parameter="frequency",
        frequencies={"from": 1.02, "to": 1.19, "step": 0.01},
        shooting=False,
    )
    assert branch.complete
    exact = exact_rod.frequency_ratio(np.array([point.gamma_ratio for point in branch.points]))
    errors = np.abs([point.frequency_ratio for point in branch.points] / exact - 1)
    unmarked = np.array([not point.resonance for point in branch.points])
    assert errors[unmarked].max() < 6e-3
    assert np.median(errors[unmarked]) < 2e-3


def test_resonances_of_the_rod_are_told_ahead() -> None:
    """All frequencies are odd multiples of the first: harmonic n meets mode j at (2 j - 1) / n."""
    values = tomllib.loads((DEMOS / "rod" / "fine.toml").read_text())
    study = study_from(values, DEMOS / "rod" / "fine.toml")
    model = linear_analysis(study, MPI.COMM_SELF).model
    ahead = outlook(model, EnergyContinuation(0.7, 4.0, 0.1), HarmonicBalance(20, 128), mode=0)
    found = {(m.mode + 1, m.harmonic): (m.ratio, m.gamma_ratio) for m in ahead.meetings}
    for mode, harmonic in ((2, 3), (5, 8), (4, 6)):
        assert found[mode, harmonic][0] == pytest.approx((2 * mode - 1) / harmonic, rel=1e-3)
    assert (1, 1) not in found
    assert (3, 2) not in found
    ratios = [meeting.ratio for meeting in ahead.meetings]
    assert ratios == sorted(ratios)
    backbone = rod(energies={"from": 2.0, "to": 2.4, "step": 0.2}, shooting=False)
    near = found[5, 8][1]
    frequencies = {point.gamma_ratio: point.frequency_ratio for point in backbone.points}
    assert min(frequencies) < near < max(frequencies)


def test_skipped_resonance_is_named() -> None:
    """At 1.05 the mixture of modes 1 and 2 hides the branch, at 1.35 mode 11 in harmonic 20."""
    branch = rod(energies={"from": 1.05, "to": 1.35, "step": 0.3}, shooting=False)
    skipped = {e.name: e for e in branch.encounters if e.skipped}
    assert skipped["mode 2 in harmonic 3"].skipped == (1.05,)
    for name, encounter in skipped.items():
        mode, harmonic = (int(word) for word in name.split() if word.isdigit())
        meeting = (2 * mode - 1) / harmonic * 1297.19
        assert encounter.frequency == pytest.approx(meeting, rel=0.05)


def test_study_by_frequency(study_file: StudyFile, command: Command) -> None:
    path = study_file(base=PLATE, **BY_FREQUENCY)
    assert command("run", path, "--output", "out").code == 0
    points = branch_file.read(Path("out/branch.h5"))[1]
    assert [p.frequency_ratio for p in points] == pytest.approx([1.01, 1.03, 1.05])
    wider = study_file(
        base=PLATE,
        continuation={"=": {**SWEEP, "frequencies": {"from": 1.01, "to": 1.07, "step": 0.02}}},
    )
    assert command("run", wider, "--output", "out", "--resume").code == 0
    again = branch_file.read(Path("out/branch.h5"))[1]
    assert [p.frequency_ratio for p in again] == pytest.approx([1.01, 1.03, 1.05, 1.07])
    other = study_file(base=PLATE)
    ended = command("run", other, "--output", "out", "--resume")
    ended.assert_one_line(2, 'continuation.parameter was "frequency" and is "energy" now')


def test_missing_frequency_is_told_as_one(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """Contact stiffens a structure by a bounded factor; the linear rod of zero gap reaches 4/3."""
    sweep = {"=": {**SWEEP, "frequencies": {"from": 1.3, "to": 2.5, "step": 1.2}}}
    assert command("run", study_file(continuation=sweep), "--output", "out").code == 1
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert [set(each) for each in summary["failures"]] == [{"frequency_ratio", "reason"}]
    assert summary["failures"][0]["frequency_ratio"] == 2.5
    results = read_results(tmp_path / "out")
    assert any(told.startswith("At frequency ratio 2.5 no motion") for told in warnings(results))
    axes = frequency_plots(results)[0].figure.axes[0]
    (line,) = (line for line in axes.lines if line.get_label() == "no point found")
    np.testing.assert_allclose(line.get_ydata(), 2.5 * results.linear_frequency)


@pytest.mark.parametrize(
    ("continuation", "words"),
    [
        (
            {"parameter": "frequency"},
            ['parameter = "frequency" needs frequencies (range { from, to, step }'],
        ),
        ({**SWEEP, "energies": {"to": 2.0}}, ["energies: does not go with"]),
        ({"frequencies": SWEEP["frequencies"]}, ['frequencies: needs parameter = "frequency"']),
        ({**SWEEP, "frequencies": {"from": 0.9, "to": 1.2}}, ["frequencies.from = 0.9", "1"]),
        ({**SWEEP, "frequencies": {"from": 1.2, "to": 1.1}}, ["from must be below to"]),
        ({"parameter": "time"}, ["continuation.parameter", '"frequency"']),
    ],
)
def test_choices_that_do_not_fit(
    continuation: dict[str, Any], words: list[str], study_file: StudyFile, command: Command
) -> None:
    path = study_file(continuation={"=": continuation})
    command("run", path).assert_one_line(2, "continuation", *words)


def test_multipliers_are_found_at_fixed_energy(study_file: StudyFile, command: Command) -> None:
    path = study_file(base=PLATE, reduction={"method": "craig-bampton", "modes": 4}, **BY_FREQUENCY)
    command("run", path).assert_one_line(
        2, "by frequency needs contact points without mass", '"energy"'
    )
    model = ReducedModel([1.0, 3.0], [[1.0, 1.0]], [[0.0]], [1.0], contact=MASSIVE)
    balance = HarmonicBalance(3, 32, multipliers=MultiplierLoop())
    with pytest.raises(ModelError, match="needs contact points without mass"):
        follow(model, FrequencyContinuation(1.01, 1.1, 0.05), balance, mode=0)


def test_outlook_in_check(study_file: StudyFile, command: Command) -> None:
    mesh = {"model": "rod", "length_unit": "m", "length": 1.0, "elements": 20}
    path = study_file(mesh={"=": mesh}, body={"degree": 2})
    told = command("check", path).out
    assert "internal resonances on the way" in told
    line = next(line for line in told.splitlines() if line.split()[:2] == ["2", "3"])
    assert float(line.split()[2]) == pytest.approx(1.0, abs=1e-3)
    coarse = command("check", study_file()).out
    assert "no harmonic meets a mode on the way" in coarse


def test_meetings_that_the_branch_does_not_come_to_are_beyond_its_end() -> None:
    ahead = Outlook(np.array([1.0, 2.0]), np.array([1.0, 1.02]), ())
    asked = (0.99, 1.01, 1.02, 1.03)
    at = [passing(ratio, ahead.gamma_ratio, ahead.frequency_ratio) for ratio in asked]
    found = [near_energy(Meeting(1, 2, *each), ahead) for each in zip(asked, at, strict=True)]
    assert found == ["below first contact", "1.5", "2", "beyond 2"]
