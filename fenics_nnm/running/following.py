"""Second step of a run: the branch, each point on disk before the next one is begun."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from fenics_nnm.backbone.follow import Branch
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.fem.blocks import Blocks, Data
from fenics_nnm.fem.conducting import led
from fenics_nnm.fem.parallel import conducted, on_root
from fenics_nnm.interrupts import uninterrupted
from fenics_nnm.reduction.flexibility import FlexibilitySource
from fenics_nnm.resolution.auto import improved
from fenics_nnm.results import branch_file, journal
from fenics_nnm.results.journal import Journal
from fenics_nnm.running.measuring import measured, measures, measuring_of
from fenics_nnm.running.preparing import Ready

logger = logging.getLogger(__name__)

Points = tuple[BranchPoint, ...]


def follow(ready: Ready) -> tuple[Ready, Branch]:
    """Follow the branch, again from its beginning while "auto" asks for finer numbers.

    Returns:
        What the branch was followed with in the end, and the branch.
    """
    job = ready.job
    while True:
        branch = _followed(ready)
        if ready.chosen.prepared.damping.follows:
            return ready, branch  # its points do not give the errors of undamped ones
        finer = improved(ready.chosen, branch.points, job.comm, job.stages, analyse=job.analyse)
        if finer is None:
            return ready, branch
        ready = ready.with_finer(finer)


def _followed(ready: Ready) -> Branch:
    """Follow the branch once.

    One rank decides about the steps, so that round-off cannot part the ranks.
    """
    comm, study, linear = ready.job.comm, ready.chosen.study, ready.chosen.linear
    with ready.job.stages.stage("output"):
        data = linear.data()
        known = led(comm, data.blocks, partial(_begun, ready, data))
    if known:
        logger.info("%d points taken over", len(known))
    source = linear.flexibility(study.resolution.harmonics) if study.full_order else None
    if source is None:
        return on_root(comm, _solved, ready, known)
    with source as flexibility:
        return conducted(comm, partial(_solved, ready, known), flexibility)


def _begun(ready: Ready, data: Data, blocks: Mapping[str, Blocks]) -> Points:
    """Make branch.h5, with the points of an earlier run that are wanted again."""
    known = ready.earlier.points(ready.chosen.prepared)
    path = ready.staging.branch
    branch_file.create(path, ready.header, replace(data, blocks=blocks), known)
    return known


def _solved(
    ready: Ready,
    known: Points,
    flexibility: FlexibilitySource | None = None,
) -> Branch:
    points = journal.opened(lambda: ready.staging.branch)
    measuring = measuring_of(ready)
    branch = ready.chosen.prepared.followed(
        flexibility=flexibility,
        known=known,
        on_point=lambda point: store(points, point),
        measures=measures(measuring),
        stages=ready.job.stages,
    )
    damping = ready.chosen.prepared.damping
    if damping.light is not None and not damping.follows:
        branch = branch.kept_up(damping.light, ready.chosen.prepared.balance.series)
    with ready.job.stages.stage("stress"):
        branch = measured(measuring, branch)
    with uninterrupted():
        branch_file.finish(ready.staging.branch, branch)
    return branch


def store(points: Journal, point: BranchPoint) -> None:
    """Keep a point, and say so."""
    with uninterrupted():
        branch_file.append(points, point)
    logger.info(
        "gamma ratio %.6g: %.6f Hz, %.6g J, %d Newton steps",
        point.gamma_ratio,
        point.motion.frequency,
        point.motion.energy,
        point.notes.iterations,
    )
