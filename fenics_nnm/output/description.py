"""What a study means, in words and numbers, before it is run."""

from __future__ import annotations

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.outlook import Outlook
from fenics_nnm.backbone.resonance import Meeting
from fenics_nnm.mechanics.rest import RestState
from fenics_nnm.reduction.clusters import groups
from fenics_nnm.structure.coriolis import Frequencies
from fenics_nnm.structure.first_contact import FirstContact
from fenics_nnm.structure.prepared import Prepared
from fenics_nnm.study import Study

#: Most internal resonances that are listed; the others have higher harmonics.
_MOST_LISTED = 20

#: When what ends the linear motion happens, by its name.
_WHEN = {
    "lift-off": "when it lifts off",
    "first contact": "when it touches",
    "static first contact": "when it touches, with all other modes following statically",
    "nearest approach": "when it comes nearest, without touching",
}


def describe(prepared: Prepared) -> str:
    """Structure, contact and linear modes of a study as text; the same on all ranks."""
    study, linear, mode = prepared.study, prepared.linear, prepared.mode
    model, first = linear.model, linear.first_contact(mode)
    rest, amplitude = model.at_rest(), model.grazing_amplitude(mode)
    event, when = _first_event(rest, mode)
    largest = linear.largest(amplitude * rest.shapes[:, mode], amplitude * rest.pull[:, mode])
    lines = [
        study.title or "(no title)",
        *linear.heading(),
        *_at_rest(rest),
        f"{event:16s} at {first.energy:.6g} J for mode {study.mode.number}, first at {first.place}",
        *_over_all_vertices(first),
        f"largest motion   {largest} {when}",
        *linear.groups(),
        "",
        *_table(prepared, linear.frequencies()),
    ]
    lines += _of_equal_frequency(linear.modes.omega)
    below = linear.modes.checked_below
    if below:
        lines += ["", f"no mode missed below {below / 2 / np.pi:.6g} Hz"]
    return "\n".join([*lines, *_resonances(prepared), *_driven(study), *_passing(study)])


def _over_all_vertices(first: FirstContact) -> list[str]:
    """How far first contact of the contact points is from that of all vertices of the patches."""
    lines = [f"                 {first}"] if first.limited else []
    return [*lines, f"warning          {first.warning}"] if first.warning else lines


def _table(prepared: Prepared, others: Frequencies) -> list[str]:
    """Frequencies of the modes, and how far they move the contact points."""
    rest = prepared.linear.model.at_rest()
    own = len(prepared.linear_frequencies)  # retained contact points make more modes
    motion = np.abs(rest.motion).max(axis=0)[:own]
    columns = {"frequency (Hz)": prepared.linear_frequencies}
    if len(others.unloaded):
        columns["unloaded (Hz)"] = others.unloaded
    if len(others.gyroscopic) and not rest.closed.any():
        columns["with Coriolis (Hz)"] = others.gyroscopic
    lines = [f" mode   {'   '.join(columns)}   motion at contact (kg^-1/2)"]
    for number, reach in enumerate(motion):
        values = (f"{hertz[number]:{len(name)}.6g}" for name, hertz in columns.items())
        lines.append(f"{number + 1:5d}   {'   '.join(values)}   {reach:10.4g}")
    return lines + _coriolis(prepared, others)


def _coriolis(prepared: Prepared, others: Frequencies) -> list[str]:
    """How far Coriolis forces change frequencies, where the body rotates."""
    if not len(others.gyroscopic) or prepared.linear.model.at_rest().closed.any():
        return []
    own = prepared.linear.modes.frequencies
    change = np.abs(others.gyroscopic[: len(own)] / own - 1)
    mode = prepared.mode
    return [
        "",
        f"Coriolis forces change the frequency of mode {mode + 1} by a part of "
        f"{change[mode]:.1e}, of all of them by {change.max():.1e} at most",
    ]


def _of_equal_frequency(omega: Array) -> list[str]:
    """Which modes have one frequency, and how their shapes are chosen."""
    return [
        f"modes {group[0] + 1} to {group[-1] + 1} have one frequency: of all their shapes mode "
        f"{group[0] + 1} moves the contact points most"
        for group in groups(omega)
    ]


def _driven(study: Study) -> list[str]:
    """What the sections about driven motions are for, where there are any."""
    if not study.driven_sections:
        return []
    names = ", ".join(f"[{name}]" for name in study.driven_sections)
    return ["", f"{names}: for fenics-nnm response; {_in_runs(study)}"]


def _in_runs(study: Study) -> str:
    """What these sections do in a run."""
    if study.reduction.method != "massless":
        return f'a run ignores them with reduction.method = "{study.reduction.method}"'
    motions = (
        "a run follows damped motions where it can"
        if study.damped
        else "the motions of a run are undamped"
    )
    return f"{motions}, with the damping ratio and the force that keeps them up in backbone.csv"


def _passing(study: Study) -> list[str]:
    """That gaps move, where they do."""
    if not study.contact.passing_orders:
        return []
    orders = ", ".join(map(str, sorted(study.contact.passing_orders)))
    return [
        "",
        f"gaps move at {orders} times the speed of rotation, and are shown in the mean: for "
        "fenics-nnm response and simulate, not for a run",
    ]


def _at_rest(rest: RestState) -> list[str]:
    """What is closed at rest, where not all gaps are open."""
    if not rest.pressed:
        return []
    closed, touching = np.count_nonzero(rest.closed), np.count_nonzero(rest.touching)
    return [
        f"at rest          {closed} points closed, with {rest.force.sum():.4g} N in all; "
        f"{touching} touch without force, {len(rest.force) - closed - touching} are open"
    ]


def _first_event(rest: RestState, mode: int) -> tuple[str, str]:
    """Name of what ends the linear motion, and when it does."""
    if not rest.is_linear(mode):
        return "gamma ratio 1", "with the reference displacement, the points that touch taken open"
    event = rest.at_one(mode)
    return event, _WHEN[event]


def near_energy(meeting: Meeting, ahead: Outlook) -> str:
    """Where a branch meets a mode, or which of its ends is the nearer."""
    if np.isnan(meeting.gamma_ratio):
        return "below first contact"
    low, high = ahead.frequency_ratio.min(), ahead.frequency_ratio.max()
    beyond = "" if low <= meeting.ratio <= high else "beyond "
    return f"{beyond}{meeting.gamma_ratio:.3g}"


def _resonances(prepared: Prepared) -> list[str]:
    """Where harmonics of the branch meet linear modes: internal resonances to expect."""
    mode = prepared.mode
    ahead = prepared.outlook()
    hertz = prepared.linear_frequencies[mode]
    if not ahead.meetings:
        return ["", "no harmonic meets a mode on the way: no internal resonance expected"]
    by_harmonic = sorted(ahead.meetings, key=lambda meeting: meeting.harmonic)[:_MOST_LISTED]
    lines = [
        "",
        "internal resonances on the way, where harmonic n of the motion meets mode j",
        " mode j   harmonic n   omega_j / (n omega)   at (Hz)        near gamma ratio",
    ]
    for meeting in sorted(by_harmonic, key=lambda meeting: meeting.ratio):
        lines.append(
            f"{meeting.mode + 1:7d}   {meeting.harmonic:10d}   {meeting.ratio:19.4f}   "
            f"{meeting.ratio * hertz:<12.6g}   {near_energy(meeting, ahead)}"
        )
    more = len(ahead.meetings) - len(by_harmonic)
    return [*lines, f"and {more} more of higher harmonics"] if more else lines
