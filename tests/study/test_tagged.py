"""Sections whose keys depend on one of them: what they say of other keys, and what they mean."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PLATE, ROD, Ended, changed

from fenics_nnm.backbone.follow import ArcContinuation, EnergyContinuation, FrequencyContinuation
from fenics_nnm.study import study_from
from fenics_nnm.study.record import Record

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

OTHER_KEYS = [
    ({"reduction": {"interface": "all"}}, 'reduction.interface: needs method = "craig-bampton"'),
    (
        {"reduction": {"method": "none", "interface": "all"}},
        'reduction.interface: does not belong: reduction.method = "none" has no interface: '
        'needs method = "craig-bampton"',
    ),
    (
        {"continuation": {"start": {"file": "a.h5"}}},
        'continuation.start: needs parameter = "arc-length" or internal_resonance = "follow"',
    ),
    (
        {"continuation": {"=": {"parameter": "arc-length", "internal_resonance": "skip"}}},
        "continuation.internal_resonance = \"skip\": must be 'follow' (with parameter = "
        '"arc-length", which follows the branch wherever it leads, only "follow")',
    ),
    (
        {"continuation": {"parameter": "arc-length", "energies": {"step": 0.1}}},
        'continuation.energies.step: has no effect with parameter = "arc-length": steps are those '
        "of arc_length",
    ),
    (
        {"body": {"theory": "solid"}},
        'body.area: does not belong: body.theory = "solid" has no area: needs theory = "rod"',
    ),
    (
        {"body": {"area": None}},
        'body.area: is missing: body.theory = "rod" needs area (cross-section of a rod in m^2)',
    ),
    (
        {"reduction": {"method": "guyan"}},
        "reduction.method = \"guyan\": must be 'massless', 'craig-bampton' or 'none' "
        '("massless" (free modes, residual flexibility), "craig-bampton", or "none")',
    ),
    ({"reduction": {"method": "none", "mods": 3}}, 'unknown key: did you mean "modes"?'),
]


@pytest.mark.parametrize(("changes", "line"), OTHER_KEYS)
def test_key_of_another_kind(
    changes: dict[str, Any], line: str, study_file: StudyFile, command: Command
) -> None:
    command("check", study_file(**changes)).assert_one_line(2, line)


def study_of(**changes: Any) -> Any:
    return study_from(changed(PLATE, changes), Path("study.toml"))


@pytest.mark.parametrize(
    ("continuation", "kind", "bounds"),
    [
        ({"energies": {"from": 0.8, "to": 1.2, "step": 0.2}}, EnergyContinuation, (0.8, 1.2, 0.2)),
        (
            {"parameter": "frequency", "frequencies": {"from": 1.01, "to": 1.1}},
            FrequencyContinuation,
            (1.01, 1.1, 0.005),
        ),
        ({"parameter": "arc-length"}, ArcContinuation, (0.7, 3.0, None)),
        ({"internal_resonance": "follow"}, ArcContinuation, (0.7, 3.0, 0.1)),
    ],
)
def test_motions_that_a_continuation_wants(
    continuation: dict[str, Any], kind: type, bounds: tuple[float, ...]
) -> None:
    study = study_of(continuation={"=": {**continuation, "report_at": [1.1]}})
    wanted = study.continuation.wanted(3)
    assert type(wanted) is kind
    assert (wanted.start, wanted.stop, wanted.step) == bounds
    assert wanted.report_at == (1.1,)
    assert wanted.harmonic == (3 if kind is ArcContinuation else 1)


@pytest.mark.parametrize(
    ("reduction", "law", "carries_mass"),
    [
        ({}, None, False),
        ({"method": "craig-bampton"}, None, True),
        ({"method": "none"}, None, False),
        ({"method": "none"}, "augmented-lagrangian", True),
    ],
)
def test_contact_points_carry_mass_by_reduction_and_law(
    reduction: dict[str, Any], law: str | None, carries_mass: bool
) -> None:
    study = study_of(reduction=reduction, contact={"law": law} if law else {})
    assert study.carries_mass == carries_mass
    assert study.full_order == (reduction.get("method") == "none")


def test_casing_sections_give_their_surfaces() -> None:
    """Distances along y from a point at y = 0.1 to surfaces about the x axis."""
    places, up = np.array([[0.5, 0.1, 0.0]]), np.array([[0.0, 1.0, 0.0]])
    axis = {"axis": "x", "radius": 0.2}
    cases = [
        ({"shape": "cylinder", **axis}, 0.1),
        ({"shape": "cone", **axis, "end_radius": 0.4, "length": 1.0}, 0.2),
        ({"shape": "lobed", **axis, "lobes": 2, "amplitude": 0.05}, 0.15),
        ({"shape": "plane", "origin": [0.0, 0.3, 0.0], "normal": [0.0, 1.0, 0.0]}, 0.2),
    ]
    for casing, expected in cases:
        contact = {"facets": "right", "direction": "casing", "casing": casing}
        section = study_of(contact={"=": contact}).contact.casing
        assert section.surface().distance(places, up) == pytest.approx(expected, rel=1e-12)


def test_keys_that_are_absent_for_a_reason_are_no_keys() -> None:
    """Reasons for absent keys would never be read if the record had the key."""

    def below(record: type[Record]) -> list[type[Record]]:
        return [record, *(each for kind in record.__subclasses__() for each in below(kind))]

    study_from(dict(ROD), Path("study.toml"))
    with_reasons = [record for record in below(Record) if record.absent]
    assert len(with_reasons) >= 6
    for record in with_reasons:
        assert not record.absent.keys() & record.model_fields.keys(), record


BY_FREQUENCY = {"parameter": "frequency", "frequencies": {"from": 1.01, "to": 1.1}}


@pytest.mark.parametrize(
    ("continuation", "samples", "words"),
    [
        ({}, 7, "raise mode.samples = 7,"),
        ({}, 64, "mode.harmonics, or fewer reduction.modes"),
        (BY_FREQUENCY, 128, "beyond the frequencies that were found; another"),
        (BY_FREQUENCY, 9, "beyond the frequencies that were found; raise mode"),
        ({"parameter": "arc-length"}, 128, "keys of continuation.arc_length"),
        ({"internal_resonance": "follow"}, 9, "raise mode.samples = 9,"),
    ],
)
def test_keys_are_named_where_motions_are_missing(
    continuation: dict[str, Any], samples: int, words: str
) -> None:
    assert words in study_of(continuation={"=": continuation}).continuation.advice(samples)
