"""What a study means, in words and numbers, before it is run."""

from __future__ import annotations

import numpy as np

from fenics_nnm.output.report import Analysis, report_of
from fenics_nnm.study import Study

#: Multiples of the frequency within this part of another one are named.
_NEAR = 0.05


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
    """Linear frequencies near a multiple of the followed one: internal resonances to expect."""
    omega = analysis.modes.omega
    first = omega[study.mode.number - 1]
    lines = []
    for number, other in enumerate(omega):
        harmonic = round(float(other / first))
        close = abs(other / (harmonic * first) - 1) if harmonic else np.inf
        if number + 1 != study.mode.number and harmonic <= study.mode.harmonics and close < _NEAR:
            lines.append(
                f"mode {number + 1} lies at {other / first:.4f} times mode {study.mode.number}: "
                f"internal resonance with harmonic {harmonic} is near"
            )
    return lines
