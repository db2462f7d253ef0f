"""Every wrong key of a study ends with one line that names it and says what would be right."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, nan
from pathlib import Path
from typing import Any

import pytest
from conftest import BEAM, PLATE, Ended

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

BLADE = {"model": "blade", "sections": "sections.csv", "element_size": 0.01}
FILE = {"file": "mesh.msh", "length_unit": "m"}
ENERGIES = "continuation.energies."


def mesh(**keys: Any) -> dict[str, Any]:
    """A mesh section in place of the whole one of the base study."""
    return {"mesh": {"=": keys}}


def energies(**keys: Any) -> dict[str, Any]:
    return {"continuation": {"energies": keys, "report_at": []}}


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"[mesh\n", ["is not TOML", "line 1"]),
        (b"title = 'a'\ntitle = 'b'\n", ["is not TOML", "line 2"]),
        (b"title = '\xff\xfe'\n", ["cannot be read", "utf-8"]),
        (b"", ["mesh: is missing"]),
    ],
)
def test_file_that_is_no_study(
    content: bytes, words: list[str], tmp_path: Path, command: Command
) -> None:
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    command("run", path).assert_one_line(2, str(path), *words)


@pytest.mark.parametrize("action", ["run", "check"])
def test_no_study_file(action: str, tmp_path: Path, command: Command) -> None:
    command(action, tmp_path / "none.toml").assert_one_line(2, "none.toml", "No such file")
    command(action, tmp_path).assert_one_line(2, str(tmp_path), "Is a directory")


UNKNOWN = [
    ({"titel": "x"}, "titel", "title"),
    ({"clmap": {"facets": "left"}}, "clmap", "clamp"),
    ({"material": {"youngs": 1.0}}, "material.youngs", "young"),
    ({"continuation": {"energies": {"form": 0.7}}}, ENERGIES + "form", "from"),
    ({"output": {"foldr": "x"}}, "output.foldr", "folder"),
    ({"mesh": {"elments": 3}}, "mesh.elments", "elements"),
    (mesh(model="plate", hight=1.0), "mesh.hight", "height"),
    (mesh(model="beam", tipscale=1.0), "mesh.tipscale", "tip_scale"),
    (mesh(model="blade", element_siz=1.0), "mesh.element_siz", "element_size"),
    (mesh(file="a.msh", lenght_unit="m"), "mesh.lenght_unit", "length_unit"),
]


@pytest.mark.parametrize(("changes", "key", "meant"), UNKNOWN)
def test_unknown_key_gets_a_suggestion(
    changes: dict[str, Any], key: str, meant: str, study_file: StudyFile, command: Command
) -> None:
    ended = command("run", study_file(**changes))
    ended.assert_one_line(2, f"study.toml: {key}: unknown key", f'did you mean "{meant}"?')


def test_unknown_key_without_a_likely_one_lists_the_keys(
    study_file: StudyFile, command: Command
) -> None:
    ended = command("run", study_file(continuation={"energies": {"zzz": 1}}))
    ended.assert_one_line(2, "continuation.energies.zzz", "from, to, step")


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        *[({section: None}, section) for section in ("mesh", "body", "material", "contact")],
        ({"body": {"theory": None}}, "body.theory"),
        ({"material": {"young": None}}, "material.young"),
        ({"contact": {"gap": None}}, "contact.gap"),
        ({"clamp": {"facets": None}}, "clamp.facets"),
        ({"mesh": {"elements": None}}, "mesh.elements"),
        ({"mesh": {"model": None}}, "mesh.model"),
        (mesh(file="a.msh"), "mesh.length_unit"),
        (mesh(model="blade", element_size=1.0), "mesh.sections"),
    ],
)
def test_missing(
    changes: dict[str, Any], key: str, study_file: StudyFile, command: Command
) -> None:
    command("run", study_file(**changes)).assert_one_line(2, f"study.toml: {key}: is missing")


NOT_POSITIVE = [
    ({section: {key: value}}, f"{section}.{key} = {value}", word)
    for section, key in (
        ("material", "young"),
        ("material", "density"),
        ("body", "area"),
        ("mesh", "length"),
    )
    for value, word in ((-1.0, "greater than 0"), (0.0, "greater than 0"), (nan, "finite"))
]

VALUES = [
    *NOT_POSITIVE,
    ({"material": {"young": inf}}, "material.young = inf", "finite"),
    ({"material": {"young": 1e300}}, "material.young = 1e+300", "less than or equal to 1e+30 ("),
    ({"material": {"young": "stiff"}}, 'material.young = "stiff"', "must be a number"),
    ({"material": {"young": True}}, "material.young = true", "must be a number"),
    ({"material": {"poisson": 0.5}}, "material.poisson = 0.5", "less than 0.5"),
    ({"material": {"poisson": -1.0}}, "material.poisson = -1.0", "greater than -1"),
    ({"material": {"poisson": nan}}, "material.poisson = nan", "must be"),
    ({"material": {"density": 1e-300}}, "material.density = 1e-300", "must be 1e-30 or more"),
    ({"contact": {"direction": [1e-300]}}, "contact.direction = [0.0]", "must not be zero"),
    (
        {"groups": {"a": {"facets": "b"}, "b": {"x": 1.0}}},
        'groups.a.facets = "b"',
        "must be one that the mesh has",
    ),
    ({"material": 3}, "material = 3", "must be a section"),
    ({"body": 0}, "body = 0", "must be a section"),
    ({"mesh": {"=": "rod"}}, 'mesh = "rod"', "must be a section"),
    ({"mesh": {"length_unit": "furlong"}}, 'length_unit = "furlong"', "'in', 'ft' or 'mil'"),
    (mesh(file="a.msh", length_unit="furlong"), 'length_unit = "furlong"', "'mm'"),
    (mesh(file=3, length_unit="m"), "mesh.file = 3", "name in quotes"),
    (
        mesh(model="cube"),
        'mesh.model = "cube"',
        '"rod", "beam", "plate", "fork", "shroud", "blade"',
    ),
    (mesh(model=["rod"]), "mesh.model = ['rod']", '"rod", "beam"'),
    (mesh(**{**BLADE, "edge_size": 1.0}), "mesh.edge_size = 1.0", "element_size"),
    ({"mesh": {"elements": 2.5}}, "mesh.elements = 2.5", "must be an integer"),
    ({"mesh": {"elements": 0}}, "mesh.elements = 0", "greater than 0"),
    ({"mesh": {"elements": 2**40}}, "mesh.elements = ", "less than or equal to 1000000"),
    ({"mesh": {"length": 1e300}}, "mesh.length = 1e+300", "less than or equal to"),
    ({"material": {"young": 10**400}}, "material.young = 1000", "must be a number"),
    (mesh(model="plate", length=1.0, height=1.0, elements=[1]), "elements = [1]", "too few"),
    (mesh(model="plate", length=1.0, height=1.0, elements=[1, 0]), "[1, 0]", "greater than 0"),
    ({"body": {"theory": "shell"}}, 'body.theory = "shell"', "'plane-stress'"),
    ({"body": {"area": None}}, 'body.theory = "rod"', "needs area"),
    ({"body": {"thickness": 0.1}}, 'body.theory = "rod"', "has no thickness"),
    (
        {"body": {"kinematics": "second-order"}},
        'body.kinematics = "second-order"',
        'a rod does not bend: must be "auto" or "linear"',
    ),
    ({"body": {"masters": [1]}}, "body.masters: has no effect", "a rod does not bend"),
    ({"body": {"degree": 3}}, "body.degree = 3", "1 or 2"),
    ({"body": {"degree": True}}, "body.degree = true", "1 or 2"),
    ({"body": {"degree": 10**30}}, "body.degree = 1000", "too large"),
    ({"clamp": {"facets": []}}, "clamp.facets = []", "too few items"),
    ({"rigid": [{"facets": "left", "at": [0.0]}]}, "rigid[1].facets", "has no effect on what"),
    ({"contact": {"facets": []}}, "contact.facets = []", "too few items"),
    ({"contact": {"facets": 3}}, "contact.facets = 3", "a list of names"),
    ({"contact": {"facets": [3]}}, "contact.facets = [3]", "a list of names"),
    ({"contact": {"gap": "wide"}}, 'contact.gap = "wide"', "in m"),
    ({"contact": {"gap": nan}}, "contact.gap = nan", "finite"),
    ({"contact": {"points": 0}}, "contact.points = 0", "positive number"),
    ({"contact": {"points": "some"}}, 'contact.points = "some"', '"all"'),
    ({"contact": {"direction": "up"}}, 'contact.direction = "up"', '"normal", "radial"'),
    ({"contact": {"direction": "w"}}, 'contact.direction = "w"', '"x", "-x", "y"'),
    ({"contact": {"direction": [nan]}}, "contact.direction = [nan]", "finite numbers"),
    ({"contact": {"direction": []}}, "contact.direction = []", "vector"),
    ({"contact": {"direction": [0.0]}}, "contact.direction = [0.0]", "must not be zero"),
    ({"contact": {"direction": "radial"}}, 'contact.direction = "radial"', "needs axis"),
    ({"contact": {"axis": "x"}}, "contact.axis", 'direction = "radial"'),
    ({"contact": {"direction": "radial", "axis": "w"}}, 'contact.axis = "w"', '"x", "y", "z"'),
    ({"reduction": {"modes": 3.0}}, "reduction.modes = 3.0", "a positive integer"),
    ({"reduction": {"modes": True}}, "reduction.modes = true", "a positive integer"),
    ({"reduction": {"method": "guyan"}}, 'reduction.method = "guyan"', "massless"),
    ({"mode": {"number": 0}}, "mode.number = 0", "from 1"),
    ({"mode": {"number": 3}}, "mode.number = 3", "reduction.modes = 2"),
    ({"mode": {"samples": 6}}, "mode.samples = 6 with harmonics = 3", "2 harmonics + 1 = 7"),
    ({"continuation": {"energies": 3}}, "continuation.energies = 3", "from, to, step"),
    (energies(**{"from": 2.0}), ENERGIES + "from = 2, to = 1.1", "below"),
    (energies(**{"from": 1.1}), ENERGIES + "from = 1.1, to = 1.1", "below"),
    (energies(**{"from": nan}), ENERGIES + "from = nan", "finite"),
    (energies(to=inf), ENERGIES + "to = inf", "finite"),
    (energies(step=0.0), ENERGIES + "step = 0.0", "greater than 0"),
    (energies(step=1e-9), ENERGIES + "step = 1e-09", "at most 100000 steps"),
    ({"continuation": {"report_at": [3.0]}}, "continuation.report_at = 3", "energies.to = 1.1"),
    ({"continuation": {"report_at": [0.1]}}, "continuation.report_at = 0.1", "energies.from"),
    ({"continuation": {"report_at": 1.0}}, "continuation.report_at = 1.0", "must be a list"),
    ({"continuation": {"report_at": [1.0, 1.0]}}, "report_at = [1.0, 1.0]", "must differ"),
    ({"continuation": {"report_at": ["2 kg"]}}, "continuation.report_at = '2 kg': the unit", "Hz"),
    ({"continuation": {"report_at": ["0 mm"]}}, "report_at = '0 mm': must be positive", ""),
    ({"continuation": {"report_values": ["2 kg"]}}, "report_values = ['2 kg']: the unit", "kPa"),
    ({"continuation": {"energies": ["2 Hz"]}}, "energies = '2 Hz': the unit", "J, mJ, uJ or kJ"),
    ({"continuation": {"energies": []}}, "continuation.energies = []", "an energy at least"),
    ({"damping": {"alpha": 1e-300}}, "damping.alpha = 1e-300", "must be 1e-30 or more"),
    ({"damping": {"beta": 1e300}}, "damping.beta = 1e+300", "less than or equal to 1e+30"),
    ({"dashpot": [{"at": [1.0], "damping": [1e-300]}]}, "dashpot[1].damping", "1e-30 or more"),
    ({"output": {"frames": 3}}, "output.frames = 3", "at least 24"),
    ({"output": {"frames": 10**8}}, "output.frames = 100000000", "less than or equal to 10000"),
    ({"output": {"folder": 3}}, "output.folder = 3", "name in quotes"),
    ({"title": 3}, "title = 3", "string"),
    ({"title": "a\u202eb"}, "title = ", "must be one line"),
    ({"title": "x" * 201}, "title = ", "200 letters at most"),
]


@pytest.mark.parametrize(("changes", "named", "right"), VALUES)
def test_wrong_value(
    changes: dict[str, Any], named: str, right: str, study_file: StudyFile, command: Command
) -> None:
    command("run", study_file(**changes)).assert_one_line(2, "study.toml: ", named, right)


UNFIT = [
    ({}, {"clamp": {"facets": "lefft"}}, 'clamp.facets = "lefft"', 'it has "left", "right"'),
    ({}, {"contact": {"facets": [""]}}, 'contact.facets = ""', 'it has "left", "right"'),
    (PLATE, {"contact": {"facets": ["right", "up"]}}, '"up"', '"bottom", "left", "right", "top"'),
    ({}, {"clamp": None}, "1 rigid-body modes", "clamp.facets"),
    (PLATE, {"clamp": None}, "3 rigid-body modes", "clamp.facets"),
    (BEAM, {"clamp": None}, "6 rigid-body modes", "clamp.facets"),
    ({}, {"contact": {"facets": "left"}}, '"left": 1 vertices', "must not touch the clamp"),
    (PLATE, {"contact": {"facets": "top"}}, "(0, 0.25) m", "must not touch the clamp"),
    (BEAM, {"contact": {"facets": "top"}}, '"top": 2 vertices', "must not touch the clamp"),
    ({}, {"body": {"=": {"theory": "solid"}}}, 'theory = "solid"', "dimension 3, this one has"),
    (BEAM, {"body": {"=": {"theory": "rod", "area": 1.0}}}, 'theory = "rod"', "dimension 1"),
    ({}, {"reduction": {"modes": 5}}, "reduction.modes = 5", "only 4 free dofs"),
    ({}, {"reduction": {"modes": 4}}, "residual flexibility", "fewer reduction.modes"),
    (PLATE, {"reduction": {"modes": 46}}, "residual flexibility", "fewer reduction.modes"),
    (PLATE, {"contact": {"points": 9}}, "contact.points = 9", "only 2 vertices"),
    (PLATE, {"contact": {"direction": [1.0]}}, "direction = [1.0]", "2 components"),
    (PLATE, {"contact": {"direction": "-z"}}, 'contact.direction = "-z"', "of the 2 axes"),
    (PLATE, {"contact": {"direction": [0.0, 1.0, 1.0]}}, "[0.0, 1.0, 1.0]", "2 components"),
    (
        BEAM,
        {"contact": {"direction": "radial", "axis": "x", "origin": [1.0]}},
        "contact.origin = [1.0]",
        "3 components",
    ),
    (
        {},
        {"contact": {"direction": "radial", "axis": "x"}},
        'contact.direction = "radial"',
        "must not meet the axis",
    ),
]


@pytest.mark.parametrize("action", ["run", "check"])
@pytest.mark.parametrize(("base", "changes", "named", "right"), UNFIT)
def test_study_that_does_not_fit_its_mesh(
    action: str,
    base: dict[str, Any],
    changes: dict[str, Any],
    named: str,
    right: str,
    study_file: StudyFile,
    command: Command,
    tmp_path: Path,
) -> None:
    study = study_file(**({"base": base} if base else {}), **changes)
    command(action, study).assert_one_line(2, named, right)
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]


@pytest.mark.parametrize("action", ["run", "check"])
def test_mode_that_does_not_move_the_contact_points(
    action: str, study_file: StudyFile, command: Command
) -> None:
    """Without Poisson's effect the first axial mode, the third of all, has no motion across."""
    study = study_file(PLATE, material={"poisson": 0.0}, reduction={"modes": 5}, mode={"number": 3})
    ended = command(action, study)
    ended.assert_one_line(2, "mode 3 does not move any contact point", "mode.number")


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (None, ["cannot be read: No such file"]),
        ("", ["has no table"]),
        ("section,j\n1,2\n", ["column", "is missing"]),
        ("section,j,z_m,r_m,theta1_rad,theta2_rad\n1,1,0,0.1,0,x\n", ["line 2", "theta2_rad"]),
    ],
)
def test_blade_without_a_good_table(
    table: str | None, words: list[str], study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    if table is not None:
        (tmp_path / "sections.csv").write_text(table)
    study = study_file(BEAM, mesh={"=": BLADE})
    command("run", study).assert_one_line(2, str(tmp_path / "sections.csv"), *words)
