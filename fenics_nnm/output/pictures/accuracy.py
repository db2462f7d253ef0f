"""The certificate of a branch: its errors over energy."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fenics_nnm.backbone import point_numbers as numbers
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.backbone.verdict import VERIFIED_CHANGE, VERIFIED_RETURN_ERROR
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.output.pictures.style import (
    CURVES,
    GAMMA,
    GREY,
    Plot,
    legend_below,
    new_axes,
    new_figure,
)

#: Errors below this are round-off and are not drawn.
_ROUND_OFF = 1e-15


class _Error(NamedTuple):
    of: Callable[[BranchPoint], float]
    name: str
    explained: str


_ERRORS = (
    _Error(
        numbers.return_error, "return error", "return error: distance from the start after a period"
    ),
    _Error(
        lambda point: point.balance.energy_variation,
        "energy variation",
        "energy variation of the series in time",
    ),
    _Error(numbers.energy_drift, "energy drift", "energy drift of the integration in time"),
    _Error(
        numbers.harmonics_error, "harmonics", "harmonics: error of the frequency by N harmonics"
    ),
    _Error(numbers.samples_error, "samples", "samples: the same by m samples of a period"),
    _Error(numbers.reduction_error, "reduction", "reduction: the same by the modes left out"),
    _Error(
        lambda point: point.balance.virial_error,
        "virial identity",
        "virial identity: how far it is off",
    ),
)


def accuracy_plots(results: Results) -> list[Plot]:
    """The certificate; errors that are not known are left out."""
    figure = new_figure(4.1)
    axes = new_axes(figure, GAMMA, "relative error  (1)")
    explained = []
    for error, (colour, marker) in zip(_ERRORS, CURVES, strict=True):
        values = np.abs([error.of(point) for point in results.points])
        values = np.where(values > _ROUND_OFF, values, np.nan)
        if np.isfinite(values).any():
            axes.plot(results.ratios, values, color=colour, marker=marker, ms=3, lw=1,
                      label=error.name)  # fmt: skip
            explained.append(error.explained)
    if not explained:
        return []
    axes.set_yscale("log")
    limits = {"5 % (return error)": VERIFIED_RETURN_ERROR, "0.1 % (frequency)": VERIFIED_CHANGE}
    for (name, value), style in zip(limits.items(), ("--", ":"), strict=True):
        axes.axhline(value, color=GREY, lw=1, ls=style, label=name)
    legend_below(figure, axes, columns=3)
    caption = (
        "Relative errors (no unit) over the gamma ratio: "
        + "; ".join(explained)
        + f". Verified motions come back within {VERIFIED_RETURN_ERROR:.0%} after a period "
        f"(dashed) and their frequency is within {VERIFIED_CHANGE:.1%} (dotted). "
        "Values below 1e-15 are left out."
    )
    return [Plot("certificate", "Error certificate", caption, "accuracy", figure)]
