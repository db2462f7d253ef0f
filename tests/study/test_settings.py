"""Keys set outside a study file, and study files written from values."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from fenics_nnm.errors import StudyError
from fenics_nnm.study.settings import Setting, settings_from, with_settings
from fenics_nnm.study.toml_text import toml_text

ROOT = Path(__file__).parents[2]
FILES = [*ROOT.glob("demos/*/*.toml"), *ROOT.glob("fenics_nnm/templates/*.toml")]


@pytest.mark.parametrize("file", FILES, ids=[file.stem for file in FILES])
def test_a_study_file_is_written_as_it_was_read(file: Path) -> None:
    values = tomllib.loads(file.read_text())
    assert tomllib.loads(toml_text(values)) == values


def test_odd_values_are_written_as_they_were_read() -> None:
    values = {
        "title": 'quotes " and \\ and \n and \x7f and é',
        "contact": {"patch": [{"gap": 1e-300}, {"gap": -0.1, "casing": {"profile": [[0, 1.5]]}}]},
        "material": [{"young": 1e16, "a b": True}, {"young": 2.0}],
        "groups": {"the tip": {"z": 1}},
        "empty": {},
        "list": [],
    }
    assert tomllib.loads(toml_text(values)) == values


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("contact.gap=1e-4,2e-4", [1e-4, 2e-4]),
        ("contact.gap = 1e-4 , -2", [1e-4, -2]),
        ("reduction.method=massless,craig-bampton", ["massless", "craig-bampton"]),
        ('mesh.file="a,b.msh",c.msh', ["a,b.msh", "c.msh"]),
        ("mesh.file=../a.msh", ["../a.msh"]),
        ("contact.direction=[1.0, 0.0],[0.0, 1.0]", [[1.0, 0.0], [0.0, 1.0]]),
        (
            "continuation.energies={ from = 0.8, to = 2 },{from=0.9,to=3}",
            [{"from": 0.8, "to": 2}, {"from": 0.9, "to": 3}],
        ),
        ("continuation.shooting=true,false", [True, False]),
        ('mode.harmonics="auto",5', ["auto", 5]),
    ],
)
def test_lists_of_values(text: str, values: list[Any]) -> None:
    found = settings_from(text)
    assert [setting.value for setting in found] == values
    assert [type(setting.value) for setting in found] == [type(value) for value in values]
    assert len({setting.key for setting in found}) == 1
    for setting in found:
        assert settings_from(setting.argument) == (setting,)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("contact.gap", "--set contact.gap: must be KEY=VALUE"),
        ("contact.gap=", "must be KEY=VALUE"),
        ("=3", "must be KEY=VALUE"),
        ("contact..gap=3", r"contact\.\.gap: is no key"),
        ("contact gap=3", "is no key"),
        ("contact.gap=1e-4,", "must be a value of TOML"),
        ("contact.gap=1 2", "must be a value of TOML"),
        ("contact.gap=[1", "must be a value of TOML"),
    ],
)
def test_what_is_no_setting(text: str, words: str) -> None:
    with pytest.raises(StudyError, match=words):
        settings_from(text)


def test_keys_are_set_in_a_copy() -> None:
    values: dict[str, Any] = {"contact": {"patch": [{"gap": 1.0}, {"gap": 2.0}]}, "mode": {}}
    found = with_settings(
        values, [Setting("contact.patch[2].gap", 3.0), Setting("output.frames", 30)]
    )
    assert found["contact"]["patch"] == [{"gap": 1.0}, {"gap": 3.0}]
    assert found["output"] == {"frames": 30}
    assert values == {"contact": {"patch": [{"gap": 1.0}, {"gap": 2.0}]}, "mode": {}}


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("contact.patch[3].gap", r"contact\.patch\[3\]: there is none: the study has 1"),
        ("contact.patch[0].gap", "there is none"),
        ("contact.patch.gap", r"contact\.patch: there are 1: must name one"),
        ("mode.number.x", "mode.number = 2: is no section"),
        ("mode[1]", "names a section: must name one of its keys"),
    ],
)
def test_keys_that_lead_nowhere(key: str, words: str) -> None:
    values: dict[str, Any] = {"contact": {"patch": [{"gap": 1.0}]}, "mode": {"number": 2}}
    with pytest.raises(StudyError, match=words):
        with_settings(values, [Setting(key, 1)])
