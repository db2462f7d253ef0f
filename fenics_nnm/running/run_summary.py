"""Contents of summary.json: what a run computed, how it ended, and with what."""

from __future__ import annotations

import platform
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib import metadata
from typing import Any

import dolfinx
import numpy as np
import petsc4py
import slepc4py

import fenics_nnm
from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.point import VERIFIED
from fenics_nnm.backbone.point_numbers import damping_needed, return_error
from fenics_nnm.mechanics.rest import RestState
from fenics_nnm.resolution.auto import Choice
from fenics_nnm.running.advice import advice
from fenics_nnm.running.auto_report import summary_of
from fenics_nnm.running.extremes_report import largest_in_summary
from fenics_nnm.running.families_report import families_in_summary
from fenics_nnm.structure.coriolis import coriolis_words
from fenics_nnm.structure.first_contact import FirstContact
from fenics_nnm.structure.kinematics_lines import kinematics_words
from fenics_nnm.structure.prepared import Prepared
from fenics_nnm.structure.structure import Linear
from fenics_nnm.time_domain.bifurcations import Bifurcation


def versions() -> dict[str, str]:
    """Versions of the program and of the libraries that a result depends on."""
    return {
        "fenics_nnm": fenics_nnm.__version__,
        "python": platform.python_version(),
        "dolfinx": dolfinx.__version__,
        "petsc4py": petsc4py.__version__,
        "slepc4py": slepc4py.__version__,
        **{name: metadata.version(name) for name in ("numpy", "scipy", "h5py")},
    }


def run_summary(
    chosen: Choice,
    branch: Branch,
    timings: Mapping[str, float],
    *,
    inputs: Mapping[str, str],
    warnings: Sequence[str] = (),
) -> dict[str, Any]:
    """What is written of a run; called on all ranks.

    Args:
        chosen: Its study with the numbers that were found for "auto".
        branch: The branch.
        timings: Seconds of each stage.
        inputs: Digests of the files that the study names, by key.
        warnings: What looks like a wrong unit or direction in the study.
    """
    prepared, study, linear = chosen.prepared, chosen.study, chosen.linear
    first = prepared.mode
    rest, amplitude = linear.model.at_rest(), linear.model.grazing_amplitude(first)
    return {
        "title": study.title,
        **linear.sizes(),
        "mode": study.mode.number,
        "harmonics": study.resolution.harmonics,
        "samples": study.resolution.samples,
        "linear_frequencies_Hz": [float(f) for f in prepared.linear_frequencies],
        **({"kinematics": words} if (words := kinematics_words(linear.reduction)) else {}),
        **_coriolis(linear, first),
        **_at_rest(rest, first),
        **_at_one(rest, first),
        "no_mode_missed_below_Hz": linear.modes.checked_below / (2 * np.pi) or None,
        "grazing_energy_J": float(rest.omega[first] * amplitude) ** 2 / 2,
        "first_contact": _first_contact(linear.first_contact(first)),
        **summary_of(chosen, branch),
        **prepared.damping.in_summary,
        "points": len(branch.points),
        "statuses": dict(Counter(point.status for point in branch.points)),
        "not_verified": _not_verified(branch),
        "advice": list(advice(chosen, branch)),
        "events": [
            {"kind": p.notes.event, "position": p.position, "gamma_ratio": p.gamma_ratio}
            for p in branch.points
            if p.notes.event
        ],
        "internal_resonances": [asdict(encounter) for encounter in branch.encounters],
        **families_in_summary(branch, study.continuation.resonances),
        "bifurcations": [_in_summary(each) for each in branch.bifurcations.located],
        "bifurcations_not_located": [list(g) for g in branch.bifurcations.unlocated],
        "largest_damping_needed": _largest_damping_needed(branch),
        "largest_return_error": _largest_return_error(branch),
        **largest_in_summary(branch.points),
        "complete": branch.complete,
        "failures": _failures(prepared, branch),
        "reason": branch.reason,
        "warnings": list(warnings),
        "timings": dict(timings),
        "inputs_sha256": dict(inputs),
        "versions": versions(),
    }


def _coriolis(linear: Linear, mode: int) -> dict[str, str]:
    """What Coriolis forces would change; nothing without them, or where modes are about contact."""
    words = coriolis_words(linear.coriolis, linear.modes, mode)
    return {"coriolis": words} if words and not linear.model.at_rest().closed.any() else {}


def _at_rest(rest: RestState, mode: int) -> dict[str, Any]:
    """What is closed and what touches at rest; nothing where all gaps are open."""
    if not rest.pressed:
        return {}
    return {
        "at_rest": {
            "closed": int(np.count_nonzero(rest.closed)),
            "touching": int(np.count_nonzero(rest.touching)),
            "contact_force_N": float(rest.force.sum()),
            "at_gamma_ratio_1": rest.at_one(mode),
        }
    }


def _at_one(rest: RestState, mode: int) -> dict[str, str]:
    """What happens at gamma ratio 1 where all gaps are open and that is not plain first contact."""
    event = "" if rest.pressed else rest.at_one(mode)
    return {} if event in ("", "first contact") else {"at_gamma_ratio_1": event}


def _first_contact(first: FirstContact) -> dict[str, Any]:
    """First contact of the contact points beside that of all vertices of the patches."""
    return {
        "contact_points": first.points,
        "vertices": first.vertices,
        "energy_J": first.energy,
        "over_all_vertices_J": first.over_all,
        "above_all_vertices_percent": 100 * first.excess,
    }


def _failures(prepared: Prepared, branch: Branch) -> list[dict[str, Any]]:
    """Wanted motions that were not found: the ratio that is stepped, and the reason."""
    name = prepared.wanted.name
    return [{name: ratio, "reason": why} for ratio, why in branch.failures]


def _largest_return_error(branch: Branch) -> float | None:
    """Largest distance from its start of a motion integrated over its period; None if unknown."""
    errors = [return_error(point) for point in branch.points]
    return max(errors) if errors and np.all(np.isfinite(errors)) else None


def _largest_damping_needed(branch: Branch) -> float | None:
    """Largest damping ratio that would hold an unstable motion; None if none is known."""
    needed = np.array([damping_needed(point) for point in branch.points])
    known = needed[np.isfinite(needed)]
    return float(known.max()) if known.size else None


def _in_summary(bifurcation: Bifurcation) -> dict[str, Any]:
    return {
        "kind": bifurcation.kind,
        "gamma_ratio": bifurcation.gamma_ratio,
        "energy_J": bifurcation.energy,
        "frequency_Hz": bifurcation.frequency,
        "multiplier": [bifurcation.multiplier.real, bifurcation.multiplier.imag],
        "bracket_J": list(bifurcation.bracket),
        "breaks_time_reversal": bifurcation.breaks_time_reversal,
        "stable_before": bifurcation.stable_before,
        "stable_after": bifurcation.stable_after,
    }


def _not_verified(branch: Branch) -> list[dict[str, Any]]:
    """Points that integration in time does not confirm, each with the reason."""
    return [
        {
            "position": point.position,
            "gamma_ratio": point.gamma_ratio,
            "status": point.status,
            "reason": point.reason,
            "confirmed": point.confirmed,
            "family": point.family,
        }
        for point in branch.points
        if point.status != VERIFIED
    ]
