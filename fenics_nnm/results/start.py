"""Where a branch begins that starts from a motion of an earlier run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.arc_start import Begin
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.continuation.events import BRANCH_POINT
from fenics_nnm.errors import OutputError, StudyError
from fenics_nnm.mechanics.contact_points import MASSIVE
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.reduction.comparison import mode_signs, model_difference
from fenics_nnm.results import branch_file
from fenics_nnm.results.branch_file import BranchHeader
from fenics_nnm.study.continuation import StartSection
from fenics_nnm.study.solution import ModeSection

#: Two gamma ratios nearer than this are the same.
_SAME_RATIO = 1e-6


def beginning(
    chosen: StartSection, mode: ModeSection, model: ReducedModel, balance: HarmonicBalance
) -> Begin:
    """The motion that a branch begins at, in the coordinates and series of another run.

    The stored run may have fewer or more modes and harmonics: what is missing is filled with zeros,
    and solved for.

    Args:
        chosen: File and point.
        mode: The mode that is followed, with its harmonic: gamma and frequency ratios are those
            of both, in the stored run too.
        model: Reduced model of the branch, in SI units.
        balance: Its series.

    Raises:
        StudyError: if there is no such file or point, or it is one of another structure or mode.
    """
    if not chosen.file.is_file():
        what = "is no file: must be a branch.h5" if chosen.file.exists() else "no such file"
        raise StudyError(f"continuation.start.file = {chosen.file}: {what}")
    try:
        header, points = branch_file.read(chosen.file)
    except OutputError as error:
        raise StudyError(f"continuation.start.file = {error}") from error
    _assert_followed(chosen, mode, header)
    _assert_fits(chosen, header, model, balance.series)
    index = _index(chosen, points)

    def fitted(point: BranchPoint) -> BranchPoint:
        return _fitted(point, header, model, balance.series)

    if chosen.bifurcation is None:
        return Begin(fitted(points[index]), downwards=chosen.direction == "down")
    along = fitted(points[index - 1]), fitted(points[index + 1])
    return Begin(fitted(points[index]), along, downwards=chosen.direction == "down")


def _index(chosen: StartSection, points: tuple[BranchPoint, ...]) -> int:
    """Number of the point chosen."""
    if chosen.gamma_ratio is not None:
        missing = [abs(point.gamma_ratio - chosen.gamma_ratio) for point in points]
        nearest = int(np.argmin(missing)) if missing else -1
        if nearest < 0 or missing[nearest] > _SAME_RATIO * chosen.gamma_ratio:
            raise StudyError(
                f"continuation.start.gamma_ratio = {chosen.gamma_ratio:g}: {chosen.file} has no "
                "such point: name it in continuation.report_at of that run to have one"
            )
        return nearest
    found = [i for i, point in enumerate(points) if point.notes.event == BRANCH_POINT.kind]
    number = chosen.bifurcation or 0
    if number > len(found):
        raise StudyError(
            f"continuation.start.bifurcation = {number}: {chosen.file} has {len(found)} branch "
            "points"
        )
    return found[number - 1]


def _assert_followed(chosen: StartSection, mode: ModeSection, header: BranchHeader) -> None:
    """Refuse motions whose ratios are those of another mode, or of another harmonic of it."""
    harmonic = header.values.get("mode", {}).get("harmonic", 1)
    for key, now, before in (
        ("number", mode.number, header.mode),
        ("harmonic", mode.harmonic, harmonic),
    ):
        if now != before:
            raise StudyError(
                f"mode.{key} = {now}: continuation.start.file = {chosen.file} has motions of "
                f"mode.{key} = {before}: must be the same"
            )


def _assert_fits(
    chosen: StartSection, header: BranchHeader, model: ReducedModel, series: Series
) -> None:
    modes = min(model.modes, header.model.modes)
    reason = model_difference(_first(header.model, modes), _first(model, modes))
    if reason:
        raise StudyError(
            f"continuation.start.file = {chosen.file}: is of another structure: {reason}"
        )
    if header.series == "general" and not series.free_phase:
        raise StudyError(
            f"continuation.start.file = {chosen.file}: its motions have sines: mode.series must be "
            '"general" here, too'
        )


def _first(model: ReducedModel, modes: int) -> ReducedModel:
    """The first modes of a model, without the residual flexibility: that is of the others."""
    return ReducedModel(
        model.omega[:modes],
        model.Phi[:, :modes],
        np.zeros_like(model.R),
        model.gap,
        contact=MASSIVE,
    )


def _fitted(
    point: BranchPoint, header: BranchHeader, model: ReducedModel, series: Series
) -> BranchPoint:
    """A stored point in the modes and the series of another run."""
    modes = min(model.modes, header.model.modes)
    signs = mode_signs(_first(header.model, modes), _first(model, modes))
    q: Array = np.zeros((len(point.motion.q), model.modes))
    q[:, :modes] = signs * point.motion.q[:, :modes]
    if series.free_phase and header.series != "general":
        q = np.vstack([q, np.zeros((len(q) - 1, model.modes))])
    coefficients = series.fitted(q)
    force = header.time_series.interpolated(point.motion.force, series.phase)
    free: Array = np.zeros((len(coefficients), model.points))
    return replace(point, motion=replace(point.motion, q=coefficients, force=force, free=free))
