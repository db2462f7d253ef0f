"""A piece of the response that is not connected to its ends: found, closed, and there in time."""

import numpy as np
import pytest

from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.mechanics.linear_part import RatedPart
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.output.response_lines import pieces
from fenics_nnm.response.curve import curve
from fenics_nnm.response.in_time import state_at
from fenics_nnm.response.isolas import with_isolas
from fenics_nnm.response.judge import Unjudged
from fenics_nnm.response.levels import Response
from fenics_nnm.response.phase_resonance import damped_backbone
from fenics_nnm.response.simulation import settled, simulation
from fenics_nnm.response.structure import Drive, DrivenStructure
from fenics_nnm.time_domain.damped_flow import DampedFlow

FREQUENCIES = np.linspace(0.995, 1.012, 3) / (2 * np.pi)
SERIES = FourierSeries(4, 32)


def structure() -> DrivenStructure:
    """Three modes with an internal resonance, at which the level of the backbone turns back."""
    omega = np.array([1.0, 2.98, 4.17])
    model = ReducedModel(omega, np.array([[0.65, -2.31, -0.19]]), np.array([[0.126]]), np.ones(1))
    linear = RatedPart(omega, np.diag([0.0132, 0.0727, 0.0718]))
    drive = Drive.simple(np.array([[1.0, 0.86, 1.51]]), np.array([0.0284 + 0j]))
    return DrivenStructure.of(model, linear, drive)


@pytest.fixture(scope="module")
def connected() -> Response:
    """Its response as it is connected to the ends, and the damped backbone."""
    found = curve(structure(), SERIES, FREQUENCIES, judge=Unjudged())
    backbone = damped_backbone(structure(), SERIES, FREQUENCIES, (1.0,), judge=Unjudged())
    return Response(found.points, backbone=backbone)


@pytest.fixture(scope="module")
def whole(connected: Response) -> Response:
    """The same with all pieces."""
    return with_isolas(structure(), SERIES, FREQUENCIES, connected)


def test_resonances_that_the_curve_does_not_pass_are_on_one_closed_piece(
    connected: Response, whole: Response
) -> None:
    """Of three resonances the curve passes the first, the piece the others, and it is closed."""
    assert {point.branch for point in connected.points} == {1}
    isola = [point for point in whole.points if point.branch > 1]
    assert {point.branch for point in isola} == {3} and not whole.reasons
    assert isola[0].q == pytest.approx(isola[-1].q)
    resonances = [e.point for e in connected.backbone.points if e.point.level == 1.0]
    assert len(resonances) == 3
    for resonance in resonances[1:]:
        lags = np.array([point.phase[0] for point in isola])
        assert lags.min() < 90 < lags.max()
        nearest = min(abs(point.amplitude[0] / resonance.amplitude[0] - 1) for point in isola)
        assert nearest < 0.01
    assert [point.event for point in isola].count("fold in omega") == 2
    assert max(point.imbalance for point in isola) < 1e-10
    (line,) = pieces(whole)
    assert "level 1" in line and "branch 3" in line


def test_nothing_is_added_twice(whole: Response) -> None:
    again = with_isolas(structure(), SERIES, FREQUENCIES, whole)
    assert len(again.points) == len(whole.points)


def test_it_is_there_in_time_beside_the_motion_from_rest(whole: Response) -> None:
    """Integration in time: at one frequency two motions stay, each from its own beginning."""
    stable = [p for p in whole.points if p.branch == 3 and p.judgement.stability == "stable"]
    point = min(stable, key=lambda each: abs(each.omega - 1.005))
    flow = DampedFlow.of(structure().mechanics, 1.0)
    ends = []
    for start in (state_at(SERIES, point.q, point.omega, 0.0), (np.zeros(3), np.zeros(3))):
        found = simulation(flow, structure().watched, np.full(500, point.frequency), start)
        at = settled(flow, found.q, found.velocity, point.frequency)
        assert at.periods == 1
        ends.append(float(found.periods[-1].largest[0]))
    assert ends[0] == pytest.approx(point.displacements.highest[0], rel=2e-2)
    assert ends[1] < 0.9 * ends[0]
