"""Sections about what may be believed: verdicts with their reasons, and the certificate."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from fenics_nnm.backbone import point_numbers as numbers
from fenics_nnm.backbone.point import STATUSES, VERIFIED, BranchPoint
from fenics_nnm.output.html_report.elements import (
    Column,
    Html,
    described,
    element,
    paragraph,
    table,
    text,
)
from fenics_nnm.output.html_report.figures import Gallery
from fenics_nnm.output.html_report.page import Section
from fenics_nnm.output.html_report.words import MEANINGS
from fenics_nnm.output.pictures.results import Results

_Measure = Callable[[BranchPoint], float]

#: Numbers of a reason that were measured: in % or with a power of ten.
_MEASURED = re.compile(r"[-+]?\d+(?:\.\d+)?(?:%|e[-+]\d+)")

#: What is proved of each point, by columns of backbone.csv, and what is wanted of it.
_CERTIFICATE: tuple[tuple[str, str, _Measure], ...] = (
    ("virial identity", "below 1e-6", lambda p: p.balance.virial_error),
    ("force times gap at the samples", "below 1e-6", lambda p: p.balance.complementarity),
    ("miss of the start after one period", "below 0.05", numbers.return_error),
    ("miss of the start after ten periods", "below 0.02 *", numbers.return_error_10),
    ("drift of the energy in time", "round-off", numbers.energy_drift),
    (
        "frequency against the exact motion",
        "below 1e-3",
        lambda p: abs(numbers.shot_change(p)),
    ),
    (
        "frequency, expected of the reduction",
        "below 1e-3",
        lambda p: abs(numbers.reduction_error(p)),
    ),
    (
        "frequency, expected of the harmonics",
        "what you need",
        lambda p: abs(numbers.harmonics_error(p)),
    ),
    (
        "frequency, expected of the samples",
        "what you need",
        lambda p: abs(numbers.samples_error(p)),
    ),
)


def verdicts(results: Results) -> Section:
    """How many points have which status, and why the others are not verified."""
    counts = Counter(point.status for point in results.points)
    content: tuple[Html, ...] = (
        described(
            (f"{counts[status]} {status}", f"{MEANINGS[status]}.")
            for status in STATUSES
            if counts[status]
        ),
    )
    doubted = [point for point in results.points if point.status != VERIFIED]
    if doubted:
        heading = element("h3", text("What is not verified, and why"))
        content += (heading, described(_reasons(doubted)))
    return Section("verdicts", "What may be believed", content)


def _reasons(points: Sequence[BranchPoint]) -> list[tuple[str, str]]:
    """The points that are not verified, those with the same kind of reason together."""
    grouped: dict[tuple[str, str], list[BranchPoint]] = {}
    for point in points:
        grouped.setdefault((point.status, _MEASURED.sub("#", point.reason)), []).append(point)
    return [
        (
            f"{status} at {', '.join(f'{point.gamma_ratio:.6g}' for point in alike)}",
            f"{_with_ranges([point.reason for point in alike])}.",
        )
        for (status, _), alike in grouped.items()
    ]


def _with_ranges(reasons: Sequence[str]) -> str:
    """Reasons that differ in measured numbers as one, with the smallest and largest of these."""
    ranges = zip(*(_MEASURED.findall(reason) for reason in reasons), strict=True)
    written = iter([_range(numbers) for numbers in ranges])
    return _MEASURED.sub(lambda _: next(written), reasons[0])


def _range(numbers: Sequence[str]) -> str:
    ordered = sorted(numbers, key=lambda number: float(number.rstrip("%")))
    low, high = ordered[0], ordered[-1]
    return low if low == high else f"{low} to {high}"


def certificate(results: Results, gallery: Gallery) -> Section:
    """Errors of the points: median and largest of each, and pictures of them."""
    columns = (
        Column("relative error", "prose"),
        Column("median"),
        Column("largest"),
        Column("at gamma ratio"),
        Column("known for"),
        Column("wanted", "word"),
    )
    rows = [
        row for name, wanted, of in _CERTIFICATE if (row := _row(results.points, name, wanted, of))
    ]
    content = (
        table(columns, rows, label="Errors of the points"),
        paragraph(
            "* where no exact motion was found nearby. Errors of the mesh are not among these: "
            "halve the elements and see what the frequency does."
        ),
        *gallery.figures("accuracy"),
    )
    return Section("certificate", "Certificate", content)


def _row(
    points: Sequence[BranchPoint], name: str, wanted: str, of: _Measure
) -> Sequence[str] | None:
    """Median and largest error of the points where it is known; none if it is so nowhere."""
    errors = np.array([of(point) for point in points])
    known = np.flatnonzero(np.isfinite(errors))
    if not len(known):
        return None
    worst = known[np.argmax(errors[known])]
    return (
        name,
        _small(np.median(errors[known])),
        _small(errors[worst]),
        f"{points[worst].gamma_ratio:.6g}",
        f"{len(known)} of {len(points)}",
        wanted,
    )


def _small(error: float) -> str:
    return f"{error:.1e}" if error else "0"
