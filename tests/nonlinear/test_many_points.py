"""Many contact points at once: both methods, smooth pressure, and the exact rod in the plane."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpi4py import MPI

from fenics_nnm.backbone.follow import Branch
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.structure.analysis import harmonic_balance, linear_analysis, nonlinear_mode
from fenics_nnm.study import Study, read_study, study_from

DEMOS = Path(__file__).parents[2] / "demos"


@pytest.fixture(scope="module", autouse=True)
def demo_modules() -> Iterator[None]:
    """Let the tests import what the demos have beside them."""
    folders = [str(DEMOS / "plate"), str(DEMOS / "rod")]
    sys.path[:0] = folders
    yield
    for folder in folders:
        sys.path.remove(folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("dumbbell")


def changed(study: Study, section: str, **keys: Any) -> Study:
    return study.model_copy(update={section: getattr(study, section).model_copy(update=keys)})


def dumbbell(folder: Path, name: str = "plate", **mesh: Any) -> Study:
    """A study of the demo on a mesh of its own, coarser in time."""
    from dumbbell import write_mesh

    path = folder / f"{'_'.join(str(value) for value in mesh.values())}.msh"
    write_mesh(path, **mesh)
    study = changed(read_study(DEMOS / "plate" / f"{name}.toml"), "mesh", file=path)
    study = changed(changed(study, "mode", harmonics=5), "reduction", modes=20)
    energies = study.continuation.energies.model_copy(update={"start": 0.8, "step": 0.3})
    return changed(study, "continuation", energies=energies, report_at=(1.5, 2.0))


@pytest.fixture(scope="module")
def runs(folder: Path) -> dict[str, tuple[Study, LinearAnalysis, Branch]]:
    """Both methods on 33 points."""
    found = {}
    for name in ("plate", "craig_bampton"):
        study = dumbbell(folder, name, intervals=32)
        analysis = linear_analysis(study, MPI.COMM_SELF)
        branch = nonlinear_mode(study, analysis)
        assert branch.complete
        found[name] = (study, analysis, branch)
    return found


def pressed(study: Study) -> tuple[float, float, float]:
    """Oscillation and corner jump of the static pressure, and the jump if areas are ignored."""
    from pressure import ContactLine, corner_jump, zigzag

    analysis = linear_analysis(study, MPI.COMM_SELF)
    line = ContactLine.of(analysis.interface)
    pressure = line.pressed(analysis.model)
    force = pressure * line.areas
    oscillation = zigzag(line.y, pressure) / pressure.mean()
    jump = corner_jump(line.y, pressure) / pressure.mean()
    return oscillation, jump, corner_jump(line.y, force) / force.mean()


def test_zigzag_is_the_amplitude_of_an_alternating_pressure() -> None:
    from pressure import corner_jump, zigzag

    y = np.cumsum(np.random.default_rng(3).uniform(0.5, 2.0, size=20))
    alternating = 0.1 * (-1.0) ** np.arange(20)
    assert zigzag(y, 3 - y / 10 + alternating) == pytest.approx(0.1)
    assert zigzag(y, 9 + y - y**2 / 40) < 1e-12
    assert zigzag(y, np.where(y > y[8], 1 + y, 0)) < 1e-12
    assert corner_jump(y, 2 + y) < 1e-12
    assert corner_jump(y, np.where(y == y[-1], 0.5, 1.0)) == pytest.approx(0.5)


def test_thirty_points_touch_at_once(
    runs: dict[str, tuple[Study, LinearAnalysis, Branch]],
) -> None:
    for _, analysis, branch in runs.values():
        assert analysis.interface.count == 33
        assert (branch.points[-1].motion.force > 0).sum(axis=1).max() >= 30


def test_methods_agree(runs: dict[str, tuple[Study, LinearAnalysis, Branch]]) -> None:
    massless, craig_bampton = (
        {p.gamma_ratio: p.frequency_ratio for p in branch.points} for _, _, branch in runs.values()
    )
    common = sorted(massless.keys() & craig_bampton.keys())
    assert len(common) >= 5
    apart = [abs(craig_bampton[ratio] / massless[ratio] - 1) for ratio in common]
    assert max(apart) < 4e-3
    assert massless[2.0] > 1.04
    assert {point.status for point in runs["plate"][2].points} <= {"verified", "converged"}


def test_pressure_of_both_methods_is_smooth(
    runs: dict[str, tuple[Study, LinearAnalysis, Branch]],
) -> None:
    from pressure import ContactLine, corner_jump, zigzag

    means = []
    for name, (study, analysis, branch) in runs.items():
        line, series = ContactLine.of(analysis.interface), harmonic_balance(study).series
        point = branch.points[-1]
        acting = line.acting(point, series, np.linspace(0, 0.2, 9))
        peak = acting.mean(1).max()
        assert max(zigzag(line.y, p) for p in acting) < 0.01 * peak
        assert max(corner_jump(line.y, p) for p in acting) < 0.06 * peak
        if name == "plate":
            samples = line.at_samples(point)
            assert max(zigzag(line.y, p) for p in samples) < 1e-3 * samples.mean(1).max()
        means.append(line.mean(point, series))
    difference = np.abs(means[1] - means[0]).max() / means[0].mean()
    assert difference < 0.1


@pytest.mark.parametrize("bump", [1.0, 0.2, 5.0])
@pytest.mark.parametrize("cells", ["quad", "triangle"])
def test_linear_elements_press_smoothly_on_any_spacing(
    folder: Path, cells: str, bump: float
) -> None:
    study = changed(dumbbell(folder, cells=cells, bump=bump), "reduction", modes=5)
    oscillation, jump, without_areas = pressed(study)
    assert oscillation < 2e-3
    assert jump < 0.06
    assert without_areas > 0.12


def test_vertices_of_quadratic_elements_do_not_press_smoothly(folder: Path) -> None:
    # a limit of contact points at the vertices alone: the measures see it
    study = changed(dumbbell(folder, cells="triangle"), "reduction", modes=5)
    assert pressed(changed(study, "body", degree=2))[0] > 0.01
    study = changed(dumbbell(folder, cells="quad"), "reduction", modes=5)
    assert pressed(changed(study, "body", degree=2))[1] > 0.1


@pytest.mark.parametrize("cells", ["quad", "triangle"])
def test_averaged_rows_of_quadratic_elements_press_smoothly(folder: Path, cells: str) -> None:
    study = changed(dumbbell(folder, cells=cells), "reduction", modes=5)
    study = changed(changed(study, "body", degree=2), "contact", rows="averaged")
    oscillation, jump, _ = pressed(study)
    assert oscillation < 1e-3
    assert jump < 4e-3


def test_plate_without_lateral_contraction_moves_as_the_exact_rod() -> None:
    from exact_rod import frequency_ratio

    mesh = {"model": "plate", "length": 1.0, "height": 0.06, "elements": [160, 30]}
    rod = {
        "mesh": {"length_unit": "m", **mesh},
        "body": {"theory": "plane-stress", "thickness": 0.01, "degree": 1},
        "material": {"young": 2.1e11, "density": 7800.0},
        "clamp": {"facets": "left"},
        "contact": {"facets": "right", "direction": [1.0, 0.0], "gap": 1e-3},
        "reduction": {"modes": 24},
        "mode": {"number": 4, "harmonics": 10},
        "continuation": {"energies": {"from": 1.2, "to": 1.8, "step": 0.2}},
    }
    study = study_from(rod, Path("study.toml"))
    analysis = linear_analysis(study, MPI.COMM_SELF)
    assert analysis.modes.frequencies[3] == pytest.approx(np.sqrt(2.1e11 / 7800) / 4, rel=1e-4)
    branch = nonlinear_mode(study, analysis)
    assert branch.complete
    for point in branch.points:
        exact = float(frequency_ratio(point.gamma_ratio))
        assert point.frequency_ratio == pytest.approx(exact, rel=5e-3)
        pressure = point.motion.force / analysis.interface.areas
        assert (pressure > 0).sum(axis=1).max() == 31
        assert np.ptp(pressure, axis=1).max() < 1e-6 * pressure.max()
