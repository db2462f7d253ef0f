"""The numbers that are asked for first, and what to do next."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fenics_nnm.backbone.point import VERIFIED, BranchPoint
from fenics_nnm.output.engine_orders import orders_near, turns_a_second
from fenics_nnm.output.html_report.elements import bullets, paragraph
from fenics_nnm.output.html_report.page import Section
from fenics_nnm.output.html_report.words import hardening, plain, signed
from fenics_nnm.output.pictures.amplitude import amplitude_of
from fenics_nnm.output.pictures.results import Results
from fenics_nnm.results.tables import COLUMNS


def headlines(results: Results) -> list[tuple[str, str]]:
    """Names and numbers: the linear mode, first contact, and the largest motion to be trusted.

    Numbers of motions are those of `Results.trusted`, which are verified wherever there are some.
    """
    points, trusted = results.points, results.trusted
    farthest = max(trusted, key=lambda point: abs(hardening(point)))
    rises = hardening(farthest) >= 0
    extreme, change = ("Highest", "hardening") if rises else ("Lowest", "softening")
    largest = max(trusted, key=lambda point: point.motion.energy)
    verified = sum(point.status == VERIFIED for point in points)
    return [
        (f"Linear mode {results.header.mode}", f"{results.linear_frequency:.6g} Hz"),
        *_first_contact(results),
        (f"{extreme} frequency ({farthest.status})", f"{farthest.motion.frequency:.6g} Hz"),
        (f"Largest {change} ({farthest.status})", f"{signed(hardening(farthest))} %"),
        (f"Largest motion ({largest.status})", f"{_moved(results, largest)} at {_energy(largest)}"),
        *_contact(largest),
        *_stress(largest),
        *_orders(results),
        ("Verified points", f"{verified} of {len(points)}"),
        *_yielding(points),
    ]


def _first_contact(results: Results) -> Iterator[tuple[str, str]]:
    energy = results.summary.get("grazing_energy_J")
    if energy:
        yield "First contact", f"{plain(energy)} J"


def _moved(results: Results, point: BranchPoint) -> str:
    """How far a motion goes, as the table of the points has it where that is known."""
    amplitude = amplitude_of(results)
    printed = COLUMNS["displacement_m"].printed(point)
    shown = amplitude.values[results.points.index(point)]
    moved = amplitude.unit.factor * float(printed) if printed else shown
    return f"{moved:.4g} {amplitude.unit.name}"


def _contact(point: BranchPoint) -> Iterator[tuple[str, str]]:
    """How hard and how long the largest motion touches."""
    force = point.motion.force.sum(axis=1).max(initial=0.0)
    if force > 0:
        share = 100 * point.motion.contact_fraction
        yield "Contact there", f"{plain(force)} N, {share:.3g} % of the period"


def _stress(point: BranchPoint) -> Iterator[tuple[str, str]]:
    """How hard the largest motion strains the body, and whether that is beyond its strength."""
    printed = COLUMNS["von_mises_Pa"].printed(point)
    if printed:
        beyond = COLUMNS["beyond"].printed(point)
        words = f"{1e-6 * float(printed):.4g} MPa von Mises"
        yield "Stress there", f"{words}, beyond {beyond}" if beyond else words


def _yielding(points: Sequence[BranchPoint]) -> Iterator[tuple[str, str]]:
    """How many points are beyond yield, whatever their status."""
    beyond = sum(point.extremes.yield_margin.value < 1 for point in points)
    if beyond:
        yield "Points beyond yield", f"{beyond} of {len(points)}, computed as elastic"


def _orders(results: Results) -> Iterator[tuple[str, str]]:
    """Engine orders that the curve meets, where the structure turns."""
    if not turns_a_second(results.header.values):
        return
    hertz = np.array([point.motion.frequency for point in results.points])
    met = orders_near(results.header.values, hertz)
    yield "Engine orders near", ", ".join(str(order.number) for order in met) or "none"


def _energy(point: BranchPoint) -> str:
    return f"{plain(point.motion.energy)} J"


def next_steps(results: Results) -> Section:
    """What the run proposes where points are not verified."""
    lines = [f"{line[0].upper()}{line[1:]}." for line in results.summary.get("advice", [])]
    content = (
        paragraph("Each line names a key of the study file and the value to try:"),
        bullets(lines),
    )
    return Section(
        "next", "Next steps", content if lines else (), "all points are verified, or not judged."
    )
