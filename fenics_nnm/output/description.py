"""What a study means, in words and numbers, before it is run."""

from __future__ import annotations

import numpy as np

from fenics_nnm.analysis import harmonic_balance, wanted_motions
from fenics_nnm.continuation.outlook import outlook
from fenics_nnm.output.report import Analysis, report_of
from fenics_nnm.study import Study

#: Most internal resonances that are listed; the others have higher harmonics.
_MOST_LISTED = 20


def describe(study: Study, analysis: Analysis) -> str:
    """Structure, contact and linear modes of a study as text; the same on all ranks."""
    report, model = report_of(analysis), analysis.model
    mode = study.mode.number - 1
    amplitude = model.grazing_amplitude(mode)
    energy = (model.omega[mode] * amplitude) ** 2 / 2
    first = int(np.argmin(model.gap / np.maximum(np.abs(model.Phi[:, mode]), 1e-300)))
    lines = [
        study.title or "(no title)",
        *report.heading(),
        f"grazing          at {energy:.6g} J for mode {study.mode.number}, first at "
        f"{report.place(first)}",
        f"largest motion   {report.largest(mode, amplitude)} when it grazes",
        *report.groups(),
        "",
        " mode   frequency (Hz)   motion at contact (kg^-1/2)",
    ]
    for number, hertz in enumerate(analysis.modes.frequencies):
        reach = np.abs(model.Phi[:, number]).max()
        lines.append(f"{number + 1:5d}   {hertz:14.6g}   {reach:10.4g}")
    below = analysis.modes.checked_below
    if below:
        lines += ["", f"no mode missed below {below / 2 / np.pi:.6g} Hz"]
    return "\n".join(lines + _resonances(study, analysis))


def _resonances(study: Study, analysis: Analysis) -> list[str]:
    """Where harmonics of the branch meet linear modes: internal resonances to expect."""
    ahead = outlook(
        analysis.model,
        wanted_motions(study),
        harmonic_balance(study),
        mode=study.mode.number - 1,
    )
    hertz = analysis.modes.frequencies[study.mode.number - 1]
    if not ahead.meetings:
        return ["", "no harmonic meets a mode on the way: no internal resonance expected"]
    by_harmonic = sorted(ahead.meetings, key=lambda meeting: meeting.harmonic)[:_MOST_LISTED]
    lines = [
        "",
        "internal resonances on the way, where harmonic n of the motion meets mode j",
        " mode j   harmonic n   omega_j / (n omega)   at (Hz)        near gamma ratio",
    ]
    for meeting in sorted(by_harmonic, key=lambda meeting: meeting.ratio):
        near = "below grazing" if np.isnan(meeting.gamma_ratio) else f"{meeting.gamma_ratio:.3g}"
        lines.append(
            f"{meeting.mode + 1:7d}   {meeting.harmonic:10d}   {meeting.ratio:19.4f}   "
            f"{meeting.ratio * hertz:<12.6g}   {near}"
        )
    more = len(ahead.meetings) - len(by_harmonic)
    return [*lines, f"and {more} more of higher harmonics"] if more else lines
