"""Other motions of the energy of a point inside a resonance, and which of them takes its place."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.estimates import series_estimate, slope_estimate
from fenics_nnm.backbone.follow import EnergyContinuation, follow
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.order import REDUCED
from fenics_nnm.backbone.other_motions import OtherMotions
from fenics_nnm.backbone.point import MAIN_BRANCH, RESONANT, VERIFIED, BranchPoint
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.revision import revised
from fenics_nnm.backbone.verdict import Judge, Judged
from fenics_nnm.backbone.wanted import SILENT, Progress
from fenics_nnm.mechanics.mechanics import Mechanics
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.time_domain.stepped import integrator_of

#: Two nearly equal oscillators with stops, and a third mode that the first one meets at 1.2.
MODEL = ReducedModel(
    omega=[381.94, 381.95, 406.75],
    Phi=[[-1.821, 0.1853, -0.0112], [0.1852, 1.8209, 0.0112]],
    R=[[1.428e-6, 0.0], [0.0, 1.428e-6]],
    gap=[1.18e-3, 1.21e-3],
)
BALANCE = HarmonicBalance(6, 96)
ENERGIES = EnergyContinuation(1.1, 1.3, 0.1)


@cache
def begun() -> tuple[Judge, OtherMotions, Judged]:
    """The branch before it is revised, and what revises it."""
    scaled, scales = MODEL.dimensionless(0)
    levels = REDUCED.levels(scaled, scales, BALANCE, mode=0)
    cascade, finest = Cascade(levels, 0, ENERGIES.newton), levels[-1]
    maker = PointMaker(
        finest.equations,
        scales,
        REDUCED.estimate(finest.equations, scales),
        series_estimate(finest),
        slope=slope_estimate(finest),
    )
    flow = integrator_of(Mechanics.of(MODEL))
    judge = Judge(MODEL, BALANCE.series, flow, mode=0, harmonic=1, shooting=True)
    known = judge.judged(ENERGIES.follow(cascade, maker, SILENT))
    return judge, OtherMotions(cascade, maker), known


def test_a_point_inside_a_resonance_gives_way_to_the_main_branch() -> None:
    """Levels end in the third mode at 1.2; the family of 1.3 comes to the main branch there."""
    _, _, known = begun()
    assert [each.status for each in known.points] == [VERIFIED, RESONANT, VERIFIED]
    heard: list[BranchPoint] = []
    branch = follow(
        MODEL, ENERGIES, BALANCE, mode=0, shooting=True, progress=Progress(on_point=heard.append)
    )
    assert all((each.status, each.family) == (VERIFIED, MAIN_BRANCH) for each in branch.points)
    below, here, above = (each.motion.frequency for each in branch.points)
    assert known.points[1].motion.frequency < 0.99 * here and not branch.jumps
    assert here == pytest.approx((below + above) / 2, rel=5e-3)
    shot = branch.points[1].orbit
    assert shot is not None and shot.frequency == pytest.approx(here, rel=1e-3)
    assert [each.position for each in heard] == [1.1, pytest.approx(1.2), 1.3, pytest.approx(1.2)]
    assert heard[-1].motion.frequency == here and heard[-1].verdict is None


def test_other_motions_have_the_energy_of_the_point_and_solve_its_equations() -> None:
    _, motions, known = begun()
    found = list(motions.of(known.points, 1))
    frequencies = [known.points[1].frequency_ratio, *(each.frequency_ratio for each in found)]
    assert len(set(np.round(frequencies, 6))) == len(frequencies) > 1
    for each in found:
        assert each.position == each.gamma_ratio == known.points[1].gamma_ratio
        solution = motions.maker.solution(each)
        assert solution.energies.gamma == pytest.approx(0.25 * each.gamma_ratio, rel=1e-9)
        assert each.balance.residual < 1e-9 and each.balance.virial_error < 1e-9


def test_the_branch_is_judged_anew_with_one_point_exchanged() -> None:
    judge, motions, known = begun()
    other = next(motions.of(known.points, 1))
    exchanged = judge.exchanged(known, 1, other)
    afresh = judge.judged(replace(known.found, points=exchanged.found.points))
    assert exchanged.found.points[1] is other
    assert [each.verdict for each in exchanged.points] == [each.verdict for each in afresh.points]
    assert exchanged.evidence[0] is known.evidence[0]


def test_points_that_have_their_place_for_another_reason_stay() -> None:
    """Such as one at a given displacement: another motion of its energy has another one."""
    judge, motions, known = begun()
    fixed = replace(known, found=replace(known.found, of_energies=False))
    assert revised(judge, motions, fixed, lambda _: None) is fixed
