"""Docs: links lead somewhere, and every key, command and column is named."""

from __future__ import annotations

import argparse
import ast
import re
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from fenics_nnm.commands import COMMANDS
from fenics_nnm.field_names import FIELDS
from fenics_nnm.output import resonance_report, response_report, simulation_report
from fenics_nnm.results.tables import COLUMNS
from fenics_nnm.study.study import MatrixStudy, MeshStudy

ROOT = Path(__file__).parents[2]
DOCS = sorted([ROOT / "README.md", ROOT / "meshes/README.md", *(ROOT / "docs").glob("*.md")])
NAMES = [str(path.relative_to(ROOT)) for path in DOCS]

#: Options that many commands have, which the guide has once.
OF_ALL = ("--help", "--verbose", "--no-cache")
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


def text_of(path: Path) -> str:
    """A page without its blocks of code."""
    return FENCE.sub("", path.read_text("utf-8"))


def anchors(path: Path) -> set[str]:
    """Anchors of the headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.+)$", text_of(path), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("name", NAMES)
def test_links_lead_somewhere(name: str) -> None:
    page = ROOT / name
    links = re.findall(r"\]\(([^)\s]+)\)", text_of(page))
    for link in links:
        if link.startswith("http"):
            continue
        target, _, anchor = link.partition("#")
        file = (page.parent / target).resolve() if target else page
        assert file.exists(), link
        if anchor:
            assert anchor in anchors(file), link


@pytest.mark.parametrize("name", NAMES)
def test_pages_are_short_enough_to_read(name: str) -> None:
    assert len((ROOT / name).read_text("utf-8").splitlines()) <= 520


def test_all_pictures_are_shown() -> None:
    shown = {
        (page.parent / link).resolve()
        for page in DOCS
        for link in re.findall(r"!\[[^]]*\]\(([^)\s]+)\)", text_of(page))
    }
    assert set((ROOT / "docs/pictures").iterdir()) == shown


def test_files_that_the_pages_name_are_there() -> None:
    pattern = re.compile(r"`((?:demos|tests|fenics_nnm|docs|meshes|environment)/[\w./]+)`")
    missing = {
        (page.name, name)
        for page in DOCS
        for name in pattern.findall(text_of(page))
        if "results" not in name and not (ROOT / name).exists()
    }
    assert not missing


def properties(node: Any, definitions: dict[str, Any], seen: frozenset[str]) -> Iterator[str]:
    """Names of all keys below a place of a JSON schema."""
    if isinstance(node, list):
        for item in node:
            yield from properties(item, definitions, seen)
    if not isinstance(node, dict):
        return
    name = node.get("$ref", "").rpartition("/")[2]
    if name and name not in seen:
        yield from properties(definitions[name], definitions, seen | {name})
    for key, value in node.items():
        if key == "properties":
            yield from value
            yield from properties(list(value.values()), definitions, seen)
        elif key not in ("$ref", "$defs", "const", "enum", "default"):
            yield from properties(value, definitions, seen)


def keys_of(study: type[MeshStudy] | type[MatrixStudy]) -> Iterator[tuple[str, str]]:
    """Section and key of everything that a study file can have."""
    schema = study.model_json_schema()
    for section, value in schema["properties"].items():
        for key in set(properties(value, schema["$defs"], frozenset())):
            yield section, key


#: Pages that belong to a section of the reference.
PARTS = {
    "mesh": ["docs/mesh_files.md", "docs/blade.md"],
    "contact": ["docs/study_contact.md"],
    "rotation": ["docs/loads.md"],
    "load": ["docs/loads.md"],
    "matrices": ["docs/study_matrices.md"],
    "damping": ["docs/study_driven.md"],
    "dashpot": ["docs/study_driven.md"],
    "excitation": ["docs/study_driven.md"],
    "monitor": ["docs/study_driven.md"],
    "response": ["docs/study_driven.md"],
}


def words_of(section: str) -> set[str]:
    """Words in code, or in first columns of tables, of a section of the reference."""
    reference = (ROOT / "docs/study_file.md").read_text("utf-8")
    parts = re.split(r"^## (?=\[)", reference, flags=re.MULTILINE)
    (part,) = (p for p in parts if re.match(rf".*\[{section}\]", p.partition("\n")[0]))
    part = "\n".join([part, *((ROOT / p).read_text("utf-8") for p in PARTS.get(section, []))])
    code = [*re.findall(r"```toml\n(.*?)```", part, re.DOTALL), *re.findall(r"`([^`\n]+)`", part)]
    cells = re.findall(r"^\| ([^|]+) \|", part, re.MULTILINE)
    return set(re.findall(r"\w+", " ".join([*code, *cells])))


def test_every_key_of_a_study_is_in_the_reference() -> None:
    keys = {*keys_of(MeshStudy), *keys_of(MatrixStudy)}
    assert ("continuation", "largest_step") in keys
    assert ("contact", "half_angle_deg") in keys
    words = {section: words_of(section) for section, _ in keys}
    assert not {(section, key) for section, key in keys if key not in words[section]}


def test_examples_of_the_pages_are_toml() -> None:
    blocks = [
        block
        for page in DOCS
        for block in re.findall(r"^```toml\n(.*?)^```", page.read_text("utf-8"), re.M | re.S)
    ]
    assert len(blocks) > 10
    for block in blocks:
        tomllib.loads(block)


def test_commands_and_options_are_in_the_guide() -> None:
    guide = (ROOT / "docs/user_guide.md").read_text("utf-8")
    commands = argparse.ArgumentParser().add_subparsers()
    for module in COMMANDS:
        module.add_to(commands)
    assert "export" in commands.choices
    for name, command in commands.choices.items():
        (row,) = re.findall(rf"^\| `fenics-nnm {name} .*$", guide, re.MULTILINE)
        for option in (a.option_strings[-1] for a in command._actions if a.option_strings):
            assert option in row or option in OF_ALL, (name, option)
    assert "--verbose" in guide and "--no-cache" in guide


def test_fields_and_columns_are_words_of() -> None:
    pages = ("docs/results.md", "docs/results_driven.md")
    results = "\n".join((ROOT / page).read_text("utf-8") for page in pages)
    study_file = (ROOT / "docs/study_file.md").read_text("utf-8")
    columns = set(re.findall(r"\w+", " ".join(re.findall(r"^\| ([\w, ]+) \|", results, re.M))))
    driven = response_report, resonance_report, simulation_report
    assert not {*COLUMNS, *(name for each in driven for name in each.COLUMNS)} - columns
    assert all(field in study_file for field in FIELDS)


def test_targets_of_make_are_those_that_the_pages_name() -> None:
    listed = subprocess.run(
        ["make", "-pRrq", "-C", str(ROOT), ":"], capture_output=True, text=True, check=False
    ).stdout
    targets = set(re.findall(r"^([a-z][\w-]*):", listed, re.MULTILINE))
    named = {
        target
        for page in DOCS
        for target in re.findall(r"`make ([a-z-]+)`", page.read_text("utf-8"))
    }
    assert named
    assert not named - targets


def test_every_test_file_is_listed_with_what_it_tests() -> None:
    listed = (ROOT / "tests/README.md").read_text("utf-8")
    for path in [*ROOT.glob("tests/*/test_*.py"), *ROOT.glob("tests/*.py")]:
        first = (ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "").splitlines()[0]
        name = path.relative_to(ROOT / "tests").as_posix()
        assert f"| [{path.name}]({name}) | {first} |" in listed, path
