"""The report of a response: curves, peaks, folds, verdicts, balance of work, damped backbone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fenics_nnm import __version__
from fenics_nnm.output.html_report.elements import (
    Column,
    Html,
    bullets,
    described,
    element,
    facts,
    paragraph,
    table,
    text,
)
from fenics_nnm.output.html_report.figures import Gallery
from fenics_nnm.output.html_report.page import Section, page, write_page
from fenics_nnm.output.response_gallery import make_response_pictures, stored_response
from fenics_nnm.response.peaks import Peak
from fenics_nnm.response.point import ResponsePoint, Status
from fenics_nnm.results.response_file import StoredResponse

_MEANINGS = {
    Status.EXACT: "nothing touches: the linear equations are solved",
    Status.VERIFIED: "followed in time it returns, and the exact motion near it is the same",
    Status.CONVERGED: "the harmonic equations are solved; it is not confirmed in time that tightly",
    Status.TOUCHES: "a gap would close, and contact cannot be followed: no numbers",
    Status.FAILED: "the iteration did not converge, or the motion is none in time: not to be used",
}

_PEAKS = (
    Column("level"),
    Column("peak of", "word"),
    Column("frequency (Hz)"),
    Column("amplitude, 0-peak (m)"),
    Column("lag (deg)"),
)

_EVENTS = (
    Column("level"),
    Column("branch"),
    Column("what", "word"),
    Column("frequency (Hz)"),
    Column("speed (rad/s)"),
    Column("amplitude, 0-peak (m)"),
    Column("lag (deg)"),
    Column("status", "word"),
    Column("stability", "word"),
)

_RESONANCES = (
    Column("level"),
    Column("branch"),
    Column("frequency (Hz)"),
    Column("speed (rad/s)"),
    Column("force, 0-peak (N)"),
    Column("amplitude, 0-peak (m)"),
    Column("contact (% of period)"),
    Column("damping ratio (%)"),
    Column("status", "word"),
    Column("stability", "word"),
    Column("remark", "prose"),
)


def write_response_report(results: Path, file: Path) -> None:
    """Write one HTML file about a response; it needs no other file and no network.

    Args:
        results: Folder of a response.
        file: File to write.

    Raises:
        OutputError: if there is no response to report, or the file cannot be written.
    """
    stored = stored_response(results)
    with TemporaryDirectory() as scratch:
        drawn = Path(scratch)
        gallery = Gallery(drawn, make_response_pictures(results, drawn, formats=("svg",)))
        written = _page(stored, gallery)
    write_page(file, written)


def _page(stored: StoredResponse, gallery: Gallery) -> str:
    return page(
        title=str(stored.header.values.get("title", "")) or "Response",
        kicker="Driven, damped motions in unilateral contact",
        generator=f"fenics_nnm {__version__}",
        footer=f"Written by fenics-nnm report, version {__version__}, from response.h5. SI units "
        "unless a column says otherwise; amplitudes are those of the first harmonic, 0-peak.",
        sections=[
            _overview(stored),
            Section("curve", "Response over frequency", gallery.figures("frequency")),
            _peaks(stored),
            _events(stored),
            _resonances(stored),
            _trust(stored),
            _places(stored),
            Section("study", "Study file", (_study(stored),)),
            _versions(stored),
        ],
    )


def _overview(stored: StoredResponse) -> Section:
    """The response in figures, and what to beware of."""
    points = stored.found.points
    frequency = [point.frequency for point in points]
    shown = [point for point in points if point.found]
    touching = [p for p in shown if p.displacements.contact.max(initial=0.0) > 0]
    top = max(shown, key=lambda point: point.amplitude[0], default=None)
    largest = f"{top.amplitude[0]:.4g} m at {top.frequency:.6g} Hz" if top else "none"
    content: tuple[Html, ...] = (
        facts(
            [
                ("Frequencies", f"{min(frequency):.6g} to {max(frequency):.6g} Hz"),
                ("Levels", ", ".join(f"{level:g}" for level in stored.found.levels)),
                (f"Largest amplitude of {stored.watched.names[0]}", largest),
                ("Motions with contact", f"{len(touching)} of {len(points)}"),
                ("Resolution", str(stored.header.resolution)),
            ]
        ),
    )
    if stored.lines:
        heading = element("h3", text("Before you use these numbers"))
        content += (element("div", heading, bullets(stored.lines), class_="warnings"),)
    return Section("overview", "What was computed", content)


def _peaks(stored: StoredResponse) -> Section:
    rows = [_peak_row(stored, peak) for peak in stored.found.peaks]
    content = (table(_PEAKS, rows, label="Peaks"),) if rows else ()
    return Section("peaks", "Peaks", content, "no amplitude has a peak within the frequencies.")


def _peak_row(stored: StoredResponse, peak: Peak) -> tuple[str, ...]:
    return (
        f"{peak.level:g}",
        stored.watched.names[peak.monitor],
        f"{peak.frequency:.7g}",
        f"{peak.amplitude:.4g}",
        f"{peak.phase:.2f}",
    )


def _events(stored: StoredResponse) -> Section:
    """Folds, located peaks and branch points."""
    marked = [point for point in stored.found.points if point.event]
    rows = [(_level(point), str(point.branch), point.event, *_numbers(point)) for point in marked]
    content: tuple[Html, ...] = ()
    if any("fold" in point.event for point in marked):
        sentence = "Between two folds several motions belong to one frequency: a test jumps there."
        content = (paragraph(sentence),)
    if rows:
        content += (table(_EVENTS, rows, label="Folds and peaks"),)
    absent = "no curve has folds, or peaks with contact."
    return Section("events", "Folds and located peaks", content, absent)


def _numbers(point: ResponsePoint) -> tuple[str, ...]:
    return (
        f"{point.frequency:.7g}",
        _speed(point),
        f"{point.amplitude[0]:.4g}",
        f"{point.phase[0]:.2f}",
        str(point.status),
        point.judgement.stability or "not known",
    )


def _speed(point: ResponsePoint) -> str:
    """The speed of rotation that goes with the frequency; nothing where they are not tied."""
    return "" if np.isnan(point.speed) else f"{point.speed:.6g}"


def _level(point: ResponsePoint) -> str:
    return f"{point.level:.6g}"


def _resonances(stored: StoredResponse) -> Section:
    """The damped backbone at the levels of the curves, and where something happens on it."""
    found, levels = stored.found.backbone, stored.found.levels
    chosen = [each for each in found.points if each.point.event or each.point.level in levels]
    rows = [
        (
            _level(each.point),
            str(each.point.branch),
            f"{each.point.frequency:.7g}",
            _speed(each.point),
            f"{each.force:.4g}",
            f"{each.point.amplitude[0]:.4g}",
            f"{100 * each.point.displacements.contact[0]:.1f}",
            f"{100 * each.damping_ratio:.4g}",
            str(each.point.status),
            each.point.judgement.stability or "not known",
            each.point.event,
        )
        for each in chosen
    ]
    content: tuple[Html, ...] = ()
    if rows:
        sentence = (
            f"Of {len(found.points)} motions in phase resonance those at the levels of the curves "
            "are shown, and those where something happens. All are in resonance.csv."
        )
        content = (paragraph(sentence), table(_RESONANCES, rows, label="Phase resonances"))
    return Section("backbone", "Damped backbone", content, "it was not followed, or not found.")


def _trust(stored: StoredResponse) -> Section:
    """Verdicts, stability and the balance of work, level by level."""
    found = stored.found
    there = [status for status in Status if any(p.status is status for p in found.points)]
    columns = [Column("level"), *(Column(str(each)) for each in there)]
    columns += [Column(name) for name in ("stable", "unstable", "stability not known")]
    columns.append(Column("largest imbalance of work"))
    rows = [_trust_row(level, found.at_level(level), there) for level in found.levels]
    content = (
        table(columns, rows, label="Numbers of motions"),
        described((str(status), _MEANINGS[status]) for status in there),
        paragraph(
            "The work of the forces over a period is what damping takes out; the imbalance is "
            "their difference over the work. A motion with more than 1e-6 is called failed."
        ),
        *_kinds(found.points),
    )
    return Section("trust", "How far to trust them", content)


def _trust_row(
    level: float, points: Sequence[ResponsePoint], there: Sequence[Status]
) -> tuple[str, ...]:
    statuses = Counter(point.status for point in points)
    known = [point.judgement.stability for point in points]
    stable, unknown = known.count("stable"), known.count("")
    largest = max((point.imbalance for point in points if point.found), default=float("nan"))
    counts = (*(statuses[each] for each in there), stable, len(known) - stable - unknown, unknown)
    return (f"{level:g}", *map(str, counts), f"{largest:.1e}" if np.isfinite(largest) else "")


def _kinds(points: Sequence[ResponsePoint]) -> Iterator[Html]:
    """Kinds of instability, with how many motions have each."""
    kinds = Counter(p.judgement.stability for p in points)
    listed = [f"{kind}: {number}" for kind, number in kinds.items() if kind not in ("", "stable")]
    if listed:
        yield paragraph("Unstable motions, which a test does not show, by kind:")
        yield bullets(listed)


def _places(stored: StoredResponse) -> Section:
    """How far each place moves at each level."""
    levels = stored.found.levels
    columns = [Column("place", "word")]
    columns += [Column(f"largest amplitude at level {level:g} (m)") for level in levels]
    rows = [
        (name, *(_largest(stored.found.at_level(level), place) for level in levels))
        for place, name in enumerate(stored.watched.names)
    ]
    return Section("places", "Places", (table(columns, rows, label="Amplitudes of places"),))


def _largest(points: Sequence[ResponsePoint], place: int) -> str:
    found = [float(point.amplitude[place]) for point in points if point.found]
    return f"{max(found):.4g}" if found else "none"


def _study(stored: StoredResponse) -> Html:
    return element("pre", element("code", text(stored.header.study)), tabindex="0")


def _versions(stored: StoredResponse) -> Section:
    columns = (Column("program or library", "word"), Column("version", "word"))
    content = (table(columns, sorted(stored.header.versions.items()), label="Versions"),)
    return Section("versions", "Versions", content)
