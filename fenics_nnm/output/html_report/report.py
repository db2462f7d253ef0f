"""The report of a results folder, from its files alone."""

from __future__ import annotations

import os
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import quote

from fenics_nnm import __version__
from fenics_nnm.output.gallery import make_pictures
from fenics_nnm.output.html_report import contact, curve, origin, trust
from fenics_nnm.output.html_report.campbell import campbell
from fenics_nnm.output.html_report.elements import Html, bullets, element, facts, paragraph, text
from fenics_nnm.output.html_report.figures import Gallery
from fenics_nnm.output.html_report.headlines import headlines, next_steps
from fenics_nnm.output.html_report.page import Section, page, write_page
from fenics_nnm.output.html_report.words import sentences, title_of, warnings
from fenics_nnm.output.live_motion.figure import live_figure
from fenics_nnm.output.pictures.results import Results, read_results
from fenics_nnm.results.tables import write_backbone


def write_report(folder: Path, file: Path) -> None:
    """Write one HTML file about a results folder; it needs no other file and no network.

    Args:
        folder: Results folder of a run, of a mesh or of matrices.
        file: File to write.

    Raises:
        OutputError: if there is no branch to report, or the file cannot be written.
    """
    results = read_results(folder)
    with TemporaryDirectory() as scratch:
        drawn = Path(scratch) / "pictures"
        gallery = Gallery(drawn, make_pictures(folder, drawn, formats=("svg",)))
        points = Path(scratch) / "backbone.csv"
        write_backbone(points, results.points)
        text = _page(results, gallery, points, _beside(folder, file), campbell(folder))
    write_page(file, text)


def _beside(folder: Path, file: Path) -> str:
    """Address of backbone.csv relative to the page; empty if there is none."""
    table = folder / "backbone.csv"
    if not table.exists():
        return ""
    return quote(os.path.relpath(table.resolve(), file.parent.resolve()))


def _page(
    results: Results, gallery: Gallery, points: Path, beside: str, further: tuple[Section, ...]
) -> str:
    """The text of the page, with further sections."""
    live, scripts = live_figure(results)
    return page(
        title=title_of(results),
        kicker=f"Nonlinear mode {results.header.mode} in unilateral contact",
        generator=f"fenics_nnm {__version__}",
        footer=f"Written by fenics-nnm report, version {__version__}, from branch.h5"
        f"{' and summary.json' if results.summary else ''}. SI units unless a column "
        "says otherwise; frequencies are those of the motion, not Rayleigh quotients.",
        sections=[
            _overview(results),
            next_steps(results),
            curve.curve(results, gallery),
            _motion(results, live, gallery),
            contact.contact(results, gallery),
            curve.points(results, points, beside),
            trust.verdicts(results),
            trust.certificate(results, gallery),
            curve.linear_frequencies(results, gallery),
            curve.families(results),
            curve.resonances(results),
            curve.bifurcations(results),
            *further,
            origin.study_file(results),
            origin.versions(results),
        ],
        scripts=scripts,
    )


def _overview(results: Results) -> Section:
    """What was computed, in figures and in words, and what to beware of."""
    content: tuple[Html, ...] = (facts(headlines(results)),)
    beware = warnings(results)
    if beware:
        heading = element("h3", text("Before you use these numbers"))
        content += (element("div", heading, bullets(beware), class_="warnings"),)
    content += tuple(paragraph(sentence) for sentence in sentences(results))
    return Section("overview", "What was computed", content)


def _motion(results: Results, live: Html, gallery: Gallery) -> Section:
    """The motion to turn and to play where that can be, and pictures of the body and of it."""
    why = "the structure is given by matrices, so there is no body to draw."
    if results.body is not None:
        why = "there are no pictures of it."
    shown = (*((live,) if live else ()), *gallery.figures("body", "motion"))
    return Section("motion", "Motion", shown, why)
