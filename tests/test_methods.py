"""Methods chosen in the study file: what they give together, and which do not go together."""

from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import PLATE, Ended

from fenics_nnm.output import branch_file

Command = Callable[..., Ended]
StudyFile = Callable[..., Path]

CRAIG_BAMPTON = {"method": "craig-bampton", "modes": 4}


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
            "contact points that carry mass",
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


def test_general_series_gives_the_same_table_and_motion(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    frequencies, pictures = [], []
    for series in ("time-reversible", "general"):
        study = study_file(PLATE, mode={"series": series})
        ended = command("run", study, "--output", str(tmp_path / series))
        assert ended.code == 0, ended.err
        _, points = branch_file.read(tmp_path / series / "branch.h5")
        frequencies.append([point.frequency for point in points])
        frame = tmp_path / series / "fields" / "motion_1.1" / "frame_p0_000005.vtu"
        root = ElementTree.parse(frame).getroot()
        text = next(
            a.text for a in root.iter("DataArray") if a.attrib.get("Name") == "displacement (m)"
        )
        pictures.append(np.array((text or "").split(), dtype=float))
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
    assert points[-1].force.max() > 0
    assert points[-1].frequency_ratio > 1.001
    assert (tmp_path / "out" / "fields" / "motion_1.1.pvd").is_file()
