"""Nobody asks what kind of thing he was given: our own classes answer by methods."""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterator
from pathlib import Path

import fenics_nnm

PACKAGE = Path(fenics_nnm.__file__).parent

#: Room that reads the study file, where values of any kind come in.
READING = "study"

#: Where kinds are still asked for: modules, with the classes.
REMAINING: dict[str, set[str]] = {}


def modules() -> Iterator[tuple[str, ast.Module]]:
    for path in sorted(PACKAGE.rglob("*.py")):
        name = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        yield name, ast.parse(path.read_text("utf-8"))


def classes() -> dict[str, str]:
    """Module of each class or union of the package that is no exception, by its name."""
    found = {}
    for name, tree in modules():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                found[node.name] = name
        found |= {alias: name for alias in unions(tree)}
    return {name: module for name, module in found.items() if not is_exception(module, name)}


def unions(tree: ast.Module) -> list[str]:
    """Names that a module gives to unions, such as Study = MeshStudy | MatrixStudy."""
    return [
        target.id
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.BinOp)
        for target in node.targets
        if isinstance(target, ast.Name) and isinstance(node.value.op, ast.BitOr)
    ]


def is_exception(module: str, name: str) -> bool:
    found = getattr(importlib.import_module(f"fenics_nnm.{module}"), name, None)
    return isinstance(found, type) and issubclass(found, BaseException)


def asked(tree: ast.Module) -> set[str]:
    """Names of the classes that a module asks for by isinstance or issubclass, or matches."""
    kinds: list[ast.expr] = []
    for node in ast.walk(tree):
        called = (
            node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
        )
        if isinstance(node, ast.Call) and called in ("isinstance", "issubclass"):
            kinds.append(node.args[1])
        if isinstance(node, ast.MatchClass):
            kinds.append(node.cls)
    inside = [part for kind in kinds for part in ast.walk(kind)]
    names = {part.id for part in inside if isinstance(part, ast.Name)}
    return names | {part.attr for part in inside if isinstance(part, ast.Attribute)}


def test_no_kind_of_ours_is_asked_for_outside_reading() -> None:
    ours = classes()
    found = {
        name: asked(tree) & set(ours)
        for name, tree in modules()
        if name.partition(".")[0] != READING and asked(tree) & set(ours)
    }
    assert found == REMAINING


def test_unions_of_classes_are_seen() -> None:
    tree = ast.parse("isinstance(x, A | b.C)\nisinstance(y, (D, str))\nmatch z:\n  case E(): pass")
    assert asked(tree) == {"A", "b", "C", "D", "str", "E"}
    assert {"MeshStudy", "MatrixStudy", "Study", "Faces", "Isotropic"} <= set(classes())
    assert "OutputError" not in classes()
