"""Methods chosen in the study file: what they give together, and which do not go together."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, Ended
from written_fields import arrays_of

from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.results import branch_file

Command = Callable[..., Ended]
StudyFile = Callable[..., Path]

CRAIG_BAMPTON = {"method": "craig-bampton", "modes": 4}
FULL_ORDER = {"method": "none", "modes": 4}


@pytest.mark.parametrize(
    ("changes", "named", "right"),
    [
        (
            {"reduction": CRAIG_BAMPTON, "contact": {"law": "complementarity"}},
            'contact.law = "complementarity"',
            'must be "augmented-lagrangian"',
        ),
        (
            {"contact": {"law": "augmented-lagrangian"}},
            'contact.law = "augmented-lagrangian"',
            'reduction.method = "craig-bampton"',
        ),
        (
            {"augmented_lagrangian": {"penalty": 5.0}},
            'contact.law = "augmented-lagrangian"',
            "points that carry mass",
        ),
        (
            {"reduction": FULL_ORDER, "augmented_lagrangian": {"penalty": 5.0}},
            'contact.law = "augmented-lagrangian"',
            "points that carry mass",
        ),
        (
            {
                "reduction": FULL_ORDER,
                "contact": {"law": "augmented-lagrangian"},
                "augmented_lagrangian": {"normalisation": "penalised"},
            },
            'normalisation = "penalised"',
            'must be "exact"',
        ),
        (
            {"reduction": {**FULL_ORDER, "interface": "contact"}},
            "interface",
            'method = "craig-bampton"',
        ),
        ({"reduction": {"interface": "all"}}, "interface", 'method = "craig-bampton"'),
        (
            {"reduction": CRAIG_BAMPTON, "augmented_lagrangian": {"algorithm": "sequential"}},
            "algorithm",
            'normalisation = "penalised"',
        ),
        (
            {"reduction": CRAIG_BAMPTON, "augmented_lagrangian": {"alpha": 1.0}},
            "augmented_lagrangian.alpha = 1.0",
            "above 1",
        ),
        ({"reduction": {"method": "guyan"}}, 'reduction.method = "guyan"', "craig-bampton"),
    ],
)
def test_choices_that_do_not_go_together(
    changes: dict[str, Any], named: str, right: str, study_file: StudyFile, command: Command
) -> None:
    command("check", study_file(**changes)).assert_one_line(2, named, right)


def displacements(folder: Path, frame: int) -> np.ndarray:
    """Displacement at all nodes in one frame of a written motion."""
    return arrays_of(folder / f"frame_{frame:04d}.vtu")["displacement (m)"]


def test_general_series_gives_the_same_table_and_motion(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    frequencies, pictures = [], []
    for series in ("time-reversible", "general"):
        study = study_file(PLATE, mode={"series": series})
        ended = command("run", study, "--output", str(tmp_path / series))
        assert ended.code == 0, ended.err
        _, points = branch_file.read(tmp_path / series / "branch.h5")
        frequencies.append([point.motion.frequency for point in points])
        frame = tmp_path / series / "fields" / "motion_1.1"
        pictures.append(displacements(frame, 5))
    assert frequencies[1] == pytest.approx(frequencies[0], rel=1e-8)
    np.testing.assert_allclose(pictures[1], pictures[0], atol=1e-8 * np.abs(pictures[0]).max())


def test_craig_bampton_study_from_file_to_motion(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    study = study_file(
        PLATE,
        reduction=CRAIG_BAMPTON,
        augmented_lagrangian={"normalisation": "penalised"},
        continuation={"report_at": [1.1]},
    )
    ended = command("run", study, "--output", str(tmp_path / "out"))
    assert ended.code == 0, ended.err
    header, points = branch_file.read(tmp_path / "out" / "branch.h5")
    assert not header.model.R.any()
    assert header.model.modes == 4 + 2 * 2
    assert points[-1].motion.force.max() > 0
    assert points[-1].frequency_ratio > 1.001
    assert (tmp_path / "out" / "fields" / "motion_1.1.pvd").is_file()


def last_point_and_frame(folder: Path) -> tuple[BranchPoint, np.ndarray]:
    points = branch_file.read(folder / "branch.h5")[1]
    return points[-1], displacements(folder / "fields" / "motion_1.1", 1)


def test_full_order_study_from_file_to_motion(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """Near the massless model of as many modes, and nearer the more there are."""
    apart = []
    for modes in (4, 12):
        found = []
        for method in ("massless", "none"):
            study = study_file(PLATE, reduction={"method": method, "modes": modes})
            folder = tmp_path / f"{method}-{modes}"
            assert command("run", study, "--output", str(folder)).code == 0
            found.append(last_point_and_frame(folder))
        (reduced, frame), (full, full_frame) = found
        assert reduced.expected.reduction.frequency == pytest.approx(
            reduced.motion.frequency / full.motion.frequency - 1, rel=0.2
        )
        assert (full.expected.reduction.frequency, full.expected.reduction.residual) == (0, 0)
        assert full.status == reduced.status
        apart.append(np.abs(frame - full_frame).max() / np.abs(frame).max())
    assert apart[1] < apart[0] / 4 < 0.01


def test_full_order_with_mass_at_the_contact_points(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """The same motion, whatever the number of modes that stay explicit."""
    found = []
    for modes in (2, 6):
        study = study_file(
            PLATE,
            reduction={"method": "none", "modes": modes},
            contact={"law": "augmented-lagrangian"},
        )
        folder = tmp_path / str(modes)
        assert command("run", study, "--output", str(folder)).code == 0
        assert not branch_file.read(folder / "branch.h5")[0].model.R.any()
        found.append(last_point_and_frame(folder))
    (few, frame), (many, same_frame) = found
    assert few.frequency_ratio > 1.001
    assert few.motion.frequency == pytest.approx(many.motion.frequency, rel=1e-9)
    assert few.status == "converged"
    assert "carry mass" in few.reason
    np.testing.assert_allclose(frame, same_frame, atol=1e-7 * np.abs(frame).max())


def test_craig_bampton_finds_motions_through_nearby_frequencies(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """The levels below the finest have fewer modes than it."""
    study = study_file(
        mesh={"elements": 3},
        body={"degree": 2},
        reduction={"method": "craig-bampton", "modes": 4},
        mode={"harmonics": 5},
        continuation={"energies": {"to": 1.5}, "report_at": []},
    )
    ended = command("run", study, "--output", str(tmp_path / "out"))
    assert "defect" not in ended.err
    assert branch_file.read(tmp_path / "out" / "branch.h5")[1][-1].gamma_ratio > 1.4
