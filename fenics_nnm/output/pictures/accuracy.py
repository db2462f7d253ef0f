"""The certificate of a branch: its errors over energy, and the stability of its motions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.style import (
    BLUE,
    CURVES,
    GAMMA,
    GREY,
    Plot,
    legend_below,
    new_axes,
    new_figure,
)
from fenics_nnm.time_domain.verdict import VERIFIED_CHANGE, VERIFIED_RETURN_ERROR

#: Errors below this are round-off and are not drawn.
_ROUND_OFF = 1e-15

#: Multipliers up to this need no logarithmic axis.
_LINEAR = 2.0


class _Error(NamedTuple):
    attribute: str
    name: str
    told: str


_ERRORS = (
    _Error("return_error", "return error", "return error: distance from the start after a period"),
    _Error("energy_variation", "energy variation", "energy variation of the series in time"),
    _Error("energy_drift", "energy drift", "energy drift of the integration over ten periods"),
    _Error("harmonics_error", "harmonics", "harmonics: error of the frequency by N harmonics"),
    _Error("samples_error", "samples", "samples: the same by m samples of a period"),
    _Error("reduction_error", "reduction", "reduction: the same by the modes left out"),
    _Error("virial_error", "virial identity", "virial identity: how far it is off"),
)


def accuracy_plots(results: Results) -> list[Plot]:
    """The certificate and the largest Floquet multipliers; what is not known is left out."""
    return [*_certificate(results), *_multipliers(results)]


def _certificate(results: Results) -> list[Plot]:
    figure = new_figure(4.1)
    axes = new_axes(figure, GAMMA, "relative error  (1)")
    told = []
    for error, (colour, marker) in zip(_ERRORS, CURVES, strict=True):
        values = np.abs([getattr(point, error.attribute) for point in results.points])
        values = np.where(values > _ROUND_OFF, values, np.nan)
        if np.isfinite(values).any():
            axes.plot(results.ratios, values, color=colour, marker=marker, ms=3, lw=1,
                      label=error.name)  # fmt: skip
            told.append(error.told)
    if not told:
        return []
    axes.set_yscale("log")
    limits = {"5 % (return error)": VERIFIED_RETURN_ERROR, "0.1 % (frequency)": VERIFIED_CHANGE}
    for (name, value), style in zip(limits.items(), ("--", ":"), strict=True):
        axes.axhline(value, color=GREY, lw=1, ls=style, label=name)
    legend_below(figure, axes, columns=3)
    caption = (
        "Relative errors (no unit) over the gamma ratio: "
        + "; ".join(told)
        + f". Verified motions come back within {VERIFIED_RETURN_ERROR:.0%} after a period "
        f"(dashed) and their frequency is within {VERIFIED_CHANGE:.1%} (dotted). "
        "Values below 1e-15 are left out."
    )
    return [Plot("certificate", "Error certificate", caption, "accuracy", figure)]


def _multipliers(results: Results) -> list[Plot]:
    largest = np.array([point.largest_multiplier for point in results.points])
    if not np.isfinite(largest).any():
        return []
    figure = new_figure(3.0)
    axes = new_axes(figure, GAMMA, "largest multiplier, modulus  (1)")
    axes.plot(results.ratios, largest, "o-", ms=3.5, lw=1, color=BLUE, label="exact motion nearby")
    axes.axhline(1, color=GREY, lw=1, ls="--", label="stable: on the unit circle")
    if np.nanmax(largest) > _LINEAR:
        axes.set_yscale("log")
    else:
        axes.set_ylim(0.95, max(1.05, 1.02 * np.nanmax(largest)))
    legend_below(figure, axes)
    missing = int(np.isnan(largest).sum())
    caption = (
        "Largest modulus (no unit) of the Floquet multipliers of the exact motion near each point, "
        "over the gamma ratio. It is 1 where the motion is stable; small disturbances grow "
        "by this factor in each period where it is larger."
        + (f" Not known at {missing} of {len(largest)} points." if missing else "")
    )
    return [Plot("multipliers", "Floquet multipliers", caption, "accuracy", figure)]
