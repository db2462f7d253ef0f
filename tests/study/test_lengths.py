"""Lengths with a unit, and the unit of those without: the same study however it is written."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import pytest
from conftest import BEAM, PLATE, ROD, changed
from pydantic import BaseModel

from fenics_nnm.errors import StudyError
from fenics_nnm.geometry import Rod
from fenics_nnm.geometry.lengths import METRES, LengthUnit, converted
from fenics_nnm.geometry.parameters import GeometryRecord
from fenics_nnm.results.resume import difference
from fenics_nnm.study import Study, study_from
from fenics_nnm.study.record import Record
from fenics_nnm.study.settings import Setting, settings_from
from fenics_nnm.study.toml_text import toml_text
from fenics_nnm.study.units import in_its_unit

#: A beam with a length at every kind of place, in m.
EVERYWHERE: dict[str, Any] = changed(
    BEAM,
    {
        "groups": {
            "tip": {
                "x": 1.0,
                "tolerance": 1e-4,
                "plane": {"point": [1.0, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]},
                "box": {"from": [0.9, 0.0, 0.0], "to": [1.0, 0.2, 0.2]},
            },
            "rim": {
                "cylinder": {"axis": "x", "origin": [0.0, 0.1, 0.1], "radius": 0.3},
                "radii": {"axis": [1.0, 0.0, 0.0], "from": 0.0, "to": 0.3},
                "nearest": {"point": [1.0, 0.0, 0.0], "angle": 20},
            },
        },
        "mass": {"at": [1.0, 0.0, 0.0], "mass": 2.0},
        "rigid": {"facets": "top", "at": [0.5, 0.0, 0.2], "mass": 3.0},
        "spring": {"at": [1.0, 0.0, 0.0], "stiffness": [1.0, 1.0, 1.0]},
        "excitation": {"at": [1.0, 0.0, 0.0], "force": [1.0, 0.0, 0.0]},
        "contact": {
            "gap": None,
            "reference_displacement": 1e-4,
            "direction": "radial",
            "axis": "x",
            "origin": [0.0, 0.05, 0.05],
            "casing": {
                "shape": "lobed",
                "axis": "x",
                "origin": [0.0, 0.05, 0.05],
                "clearance": -1e-4,
                "lobes": 2,
                "amplitude": 1e-4,
                "profile": [[0.0, 0.3], [1.0, 0.4]],
            },
        },
    },
)

#: Keys whose numbers are no lengths, in EVERYWHERE.
NO_LENGTHS = ("normal", "axis", "angle", "mass", "stiffness", "force", "lobes", "elements")

IN_M = study_from(EVERYWHERE, Path("study.toml"))


def study(base: dict[str, Any], **changes: Any) -> Study:
    return study_from(changed(base, changes), Path("study.toml"))


def rewritten(value: Any, write: Any) -> Any:
    """Values with all numbers that are lengths written in another way."""
    if isinstance(value, dict):
        return {
            key: each
            if key in NO_LENGTHS and not isinstance(each, dict)
            else rewritten(each, write)
            for key, each in value.items()
        }
    if isinstance(value, list):
        return [rewritten(each, write) for each in value]
    return write(value) if isinstance(value, float) else value


def everywhere(write: Any, **more: Any) -> Study:
    sections = ("groups", "mass", "rigid", "spring", "excitation", "contact", "mesh")
    values = {name: rewritten(EVERYWHERE[name], write) for name in sections}
    return study_from({**EVERYWHERE, **values, **more}, Path("study.toml"))


def mm(value: float) -> float:
    return converted(value, "m", "mm")


def test_a_unit_may_stand_wherever_a_length_stands() -> None:
    assert everywhere(lambda value: f"{mm(value)!r} mm") == IN_M
    assert everywhere(lambda value: f"{mm(value)!r}mm") == IN_M


def test_numbers_are_in_the_unit_of_the_study() -> None:
    found = everywhere(mm, length_unit="mm")
    assert found.contact == IN_M.contact
    assert found.groups == IN_M.groups
    assert (found.mass, found.spring, found.excitation) == (IN_M.mass, IN_M.spring, IN_M.excitation)
    assert found.rigid == IN_M.rigid
    assert found.mesh.length_unit == "mm"  # of [mesh] too, which has no unit of its own
    assert found.mesh.length == 1000.0
    assert found.body == IN_M.body


def test_the_mesh_keeps_its_own_unit() -> None:
    found = study(
        ROD, length_unit="mm", mesh={"length_unit": "in", "length": 2.0}, contact={"gap": 0.3}
    )
    assert (found.mesh.length, found.mesh.length_unit) == (2.0, "in")
    assert found.contact.gap == 3e-4
    assert study(ROD, mesh={"length_unit": "in", "length": "50.8 mm"}).mesh.length == 2.0
    assert study(PLATE, body={"thickness": "2 mm"}).body.thickness == 2e-3


def test_a_mesh_file_without_a_unit_has_that_of_the_study() -> None:
    file = {"=": {"file": "a.step", "element_size": "1 cm", "refine": []}}
    refine = [{"facets": "tip", "size": "500 um", "distance": 4.0}]
    file["="]["refine"] = refine
    found = study(BEAM, length_unit="mm", mesh=file).mesh
    assert (found.length_unit, found.element_size) == ("mm", 10.0)
    assert (found.refine[0].size, found.refine[0].distance) == (0.5, 4.0)


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("0.3 mm", 3e-4),
        ("-.5um", -5e-7),
        ("5 \u00b5m", 5e-6),
        ("5 \u03bcm", 5e-6),
        ("1e-2 cm", 1e-4),
        ("+1. in", 0.0254),
        ("10 mil", 2.54e-4),
        ("2 ft", 0.6096),
        ("3 m", 3.0),
    ],
)
def test_units(text: str, metres: float) -> None:
    assert study(ROD, contact={"gap": text}).contact.gap == metres
    assert settings_from(f"contact.gap={text}") == (Setting("contact.gap", text),)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"contact": {"gap": "5 furlong"}}, 'contact.gap = "5 furlong": the unit "furlong" is not'),
        (
            {"contact": {"gap": "5 MM"}},
            'contact.gap = "5 MM": the unit "MM" is not known: must be ',
        ),
        ({"contact": {"gap": "5"}}, 'contact.gap = "5": must be a number, or a number with a unit'),
        (
            {"contact": {"gap": "1e-3"}},
            'contact.gap = "1e-3": must be a number, or a number with a',
        ),
        ({"contact": {"gap": "mm"}}, 'contact.gap = "mm": must be a number, or'),
        ({"contact": {"gap": "nan mm"}}, 'contact.gap = "nan mm": must be a number, or'),
        ({"contact": {"gap": "1e400 mm"}}, 'contact.gap = "1e400 mm": must be '),
        ({"contact": {"gap": "1 mm" + "x" * 10**6}}, "must be a number, or"),
        ({"contact": {"gap": "1" * 10**6}}, "must be a number, or"),
        ({"mesh": {"length": "-1 mm"}}, 'mesh.length = "-1 mm": must be greater than 0'),
        ({"mesh": {"length": "1 kg"}}, 'mesh.length = "1 kg": the unit "kg" is not known'),
        ({"length_unit": "furlong"}, 'length_unit = "furlong": must be m, cm, mm, um, in, ft or'),
        ({"length_unit": 3}, "length_unit = 3: must be m, cm"),
        ({"length_unit": "mil", "contact": {"gap": True}}, "(initial gap in mil, negative"),
        ({"length_unit": "mm", "mesh": {"length": 10**400}}, "mesh.length = 1000"),
        ({"length_unit": "mm", "contact": {"gap": True}}, "contact.gap = true: must be a number"),
        (
            {"groups": {"a": {"box": {"from": [0.0], "to": ["1 parsec"]}}}},
            "groups.a.box.to = ['1 parsec']: the unit \"parsec\" is not known",
        ),
    ],
)
def test_what_is_no_length(changes: dict[str, Any], line: str) -> None:
    with pytest.raises(StudyError) as error:
        study(ROD, **changes)
    assert line in str(error.value)
    assert len(str(error.value)) < 400
    assert "\n" not in str(error.value)


def test_gaps_of_matrices() -> None:
    files = {"stiffness": "K.npy", "mass": "M.npy", "contact_rows": "B.npy"}
    values = {"matrices": files, "contact": {"gap": ["1 mm", 2.0]}, "reduction": {"modes": 2}}
    found = study_from({**values, "length_unit": "cm"}, Path("study.toml"))
    assert found.contact.gap == (1e-3, 2e-2)
    values["contact"]["gap"] = ["1 mm", "2 mn"]
    with pytest.raises(StudyError, match='the unit "mn" is not known'):
        study_from(values, Path("study.toml"))


def test_a_unit_of_a_geometry_needs_a_study() -> None:
    with pytest.raises(ValueError, match="outside of a study file"):
        Rod(length="5 mm", length_unit="mm", elements=2)


def test_all_units_are_known_everywhere() -> None:
    assert set(get_args(LengthUnit)) == set(METRES)
    for value in (0.1, 0.3, 1 / 3, 7e-300):
        for unit in METRES:
            there = converted(value, "m", unit)
            assert converted(there, unit, "m") == pytest.approx(value, rel=1e-15)
            assert there == pytest.approx(value / METRES[unit], rel=1e-15)


def test_points_of_a_study_are_those_of_the_same_study_in_other_units() -> None:
    same = toml_text(changed(ROD, {"contact": {"gap": "1 mm"}}))
    in_mm = {"length_unit": "mm", "contact": {"gap": 1}}
    assert difference(toml_text(ROD), same) == ""
    assert difference(same, toml_text(changed(ROD, in_mm))) == ""
    other = toml_text(changed(ROD, {"contact": {"gap": "2 mm"}}))
    assert difference(same, other) == "contact.gap was 0.001 and is 0.002 now"


@pytest.mark.parametrize(
    ("key", "given", "shown"),
    [
        ("contact.gap", "0.3 mm", 3e-4),
        ("contact.gap", 3.0, 3e-3),
        ("mesh.length", "2 m", 2000.0),
        ("mesh.length", 2000, 2000),
        ("groups.tip.box.to", ["1 m", 2.0], [1.0, 2e-3]),
        ("material.young", 1e11, 1e11),
        ("continuation.energies.to", 1.5, 1.5),
    ],
)
def test_settings_are_shown_in_the_unit_of_their_key(key: str, given: Any, shown: Any) -> None:
    box = {"from": [0.0, 0.0], "to": [1.0, 1.0]}
    mm = {"length_unit": "mm"}
    values = changed(ROD, {**mm, "mesh": mm, "groups": {"tip": {"box": box}}})
    *sections, last = key.split(".")
    holder: Any = values
    for name in sections:
        holder = holder[name]
    holder[last] = given
    found = in_its_unit(study_from(values, Path("study.toml")), Setting(key, given))
    assert found == shown
    assert type(found) is type(shown)


def records(kind: type[BaseModel]) -> Iterator[type[BaseModel]]:
    for below in kind.__subclasses__():
        yield from (below, *records(below))


def test_no_key_in_m_is_without_units() -> None:
    """Each key that is described as a length takes one with a unit."""
    keys = {
        f"{record.__name__}.{name}": "_in_" in f"{field.annotation} {field.metadata}"
        for kind in (Record, GeometryRecord)
        for record in records(kind)
        for name, field in record.model_fields.items()
        if re.search(r"\bin (m|length_unit)\b(?!\^)", field.description or "")
        and field.annotation is not bool
    }
    assert len(keys) > 50
    assert [key for key, takes in keys.items() if not takes] == []
