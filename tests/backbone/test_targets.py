"""Motions of given values of a quantity: an oscillator with an elastic stop, exact."""

from __future__ import annotations

import numpy as np
import pytest

from fenics_nnm.backbone import target_continuation
from fenics_nnm.backbone.follow import follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.target_continuation import TargetContinuation
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.motion import Motion

#: m = k = 1, and a stop of stiffness 10 at distance 1.
OSCILLATOR = ReducedModel(omega=[1.0], Phi=[[1.0]], R=[[0.1]], gap=[1.0])
BALANCE = HarmonicBalance(harmonics=15, samples=128)


def energy(motion: Motion) -> float:
    return motion.energy


def closed_form(energy: float) -> float:
    """Frequency in Hz in contact: m = k = 1, K = 10, e = 1."""
    open_ = 2 * np.arccos(-np.sqrt(1 / (2 * energy)))
    root = np.sqrt(2 * energy * 11 - 10)
    return float(1 / (open_ + 2 / np.sqrt(11) * np.arccos(1 / root)))


def test_energies_are_met_far_below_first_contact_and_above(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """First contact is at 0.5 J; 50 J lies above the gamma ratio to stop at, and says so."""
    monkeypatch.setattr(target_continuation, "_LARGEST", 6.0)
    wanted = TargetContinuation((1e-6, 0.2, 2.0, 50.0), energy, "energy")
    branch = follow(OSCILLATOR, wanted, BALANCE, mode=0)
    assert [point.position for point in branch.points] == [1e-6, 0.2, 2.0]
    for point in branch.points:
        assert point.motion.energy == pytest.approx(point.position, rel=1e-7)
        assert point.expected.series is not None
    frequencies = [point.motion.frequency for point in branch.points]
    exact = [1 / (2 * np.pi), 1 / (2 * np.pi), closed_form(2.0)]
    assert frequencies == pytest.approx(exact, rel=5e-5)
    ((missing, reason),) = branch.failures
    assert missing == 50 and reason.endswith("the branch comes to, at gamma ratio 6")
    assert not branch.complete and branch.reason.startswith("no point at energy 50: energy ")


@pytest.mark.parametrize("targets", [(), (1.0, 1.0), (0.0, 1.0), (2.0, 1.0)])
def test_values_that_do_not_ascend(targets: tuple[float, ...]) -> None:
    with pytest.raises(ModelError, match="must be positive and ascend"):
        TargetContinuation(targets, energy, "energy")
