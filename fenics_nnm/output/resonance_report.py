"""resonance.csv: the damped backbone, motions in phase resonance."""

from __future__ import annotations

import csv
import io
import itertools
import math
from collections.abc import Iterator

from fenics_nnm.response.phase_resonance import DampedBackbone, Resonance

#: Columns of resonance.csv; other programs rely on the names.
COLUMNS = (
    "level",
    "branch",
    "point",
    "frequency_Hz",
    "speed_rad_s",
    "amplitude_m",
    "max_m",
    "contact_fraction",
    "resonance_force_N",
    "damping_ratio",
    "largest_multiplier",
    "stability",
    "energy_balance",
    "event",
    "status",
    "reason",
)


def resonance_table(backbone: DampedBackbone) -> str:
    """The text of resonance.csv; displacements are those of the first excited place."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(_rows(backbone))
    return text.getvalue()


def _rows(backbone: DampedBackbone) -> Iterator[list[str]]:
    for _, own in itertools.groupby(backbone.points, key=lambda each: each.point.branch):
        for number, each in enumerate(own, start=1):
            yield _row(each, number)


def _row(resonance: Resonance, number: int) -> list[str]:
    """A motion; empty where there is no number."""
    point = resonance.point
    return [
        f"{point.level:.12g}",
        str(point.branch),
        str(number),
        f"{point.frequency:.12g}",
        known(point.speed),
        f"{point.amplitude[0]:.12g}",
        f"{point.displacements.highest[0]:.12g}",
        f"{point.displacements.contact[0]:.12g}",
        f"{resonance.force:.12g}",
        f"{resonance.damping_ratio:.12g}",
        known(point.judgement.largest_multiplier),
        point.judgement.stability,
        f"{point.imbalance:.2e}",
        point.event,
        point.status,
        point.reason,
    ]


def known(value: float) -> str:
    """A number in 12 digits; nothing for one that is not known."""
    return "" if math.isnan(value) else f"{value:.12g}"
