"""A few of the random studies; `tests/random_studies.py` runs as many as are wanted."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from random_studies import write_study
from study_outcome import Examiner


@pytest.fixture(scope="module")
def examiner() -> Iterator[Examiner]:
    with Examiner(seconds=60) as running:
        yield running


#: Rods, plates, beams, matrices; all methods and ways along a branch; refusals; quick ones.
NUMBERS = (0, 1, 4, 9, 13, 17, 18, 23, 28, 37, 97, 121, 129, 162)


@pytest.mark.parametrize("number", NUMBERS)
def test_random_study(number: int, examiner: Examiner, tmp_path: Path) -> None:
    """It ends with a branch, or a reason, and integration in time agrees where it is trusted."""
    outcome = examiner.outcome(write_study(number, tmp_path))
    assert not outcome.faulty, outcome
    assert outcome.seconds < 60
