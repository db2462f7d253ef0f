"""From a study to the motions that it asks for, and how they are written in time."""

from __future__ import annotations

from fenics_nnm.backbone.follow import (
    ArcContinuation,
    Continuation,
    EnergyContinuation,
    FrequencyContinuation,
)
from fenics_nnm.backbone.levels import HarmonicBalance
from fenics_nnm.backbone.targets import Begin
from fenics_nnm.continuation.trace_options import ArcLength, Predictor
from fenics_nnm.nonlinear.augmented_lagrangian import MultiplierLoop
from fenics_nnm.study import Study
from fenics_nnm.study.continuation import ArcLengthSection


def wanted_motions(study: Study, begin: Begin | None = None) -> Continuation:
    """Energies or frequencies that a study visits, or the range that it follows a branch in.

    Args:
        study: Study.
        begin: The motion of an earlier run that a branch followed by its length begins at.
    """
    chosen = study.continuation
    if chosen.frequencies:
        over = chosen.frequencies
        return FrequencyContinuation(over.start, over.stop, over.step, report_at=chosen.report_at)
    if not chosen.by_arc:
        return _energies(study)
    energies, steps = chosen.energies, chosen.arc_length or ArcLengthSection()
    predictor = Predictor(steps.predictor)
    return ArcContinuation(
        energies.start,
        energies.stop,
        energies.step if chosen.parameter == "energy" else None,
        report_at=chosen.report_at,
        arc=ArcLength(**{**steps.model_dump(), "predictor": predictor}),
        harmonic=study.mode.harmonic,
        begin=begin,
    )


def certain_ratios(study: Study) -> list[float]:
    """Gamma ratios that a study surely has a point at, if it ends complete."""
    chosen = study.continuation
    if chosen.frequencies or chosen.by_arc:
        return list(chosen.report_at)
    return _energies(study).targets()


def _energies(study: Study) -> EnergyContinuation:
    energies, report_at = study.continuation.energies, study.continuation.report_at
    return EnergyContinuation(energies.start, energies.stop, energies.step, report_at=report_at)


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
