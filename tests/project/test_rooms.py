"""The rooms of the package: who may know whom, what numerical rooms may know, and how large."""

from __future__ import annotations

import ast
import pickle
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise
from pathlib import Path

import pytest

import fenics_nnm
from fenics_nnm.errors import Code, ConvergenceError, ModelError, OutputError
from fenics_nnm.processes import environment_of_child
from fenics_nnm.study.error_keys import KEYS, in_keys, one_line

PACKAGE = Path(fenics_nnm.__file__).parent

#: What rooms may import: those above themselves in this list, and never those below.
ROOMS = (
    "",  # the version
    "arrays",
    "errors",
    "field_names",
    "interrupts",
    "importing",
    "stages",
    "progress",
    "processes",
    "files",
    "mechanics",
    "reduction",
    "nonlinear",
    "continuation",
    "time_domain",
    "backbone",
    "response",
    "geometry",
    "materials",
    "casing",
    "study",
    "fem",
    "templates",
    "structure",
    "resolution",
    "results",
    "fields",
    "output",
    "running",
    "run",
    "sweep",
    "face",
    "commands",
    "cli",
    "__main__",
)

NUMERICAL = (
    "mechanics",
    "reduction",
    "nonlinear",
    "continuation",
    "time_domain",
    "backbone",
    "response",
)

#: Rooms whose messages name no key of the study.
WITHOUT_KEYS = (*NUMERICAL, "materials", "casing", "fem")

#: Upward imports that are still there; each is to go.
KNOWN_UPWARD: tuple[tuple[str, str], ...] = ()

#: Imports of a circle that are still there, under TYPE_CHECKING or in a function; each is to go.
KNOWN_CIRCLES: tuple[tuple[str, str], ...] = ()

#: Functions with more than 7 parameters that are still there; each is to go.
KNOWN_PARAMETERS: tuple[str, ...] = ()

#: Classes with more than 15 methods that are still there; each is to go.
KNOWN_METHODS: tuple[str, ...] = ()

#: Messages with keys of the study that are still there; each is to go.
KNOWN_KEYS: tuple[str, ...] = ()

_KEY = re.compile(
    r"\b(contact|reduction|mode|continuation|mesh|body|clamp|augmented_lagrangian|solver|material"
    r"|matrices|output|rotation|load)\.[a-z_]+\b"
)


@cache
def trees() -> dict[str, ast.Module]:
    """Syntax of each module by its name without that of the package."""
    found = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        parts = file.relative_to(PACKAGE).with_suffix("").parts
        name = ".".join(part for part in parts if part != "__init__")
        found[name] = ast.parse(file.read_text())
    return found


def room(module: str) -> str:
    return module.partition(".")[0]


@cache
def imports() -> frozenset[tuple[str, str]]:
    """Pairs of modules of which the first imports the second, wherever it does so."""
    return frozenset(
        (module, imported)
        for module, tree in trees().items()
        for node in ast.walk(tree)
        for imported in _imported(node)
        if imported != module
    )


def _imported(node: ast.AST) -> Iterator[str]:
    names = []
    if isinstance(node, ast.Import):
        names = [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        assert not node.level, "imports are absolute"
        names = [f"{node.module}.{alias.name}" for alias in node.names]
    for name in names:
        head, _, inside = name.partition(".")
        if head == fenics_nnm.__name__:
            yield inside if inside in trees() else inside.rpartition(".")[0]


def test_all_rooms_have_a_place() -> None:
    assert {room(module) for module in trees()} == set(ROOMS)


def test_no_room_imports_one_above_it() -> None:
    upward = {
        (module, imported)
        for module, imported in imports()
        if ROOMS.index(room(imported)) > ROOMS.index(room(module))
    }
    assert upward == set(KNOWN_UPWARD)


def test_no_circle_of_modules() -> None:
    graph: dict[str, set[str]] = {module: set() for module in trees()}
    for module, imported in imports() - set(KNOWN_CIRCLES):
        graph[module].add(imported)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"modules import each other in a circle: {' <- '.join(error.args[1])}")
    assert set(KNOWN_CIRCLES) <= imports()


def test_numerical_rooms_need_numpy_and_scipy_alone() -> None:
    modules = [f"fenics_nnm.{module}" for module in trees() if room(module) in NUMERICAL]
    assert len(modules) > 50
    program = (
        "import importlib, sys\n"
        "for name in ('dolfinx', 'basix', 'ufl', 'mpi4py', 'petsc4py', 'slepc4py', 'gmsh', 'h5py',"
        " 'pydantic', 'rich', 'matplotlib'):\n"
        "    sys.modules[name] = None\n"
        "for name in sys.argv[1:]:\n"
        "    importlib.import_module(name)\n"
        "print(*(name for name in sys.modules if name.startswith('fenics_nnm.')))\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program, *modules],
        cwd=PACKAGE.parent,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    rooms = {room(name.removeprefix("fenics_nnm.")) for name in ended.stdout.split()}
    assert rooms <= {*NUMERICAL, "arrays", "errors", "stages"}


def test_the_process_that_builds_a_geometry_starts_without_what_it_does_not_use() -> None:
    program = (
        "import sys\n"
        "for name in ('dolfinx', 'petsc4py', 'slepc4py', 'mpi4py', 'h5py', 'matplotlib'):\n"
        "    sys.modules[name] = None\n"
        "import fenics_nnm.fem.native_worker, fenics_nnm.fem.build_geometry\n"
    )
    ended = subprocess.run(
        [sys.executable, "-P", "-c", program],
        cwd=PACKAGE.parent,
        env=environment_of_child(),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr


def _messages(tree: ast.Module) -> Iterator[str]:
    """Texts of a module besides its docstrings."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    docstrings = {
        node.body[0].value
        for node in ast.walk(tree)
        if isinstance(node, documented) and node.body and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            if node not in docstrings:
                yield node.value


def test_messages_of_numerical_rooms_name_no_key_of_the_study() -> None:
    found = {
        f"{module}: {text}"
        for module, tree in trees().items()
        if room(module) in WITHOUT_KEYS
        for text in _messages(tree)
        if _KEY.search(text)
    }
    assert found == set(KNOWN_KEYS)


def _raised() -> Iterator[tuple[str, Code, str]]:
    """Module, code and text of each error with a code."""
    for module, tree in trees().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and room(module) in WITHOUT_KEYS:
                codes = [ast.unparse(each.value) for each in node.keywords if each.arg == "code"]
                text = "".join(n.value for n in ast.walk(node) if _is_text(n))
                yield from ((module, Code[code.removeprefix("Code.")], text) for code in codes)


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def test_every_code_has_its_keys_and_is_used() -> None:
    assert set(KEYS) == set(Code)
    assert {code for _, code, _ in _raised()} == set(Code)


def test_messages_with_a_code_have_the_words_that_become_keys() -> None:
    """A word of the table that no message with the code has would never become a key."""
    errors = list(_raised())
    for code, pairs in KEYS.items():
        texts = [text for _, raised, text in errors if raised == code]
        for text in texts:
            assert pairs[0][0] in text, (code, text)
        for words, key in pairs:
            assert any(words in text for text in texts), (code, words)
            assert key != words


def test_words_become_keys_in_the_line_alone() -> None:
    error = ModelError("gap = -0.1: needs the massless reduction", code=Code.GAP_WITH_MASS)
    assert "contact" not in str(error)
    line = 'contact.gap = -0.1: needs reduction.method = "massless"'
    assert in_keys(error) == one_line(error) == line
    assert one_line(ModelError("gap = -0.1")) == "gap = -0.1"
    assert in_keys(pickle.loads(pickle.dumps(error))) == line  # as another rank gets it


def test_errors_of_the_operating_system_are_none_of_ours() -> None:
    """What turns them into a line must let ours pass, with a code or without."""
    assert not issubclass(OutputError, OSError)
    assert issubclass(ConvergenceError, RuntimeError)


def _definitions(kind: type) -> Iterator[tuple[str, ast.AST]]:
    for module, tree in trees().items():
        for node in ast.walk(tree):
            if isinstance(node, kind):
                yield f"{module}.{node.name}", node


def _parameters(node: ast.FunctionDef) -> int:
    arguments = node.args
    every = (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)
    return sum(each.arg not in ("self", "cls") for each in every)


def test_no_function_has_more_than_seven_parameters() -> None:
    found = {name for name, node in _definitions(ast.FunctionDef) if _parameters(node) > 7}
    assert found == set(KNOWN_PARAMETERS)


def test_no_class_has_more_than_fifteen_methods() -> None:
    def methods(node: ast.ClassDef) -> int:
        return sum(isinstance(each, ast.FunctionDef) for each in node.body)

    found = {name for name, node in _definitions(ast.ClassDef) if methods(node) > 15}
    assert found == set(KNOWN_METHODS)


def test_no_file_is_longer_than_500_lines() -> None:
    files = PACKAGE.rglob("*.py")
    assert [file for file in files if file.read_text().count("\n") > 500] == []


def test_known_ones_are_sorted_out_one_by_one() -> None:
    """The lists of what is still there have each entry once, so that it goes once."""
    for known in (KNOWN_UPWARD, KNOWN_CIRCLES, KNOWN_PARAMETERS, KNOWN_METHODS, KNOWN_KEYS):
        assert len(set(known)) == len(known)
    assert all(before != after for before, after in pairwise(ROOMS))
