"""Sections about the frequency-energy curve: picture, points, what it meets on its way."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fenics_nnm.backbone.point import MAIN_BRANCH, NO_FAMILY, BranchPoint
from fenics_nnm.backbone.point_numbers import damping_needed, is_damped
from fenics_nnm.output.html_report.elements import (
    Column,
    Html,
    data_uri,
    element,
    folded,
    joined,
    link,
    paragraph,
    table,
    text,
)
from fenics_nnm.output.html_report.figures import Gallery
from fenics_nnm.output.html_report.live_curve import live_curve
from fenics_nnm.output.html_report.page import Section
from fenics_nnm.output.html_report.words import (
    aligned,
    hardening,
    percent_of_critical,
    plain,
    signed,
)
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.time_domain.stability import STABLE

#: Most rows of the table of points, and of linear frequencies before the others are folded away.
MOST_POINTS, _FEW_MODES = 60, 12

_POINTS = (
    Column("point"),
    Column("gamma ratio (1)"),
    Column("frequency (Hz)"),
    Column("hardening (%)"),
    Column("energy (J)"),
    Column("contact (% of period)"),
    Column("largest displacement (mm)"),
    Column("von Mises stress (MPa)"),
    Column("contact force (N)"),
    Column("status", "word"),
    Column("stability", "word"),
    Column("remark", "prose"),
)


def curve(results: Results, gallery: Gallery) -> Section:
    """The curve with the numbers of each point, and pictures of it."""
    content = (live_curve(results), *gallery.figures("frequency"))
    return Section("curve", "Frequency over energy", content)


def points(results: Results, table_file: Path, beside: str) -> Section:
    """Table of the points, with the whole of backbone.csv to take along.

    Args:
        results: Results.
        table_file: A backbone.csv of them.
        beside: Where backbone.csv is, seen from the page; empty if it is nowhere.
    """
    chosen = _thinned(results.points)
    kept = "all" if len(chosen) == len(results.points) else f"{len(chosen)} evenly spread ones"
    links = [link("download backbone.csv", _data(table_file), download="backbone.csv")]
    if beside:
        links.append(link("open it in the results folder", beside))
    sentence = element(
        "p",
        text(f"Of {len(results.points)} points {kept} are shown. All of them, with every column: "),
        joined(links, Html(" or ")),
        text("."),
    )
    rows = _rows(results.points, chosen)
    content = (sentence, table(_POINTS, rows, label="Points of the branch"))
    return Section("points", "Points", content + _kinds_of_instability(results.points))


def _data(table_file: Path) -> str:
    return data_uri(table_file.read_bytes(), "text/csv")


def _thinned(points: Sequence[BranchPoint]) -> list[int]:
    """Indices of the points to show: evenly spread ones, and those where something happens."""
    even = np.linspace(0, len(points) - 1, min(len(points), MOST_POINTS)).round().astype(int)
    marked = [index for index, point in enumerate(points) if point.notes.event]
    return sorted({*even.tolist(), *marked})


def _rows(points: Sequence[BranchPoint], chosen: Sequence[int]) -> list[tuple[str, ...]]:
    frequencies = aligned([point.motion.frequency for point in points], 8)
    return [
        (
            str(index + 1),
            f"{points[index].gamma_ratio:.6g}",
            frequencies[index],
            signed(hardening(points[index])),
            plain(points[index].motion.energy, 5),
            f"{100 * points[index].motion.contact_fraction:.1f}",
            _known(1e3 * points[index].extremes.displacement.value),
            _known(1e-6 * points[index].extremes.von_mises.away.value),
            _known(points[index].extremes.force),
            points[index].status,
            _stability(points[index]),
            _remark(points[index]),
        )
        for index in chosen
    ]


def _known(value: float) -> str:
    """A number of few digits; nothing where it is not known."""
    return "" if np.isnan(value) else plain(value, 4)


def _stability(point: BranchPoint) -> str:
    if point.stability is None:
        return "not known"
    if point.stability.kind == STABLE:
        return STABLE
    if is_damped(point):
        return f"unstable: {percent_of_critical(point)} of critical damping more would hold it"
    return f"unstable below {percent_of_critical(point)} of critical damping"


def _remark(point: BranchPoint) -> str:
    remarks = (
        "" if point.family in (NO_FAMILY, MAIN_BRANCH) else f"family {point.family}",
        point.notes.event,
        f"beyond {point.extremes.beyond} strength" if point.extremes.beyond else "",
        point.resonance,
        point.notes.skipped and f"beyond {point.notes.skipped}",
    )
    return "; ".join(remark for remark in remarks if remark)


def _kinds_of_instability(points: Sequence[BranchPoint]) -> tuple[Html, ...]:
    """How the unstable motions are unstable."""
    known = [point.stability.kind for point in points if point.stability]
    kinds = Counter(kind for kind in known if kind != STABLE)
    if not kinds:
        return ()
    listed = "; ".join(f"{count} with {kind}" for kind, count in kinds.items())
    worst = max(points, key=lambda point: np.nan_to_num(damping_needed(point), nan=-1.0))
    if is_damped(worst):
        return (
            paragraph(f"Points that are unstable with the damping of the study: {listed}."),
            paragraph(
                f"The most unstable one, at gamma ratio {worst.gamma_ratio:.6g}, would be held by "
                f"{percent_of_critical(worst)} of critical damping more in all modes."
            ),
        )
    return (
        paragraph(f"Points that are unstable without damping: {listed}."),
        paragraph(
            f"The most unstable one, at gamma ratio {worst.gamma_ratio:.6g}, is held by "
            f"{percent_of_critical(worst)} of critical damping in all modes: zeta = "
            "ln |mu| / (2 pi) of its largest multiplier mu."
        ),
    )


def linear_frequencies(results: Results, gallery: Gallery) -> Section:
    """Frequencies and shapes of the linear modes."""
    hertz = results.summary.get("linear_frequencies_Hz", [])
    if not hertz:
        return Section("linear", "Linear modes", (), "the run was stopped before its summary.")
    columns = (Column("mode"), Column("frequency (Hz)"), Column("over that of the mode followed"))
    ratios = [value / results.linear_frequency for value in hertz]
    numbers = [str(number) for number in range(1, len(hertz) + 1)]
    rows = list(zip(numbers, aligned(hertz, 8), aligned(ratios, 6), strict=True))
    below = results.summary.get("no_mode_missed_below_Hz")
    checked = (
        f"A count of the eigenvalues shows that no mode below {below:.6g} Hz is missing."
        if below
        else "Whether a mode was missed has not been checked."
    )
    content: tuple[Html, ...] = (
        paragraph(f"Without contact; {checked[0].lower()}{checked[1:]}"),
        table(columns, rows[:_FEW_MODES], label="Linear frequencies"),
    )
    if len(rows) > _FEW_MODES:
        label = f"Modes {_FEW_MODES + 1} to {len(rows)}"
        content += (folded(label, table(columns, rows[_FEW_MODES:], label=label)),)
    content += gallery.figures("linear")
    return Section("linear", "Linear modes", content)


def families(results: Results) -> Section:
    """Families of motions that the branch met, and where it jumps from one to another."""
    found = results.summary.get("families", [])
    columns = (
        Column("family", "word"),
        Column("points"),
        Column("confirmed in time"),
        Column("gamma ratio (1)"),
        Column("energy (J)"),
        Column("frequency (Hz)"),
    )
    rows = [
        (
            "main branch" if each["family"] == MAIN_BRANCH else str(each["family"]),
            str(each["points"]),
            str(each["confirmed"]),
            *(_span(each[name]) for name in ("gamma_ratio", "energy_J", "frequency_Hz")),
        )
        for each in found
    ]
    told = [f"{each['words']}." for each in results.summary.get("jumps", [])]
    told += [f"{sentence}." for sentence in results.summary.get("several_families", [])]
    content: tuple[Html, ...] = ()
    if len(rows) > 1 or told:
        content = (
            table(columns, rows, label="Families of motions"),
            *(paragraph(f"{sentence[0].upper()}{sentence[1:]}") for sentence in told),
        )
    why = "all points are of one family, and nothing tells of another."
    return Section("families", "Families of motions", content, _none(results, why))


def _span(ends: Sequence[float]) -> str:
    low, high = (f"{each:.6g}" for each in ends)
    return low if low == high else f"{low} to {high}"


def resonances(results: Results) -> Section:
    """Internal resonances on the way."""
    found = results.summary.get("internal_resonances", [])
    columns = (
        Column("resonance", "prose"),
        Column("near (Hz)"),
        Column("entered at gamma ratio", "prose"),
        Column("left aside at gamma ratio", "prose"),
    )
    rows = [
        (each["name"], f"{each['frequency']:.6g}", _list(each["entered"]), _list(each["skipped"]))
        for each in found
    ]
    return Section(
        "resonances",
        "Internal resonances",
        (
            paragraph(
                "Where a harmonic of the motion meets a linear mode, energy flows into that mode "
                "and the frequency stands still."
            ),
            table(columns, rows, label="Internal resonances"),
        )
        if rows
        else (),
        _none(results, "no internal resonance was entered or left aside."),
    )


def bifurcations(results: Results) -> Section:
    """Where the exact motions become stable or unstable, and where the branch turns."""
    found = results.summary.get("bifurcations", [])
    columns = (
        Column("kind", "word"),
        Column("gamma ratio (1)"),
        Column("frequency (Hz)"),
        Column("energy (J)"),
        Column("before", "word"),
        Column("after", "word"),
    )
    rows = [
        (
            each["kind"],
            f"{each['gamma_ratio']:.6g}",
            f"{each['frequency_Hz']:.8g}",
            f"{each['energy_J']:.6g}",
            _stable(each["stable_before"]),
            _stable(each["stable_after"]),
        )
        for each in found
    ]
    content: tuple[Html, ...] = ()
    if rows:
        content += (table(columns, rows, label="Bifurcations"),)
    content += tuple(paragraph(sentence) for sentence in _unlocated(results.summary))
    return Section(
        "bifurcations",
        "Bifurcations",
        content,
        _none(results, "no change of stability was found along the branch."),
    )


def _unlocated(summary: dict[str, Any]) -> list[str]:
    """Changes of stability whose place was not found."""
    return [
        f"Between gamma ratios {low:.6g} and {high:.6g} the stability changes; where and how was "
        "not found."
        for low, high in summary.get("bifurcations_not_located", [])
    ]


def _none(results: Results, sentence: str) -> str:
    return sentence if results.summary else "the run was stopped before its summary."


def _list(ratios: Sequence[float]) -> str:
    return ", ".join(f"{ratio:.6g}" for ratio in ratios) or "none"


def _stable(stable: bool) -> str:
    return "stable" if stable else "unstable without damping"
