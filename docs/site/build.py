"""Builds the pages as a site, links checked: `make docs`.

Sphinx was chosen for three reasons. It reads the pages as they are on GitHub (by MyST), makes the
reference from docstrings without dolfinx (by mocks of what is behind the face), and Debian has all
of it. MkDocs would do the same with a plugin for each, and its makers announced an incompatible
version 2.

    environment/run --docs python3 docs/site/build.py            the site, in results/site/html
    environment/run --docs python3 docs/site/build.py linkcheck  links to other sites, too
"""

from __future__ import annotations

import ast
import shutil
import sys
from pathlib import Path

from sphinx.cmd.build import build_main

ROOT = Path(__file__).resolve().parents[2]
SITE = ROOT / "results" / "site"

#: Folders and files that pages are in, or have links to.
LINKED = ("README.md", "LICENSE", "CITATION.cff", "benchmarks", "demos", "docs", "meshes")

_HEAD = """# Reference of the Python face

What `import fenics_nnm as nnm` offers, from its docstrings. [The page about Python](docs/python.md)
has examples and the list of stable names.
"""

#: The first page under the name that servers look for.
_INDEX = '<!doctype html><meta charset="utf-8"><meta http-equiv="refresh" content="0; url=%s">'


def main() -> int:
    """Build with one of Sphinx's builders; any warning is an error."""
    builder = sys.argv[1] if len(sys.argv) > 1 else "html"
    source, target = SITE / "source", SITE / builder
    _make(source)
    shutil.rmtree(target, ignore_errors=True)
    settings = ["-c", str(Path(__file__).parent), "-d", str(SITE / "read")]
    ended = build_main(
        ["-b", builder, "-W", "--keep-going", "-q", *settings, str(source), str(target)]
    )
    if ended == 0 and builder == "html":
        (target / "index.html").write_text(_INDEX % "README.html", "utf-8")
        sys.stdout.write(f"the site is in {target}: open index.html\n")
    return ended


def _make(source: Path) -> None:
    """The folder that Sphinx reads: links to what there is, and the reference."""
    shutil.rmtree(SITE, ignore_errors=True)
    source.mkdir(parents=True)
    for name in LINKED:
        (source / name).symlink_to(ROOT / name)
    (source / "api.md").write_text(_reference(), "utf-8")


def _reference() -> str:
    """The page of the face: functions, classes, errors."""
    parts = {"Functions": "", "Classes": "", "Errors": ""}
    for module, name in _names():
        kind = _kind(module, name)
        directive = "autofunction" if kind == "Functions" else "autoclass"
        options = "\n   :members:" if kind == "Classes" else ""
        parts[kind] += f"\n.. {directive}:: {module}.{name}{options}\n"
    chapters = (f"\n## {k}\n\n```{{eval-rst}}\n{text}\n```\n" for k, text in parts.items())
    return _HEAD + "".join(chapters)


def _names() -> list[tuple[str, str]]:
    """Module and name of all that the face offers, in the order of its list."""
    tree = ast.parse((ROOT / "fenics_nnm/__init__.py").read_text("utf-8"))
    assigned = [node for node in tree.body if isinstance(node, ast.Assign)]
    (face,) = (node.value for node in assigned if ast.unparse(node.targets[0]) == "_FACE")
    listed: dict[str, str] = ast.literal_eval(face)
    return [(f"fenics_nnm.{module}", name) for name, module in listed.items()]


def _kind(module: str, name: str) -> str:
    if module.endswith(".errors"):
        return "Errors"
    return "Classes" if name[0].isupper() else "Functions"


if __name__ == "__main__":
    sys.exit(main())
