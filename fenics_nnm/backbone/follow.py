"""Continuation of a nonlinear mode."""

from __future__ import annotations

from fenics_nnm.backbone.arc_continuation import ArcContinuation
from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.cascade import Cascade
from fenics_nnm.backbone.energy_continuation import EnergyContinuation
from fenics_nnm.backbone.estimates import series_estimate, slope_estimate
from fenics_nnm.backbone.frequency_continuation import FrequencyContinuation
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.order import REDUCED, FullOrder, Order, ReducedOrder
from fenics_nnm.backbone.other_motions import OtherMotions
from fenics_nnm.backbone.point_maker import PointMaker
from fenics_nnm.backbone.revision import revised
from fenics_nnm.backbone.verdict import Judge, doubted
from fenics_nnm.backbone.wanted import SILENT, Progress, Wanted
from fenics_nnm.errors import Code, ModelError
from fenics_nnm.mechanics.model import ReducedModel

__all__ = [
    "ArcContinuation",
    "Branch",
    "EnergyContinuation",
    "FrequencyContinuation",
    "FullOrder",
    "Progress",
    "ReducedOrder",
    "Wanted",
    "follow",
]


def follow(
    model: ReducedModel,
    wanted: Wanted,
    balance: HarmonicBalance,
    *,
    mode: int,
    order: Order = REDUCED,
    shooting: bool = False,
    progress: Progress = SILENT,
) -> Branch:
    """Follow a nonlinear mode.

    Args:
        model: Reduced model in SI units.
        wanted: Energies or frequencies to visit, or a branch to follow by its length.
        balance: Series in time, and how contact is found.
        mode: Index of the linear mode that the branch starts at, from 0.
        order: Whether the motions are those of the reduced model, or of full order.
        shooting: Whether to shoot for the true motion near each point of a reduced model whose
            contact points carry no mass.
        progress: Points found before, and what hears of new ones.

    Raises:
        ModelError: if the mode is not in the model or never touches, contact points carry mass
            and the continuation is not one in energy, or a gap is not positive where they carry
            mass or at full order.
    """
    if not 0 <= mode < model.modes:
        raise ModelError(f"mode = {mode + 1}: must be between 1 and {model.modes}", code=Code.MODE)
    order.assert_fits(model)
    obeyed = order.obeyed(model, balance)
    scaled, scales = model.dimensionless(mode)
    cascade = Cascade(order.levels(scaled, scales, balance, mode=mode), mode, wanted.newton)
    finest = cascade.levels[-1]
    maker = PointMaker(
        finest.equations,
        scales,
        order.estimate(finest.equations, scales),
        series_estimate(finest),
        wanted.harmonic,
        slope_estimate(finest),
    )
    found = wanted.follow(cascade, maker, progress)
    judge = Judge(
        obeyed,
        balance.series,
        order.flow(obeyed),
        mode,
        wanted.harmonic,
        shooting and order.has_flow,
    )
    motions = OtherMotions(cascade, maker)
    verdicts = judge.judgement(revised(judge, motions, judge.judged(found), progress.on_point))
    points = doubted(verdicts.points, order.doubt)
    return Branch(points, found.failures, found.reason, verdicts.bifurcations, verdicts.jumps)
