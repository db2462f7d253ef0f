"""From a study to the motions that it asks for, and how they are written in time."""

from __future__ import annotations

from fenics_nnm.backbone.arc_start import Begin
from fenics_nnm.backbone.follow import Wanted
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.errors import StudyError
from fenics_nnm.nonlinear.augmented_lagrangian import MultiplierLoop
from fenics_nnm.study import Study


def wanted_motions(study: Study, begin: Begin | None = None) -> Wanted:
    """Energies or frequencies that a study visits, or the range that it follows a branch in.

    Args:
        study: Study.
        begin: The motion of an earlier run that a branch followed by its length begins at.
    """
    return study.continuation.wanted(study.mode.harmonic, begin)


def assert_without_coriolis(study: Study) -> None:
    """Refuse a study whose linear modes have Coriolis forces, which motions do not have yet.

    Raises:
        StudyError: if it is one.
    """
    if study.coriolis:
        raise StudyError(
            f"{study.coriolis} = true: Coriolis forces are part of linear modes and of responses "
            "(fenics-nnm check, campbell, response, simulate): a nonlinear mode needs false"
        )


def assert_still_gaps(study: Study) -> None:
    """Refuse a study whose gaps move: undamped modes know obstacles that stand still alone.

    Raises:
        StudyError: if it is one.
    """
    if study.contact.passing_orders:
        key = 'casing.frame = "fixed"' if study.contact.patches else "contact.gap_motion"
        raise StudyError(
            f"{key}: gaps of a nonlinear mode do not move: must be left out, or use fenics-nnm "
            "response or simulate"
        )


def least_motions(study: Study) -> int:
    """How many motions a study asks for at least."""
    if study.continuation.beginning is not None:
        return 1
    return max(1, len(wanted_motions(study).certain_ratios))


def harmonic_balance(study: Study) -> HarmonicBalance:
    """How the motions of a study are written in time, and contact is found."""
    return HarmonicBalance(
        harmonics=study.resolution.harmonics,
        samples=study.resolution.samples,
        general=study.mode.series == "general",
        multipliers=_multipliers(study),
    )


def _multipliers(study: Study) -> MultiplierLoop | None:
    if not study.carries_mass:
        return None
    chosen = study.augmented_lagrangian
    return MultiplierLoop(**chosen.model_dump()) if chosen else MultiplierLoop()
