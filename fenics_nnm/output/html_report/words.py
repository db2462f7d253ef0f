"""What was computed, in sentences and numbers as a designer says them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fenics_nnm.backbone.point import (
    CONVERGED,
    FAILED,
    RESONANT,
    STATUSES,
    VERIFIED,
    BranchPoint,
    believable,
)
from fenics_nnm.backbone.point_numbers import damping_needed, is_damped
from fenics_nnm.output.pictures.backbone import at_gamma_ratio_1
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.time_domain.stability import STABLE

_THEORIES = {
    "rod": "a rod (1-D)",
    "plane-stress": "a plane body in plane stress (2-D)",
    "plane-strain": "a plane body in plane strain (2-D)",
    "solid": "a solid body (3-D)",
}

_REDUCTIONS = {
    "massless": "free modes and a residual flexibility; its contact points carry no mass",
    "craig-bampton": "constraint modes and modes with the contact points held (Craig-Bampton)",
    "none": "the whole model at every harmonic (full order)",
}

#: What each status means, in half a sentence.
MEANINGS = {
    VERIFIED: "integration in time, which shares nothing with the harmonics, confirms the motion "
    "and its frequency to 0.1 %",
    CONVERGED: "solves its equations, but is not confirmed in time that tightly",
    RESONANT: "another mode draws energy from the motion, so its frequency lags behind the main "
    "branch",
    FAILED: "is no motion of the model, or expected to be far off: its frequency is not to be "
    "trusted",
}


#: What to know of points before their frequencies are used.
_DOUBTFUL = {
    FAILED: "failed the check in time, or are expected to be far off: their frequencies are "
    "not to be trusted.",
    RESONANT: "are inside an internal resonance: another mode draws energy from the motion, so "
    "their frequencies lag behind the main branch.",
}


#: Most jumps of the frequency that are warned of; all stand under families of motions.
_MOST_JUMPS = 3


def study_of(results: Results) -> Mapping[str, Any]:
    """The values of the study file."""
    return results.header.values


def title_of(results: Results) -> str:
    """Title of the study."""
    return str(study_of(results).get("title") or "Study without a title")


def length(metres: float) -> str:
    """A length in a unit that needs few zeros."""
    for unit, size in (("m", 1.0), ("mm", 1e-3)):
        if abs(metres) >= size:
            return f"{metres / size:.4g} {unit}"
    return f"{metres / 1e-6:.4g} µm" if metres else "0 m"


def plain(value: float, digits: int = 4) -> str:
    """A number of so many digits, without a power of ten where it needs few zeros."""
    if not value or not 1e-3 <= abs(value) < 1e7:
        return f"{value:.{digits}g}"
    decimals = max(0, digits - 1 - int(np.floor(np.log10(abs(value)))))
    return f"{value:,.{decimals}f}"


def aligned(values: Sequence[float], digits: int) -> list[str]:
    """Numbers with as many decimals as give the largest of them so many digits."""
    largest = max((abs(value) for value in values), default=0.0)
    decimals = max(0, digits - 1 - int(np.floor(np.log10(largest)))) if largest else 0
    return [f"{value:.{decimals}f}" for value in values]


def hardening(point: BranchPoint) -> float:
    """How far the frequency is above that of the linear mode, in %."""
    return 100 * (point.frequency_ratio - 1)


def signed(percent: float) -> str:
    """A change in %, with its sign; round-off is no change."""
    if abs(percent) < 5e-7:
        return "0"
    return f"{percent:+.2f}" if abs(percent) >= 0.1 else f"{percent:+.2g}"


def percent_of_critical(point: BranchPoint) -> str:
    """Damping that would hold an unstable motion, in % of critical damping."""
    return f"{100 * damping_needed(point):.2g} %"


def sentences(results: Results) -> list[str]:
    """Structure, contact, mode, method and outcome, a paragraph each."""
    return [
        f"{_structure(results)} {_contact(results)}",
        f"{_mode(results)} {_method(results)}",
        f"{_damped(results.points)}{_outcome(results.points)} {_trust(results.points)}",
    ]


def _damped(points: Sequence[BranchPoint]) -> str:
    """That motions have the damping of the study, and how much they dissipate; nothing if not."""
    kept = [point.sustained for point in points if point.sustained and is_damped(point)]
    if not kept:
        return ""
    ratios = [100 * each.ratio for each in kept]
    forces = [each.force for each in kept if np.isfinite(each.force)]
    by = f" by {min(forces):.3g} to {max(forces):.3g} N of the excitation" if forces else ""
    return (
        f"The motions have the damping of the study: {min(ratios):.3g} to {max(ratios):.3g} % of "
        f"critical damping, kept up in phase resonance{by}; their stability is that under this "
        "force. "
    )


def _structure(results: Results) -> str:
    study, sizes = study_of(results), results.summary
    dofs = f" with {sizes['dofs']:,} degrees of freedom" if "dofs" in sizes else ""
    if "matrices" in study:
        return (
            f"The structure is given by the stiffness and mass matrices of another code{dofs}."
            f"{_coriolis(sizes)}"
        )
    mesh, theory = study.get("mesh", {}), study.get("body", {}).get("theory", "")
    source = (
        f"the mesh file {mesh['file']}" if "file" in mesh else f"the built-in {mesh.get('model')}"
    )
    loaded = " It moves about its static state under steady loads." if _loaded(study) else ""
    body = _THEORIES.get(theory, "a body")
    return (
        f"The structure is {body}, {source}{dofs}, linear elastic.{loaded}{_coriolis(sizes)}"
        f"{_kinematics(sizes)}"
    )


def _kinematics(summary: Mapping[str, Any]) -> str:
    """Which kinematics the branch is of and why, where the study says something of them."""
    found = summary.get("kinematics")
    return f" Kinematics: {found}." if found else ""


def _coriolis(summary: Mapping[str, Any]) -> str:
    """What Coriolis forces would change of the mode, where the structure rotates."""
    found = summary.get("coriolis")
    return f" Coriolis forces are {found}." if found else ""


def _loaded(study: Mapping[str, Any]) -> bool:
    """Whether something loads the structure steadily."""
    rotation = study.get("rotation", {})
    return "load" in study or any(rotation.get(key) for key in ("speed", "rpm"))


def _contact(results: Results) -> str:
    gap, count = results.model.gap, len(results.model.gap)
    points = _counted(count, "contact point")
    low, high = float(gap.min()), float(gap.max())
    across = length(low) if np.isclose(low, high) else f"{length(low)} to {length(high)}"
    area = "" if results.areas is None else f" ({plain(1e6 * float(results.areas.sum()))} mm²)"
    facing = results.body is not None and results.body.facet_side.any()
    met = "the facets opposite" if facing else "an obstacle"
    sentence = f"{points}{area} can meet {met} without friction across a gap of {across}."
    return sentence + _rest(results.summary.get("at_rest"))


def _rest(rest: dict[str, Any] | None) -> str:
    """What is closed before anything moves; nothing where all gaps are open."""
    if not rest:
        return ""
    force = plain(rest["contact_force_N"])
    return (
        f" At rest {rest['closed']} of them are closed, pressed with {force} N in all, and "
        f"{rest['touching']} touch without force."
    )


def _mode(results: Results) -> str:
    number = results.header.mode
    begin = (
        f"The nonlinear mode is the family of periodic motions that begins at linear mode {number} "
        f"({results.linear_frequency:.6g} Hz)."
    )
    energy = results.summary.get("grazing_energy_J")
    if not energy:
        return begin
    return (
        f"{begin} {_event_at_one(results.summary)} an energy of {plain(energy)} J: the gamma "
        "ratio is the modal energy coordinate over its value there."
        f"{_over_all(results.summary.get('first_contact'))}"
    )


def _event_at_one(summary: Mapping[str, Any]) -> str:
    """What happens at gamma ratio 1, as the beginning of a sentence."""
    if "at_rest" in summary:
        return "The gamma ratio is 1 at"
    return {
        "first contact": "Contact begins at",
        "static first contact": "With all other modes following statically contact begins at",
        "nearest approach": "The mode comes nearest to the obstacle, without touching it, at",
    }[at_gamma_ratio_1(summary)]


def _over_all(first: dict[str, Any] | None) -> str:
    """How far the contact points are from all vertices; nothing where each vertex is one."""
    if not first or first["contact_points"] >= first["vertices"]:
        return ""
    return (
        f" If all {first['vertices']} vertices of the contact facets could touch, that would be "
        f"{plain(first['over_all_vertices_J'])} J: the {first['contact_points']} contact points "
        f"are {first['above_all_vertices_percent']:.2g} % above it."
    )


def _method(results: Results) -> str:
    header = results.header
    method = study_of(results).get("reduction", {}).get("method", "massless")
    return (
        f"It was found by harmonic balance with {_counted(header.harmonics, 'harmonic')} and "
        f"{header.samples} time samples of a period, on a model of "
        f"{_counted(header.modes, 'mode')}: {_REDUCTIONS[method]}."
    )


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _outcome(points: Sequence[BranchPoint]) -> str:
    points = believable(points)
    if not points:
        return "All points failed: there is no frequency to be trusted."
    first, last = points[0], points[-1]
    highest = max(points, key=lambda point: point.motion.frequency)
    sentence = (
        f"At a gamma ratio of {_at(first)} the frequency is {_hertz(first)}, at {_at(last)} it is "
        f"{_hertz(last)}: {_compared(hardening(last))} that of the linear mode."
    )
    if highest.motion.frequency > last.motion.frequency * (1 + 1e-6):
        sentence += (
            f" It is highest at {highest.gamma_ratio:.4g}: {_hertz(highest)} "
            f"({signed(hardening(highest))} %)."
        )
    return sentence


def _at(point: BranchPoint) -> str:
    return f"{point.gamma_ratio:.4g} ({plain(point.motion.energy)} J)"


def _hertz(point: BranchPoint) -> str:
    return f"{point.motion.frequency:.6g} Hz"


def _compared(percent: float) -> str:
    if abs(percent) < 5e-7:
        return "just"
    return f"{abs(percent):.3g} % {'above' if percent > 0 else 'below'}"


def _trust(points: Sequence[BranchPoint]) -> str:
    counts = Counter(point.status for point in points)
    listed = ", ".join(f"{counts[status]} {status}" for status in STATUSES if counts[status])
    kinds = [point.stability.kind for point in points if point.stability]
    stable, known = kinds.count(STABLE), len(kinds)
    sentence = f"Of {len(points)} points: {listed}."
    if not known:
        return sentence
    which = "all of them are" if stable == known else f"{stable} {'is' if stable == 1 else 'are'}"
    return f"{sentence} Stability is known of {known}: {which} stable{_held(points)}."


def _held(points: Sequence[BranchPoint]) -> str:
    """What damping holds those that are not stable without; nothing if all are."""
    needed = np.array([damping_needed(point) for point in points])
    largest = float(np.nanmax(needed))
    if not largest > 0:
        return ""
    if any(map(is_damped, points)):
        return f", all would be with {100 * largest:.2g} % of critical damping more"
    return f" without damping, all with {100 * largest:.2g} % of critical damping"


def warnings(results: Results) -> list[str]:
    """What a reader must know before using a number, in plain words."""
    points, summary = results.points, results.summary
    found = []
    if not summary:
        found.append(
            "There is no summary.json: the run was stopped before its end, and what is said below "
            "is about the points that it had."
        )
    elif not summary["complete"]:
        found.append(f"The run did not get all that was asked for: {summary['reason']}.")
    found += [f"{line}." for line in summary.get("warnings", [])]
    found += [f"{each['words'][0].upper()}{each['words'][1:]}." for each in _jumps(summary)]
    found += [
        f"At {_place(each)} no motion on the branch was found: {each['reason']}."
        for each in summary.get("failures", [])
    ]
    counts = Counter(point.status for point in points)
    found += [
        f"{counts[status]} of {len(points)} points {what}"
        for status, what in _DOUBTFUL.items()
        if counts[status]
    ]
    if summary.get("advice"):
        found.append("What to try is under Next steps.")
    if summary and not counts[VERIFIED]:
        found.append("No point is verified: see below why.")
    found += _missed_tolerance(summary.get("auto", {}))
    return found


def _jumps(summary: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The largest jumps of the frequency between neighbours."""
    found = summary.get("jumps", [])
    return sorted(found, key=lambda each: -abs(each["change"]))[:_MOST_JUMPS]


def _place(failure: dict[str, Any]) -> str:
    """Where a motion was wanted: the ratio that was stepped."""
    name = "gamma_ratio" if "gamma_ratio" in failure else "frequency_ratio"
    return f"{name.replace('_', ' ')} {failure[name]:.6g}"


def _missed_tolerance(auto: dict[str, Any]) -> list[str]:
    if auto.get("met") is not False:
        return []
    limits = "; ".join(f"{name}: {why}" for name, why in auto.get("limits", {}).items())
    if doubt := auto.get("doubt"):
        return [f"Whether the tolerance of the frequency is met is not known: {doubt}."]
    return [
        f"The tolerance of the frequency, {auto['tolerance']:g}, is not met"
        + (f" ({limits})." if limits else ".")
    ]
