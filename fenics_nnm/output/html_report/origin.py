"""Sections about where the results come from: study file, versions, seconds."""

from __future__ import annotations

from fenics_nnm.output.html_report.elements import (
    Column,
    Html,
    bullets,
    element,
    paragraph,
    table,
    text,
)
from fenics_nnm.output.html_report.page import Section
from fenics_nnm.output.html_report.words import plain
from fenics_nnm.output.pictures.results import Results


def study_file(results: Results) -> Section:
    """Text of the study file."""
    code = element("pre", element("code", text(results.header.study)), tabindex="0")
    return Section("study", "Study file", (code, *_mesh_notes(results)))


def _mesh_notes(results: Results) -> tuple[Html, ...]:
    """What was left out or changed on reading the mesh, if anything was."""
    notes = results.summary.get("mesh_notes", [])
    if not notes:
        return ()
    return element("h3", text("What was changed or left out of the mesh file")), bullets(notes)


def versions(results: Results) -> Section:
    """Versions of the program and its libraries, and how long the stages took."""
    columns = (Column("program or library", "word"), Column("version", "word"))
    content: tuple[Html, ...] = (
        table(columns, sorted(results.header.versions.items()), label="Versions"),
    )
    timings = results.summary.get("timings", {})
    if timings:
        total = sum(timings.values())
        rows = [(stage, plain(seconds, 3)) for stage, seconds in timings.items()]
        content += (
            paragraph(f"The run took {plain(total, 3)} s:"),
            table((Column("stage", "word"), Column("time (s)")), rows, label="Timings"),
        )
    return Section("versions", "Versions and timings", content)
