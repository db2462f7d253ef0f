"""What is asked of a continuation: certain points, range of energies, points to take over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np
import pytest

from fenics_nnm.backbone.follow import (
    ArcContinuation,
    EnergyContinuation,
    FrequencyContinuation,
    Wanted,
)
from fenics_nnm.backbone.outlook import Outlook
from fenics_nnm.backbone.point import BranchPoint

ENERGIES = EnergyContinuation(0.8, 2.0, 0.4, report_at=(1.5,))
FREQUENCIES = FrequencyContinuation(1.1, 1.3, 0.1, report_at=(1.5,))
LOWER = FrequencyContinuation(0.8, 0.9, 0.1)
ARC = ArcContinuation(0.8, 2.0, report_at=(1.5,))


@dataclass(frozen=True)
class Stored:
    position: float
    gamma_ratio: float


def positions(wanted: Wanted, stored: list[Stored]) -> list[float]:
    kept = wanted.still_wanted(cast(list[BranchPoint], stored))
    return [point.position for point in kept]


def line(slope: float) -> Callable[[], Outlook]:
    """A branch whose frequency ratio is 1 + slope (gamma ratio - 1)."""
    gamma = np.array([1.0, 2.0, 5.0])
    return lambda: Outlook(gamma, 1 + slope * (gamma - 1), ())


def nothing() -> Outlook:
    raise AssertionError("was looked ahead")


def test_gamma_ratios_that_have_a_point_for_certain() -> None:
    assert list(ENERGIES.certain_ratios) == pytest.approx([0.8, 1.2, 1.5, 1.6, 2.0])
    assert list(FREQUENCIES.certain_ratios) == [1.5]
    assert list(ARC.certain_ratios) == [1.5]


def test_energies_at_the_ends() -> None:
    assert ENERGIES.span(nothing) == (0.8, 2.0)
    assert ARC.span(nothing) == (0.8, 2.0)
    assert FREQUENCIES.span(line(0.1)) == pytest.approx((2.0, 4.0))
    assert LOWER.span(line(-0.1)) == pytest.approx((2.0, 3.0))
    assert np.isnan(FREQUENCIES.span(line(-0.1))).all()


def test_how_far_an_outlook_goes() -> None:
    assert ENERGIES.largest_ratio == ARC.largest_ratio == 2.0
    assert ENERGIES.lies_ahead(9.0) and ARC.lies_ahead(9.0)
    assert FREQUENCIES.lies_ahead(1.29) and not FREQUENCIES.lies_ahead(1.3)
    assert LOWER.lies_ahead(0.81) and not LOWER.lies_ahead(0.8)


def test_points_of_an_earlier_run_that_are_wanted_again() -> None:
    by_energy = [Stored(ratio, ratio) for ratio in (0.7, 0.8 * (1 - 1e-12), 1.0, 2.0, 2.1)]
    assert positions(ENERGIES, by_energy) == [0.8 * (1 - 1e-12), 1.0, 2.0]
    by_frequency = [Stored(1.05, 1.5), Stored(1.1, 2.5), Stored(1.3, 9.0), Stored(1.31, 1.6)]
    assert positions(FREQUENCIES, by_frequency) == [1.1, 1.3]
    # a branch by its length goes on from where it has left the range, so what follows is not kept
    folded = [Stored(0.0, 0.8), Stored(3.0, 1.9), Stored(3.5, 2.2), Stored(4.0, 1.9)]
    assert positions(ARC, folded) == [0.0, 3.0]


def test_subharmonic_branches_are_those_of_an_arc_alone() -> None:
    assert [wanted.harmonic for wanted in (ENERGIES, FREQUENCIES, ARC)] == [1, 1, 1]
    assert ArcContinuation(0.8, 2.0, harmonic=3).harmonic == 3
