"""Verification report: what scripts print for it has a place there, and gets there."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
PROGRAM = ROOT / "docs" / "verification.py"


@pytest.fixture
def program() -> ModuleType:
    spec = spec_from_file_location("verification_report", PROGRAM)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


REPORT = """Before.

<!-- docs: first -->

| a |
|---|
| 1 |

Between.

<!-- docs: second -->

It was 3 %.

After.
"""


def test_parts_take_the_place_of_the_old_ones(program: ModuleType) -> None:
    lines = ["gone\n", "docs: first\n", "| a |\n", "|---|\n", "| 2.5% |\n", "\n", "more\n"]
    assert program.renewed(REPORT, program.printed(lines)) == REPORT.replace("| 1 |", "| 2.5 % |")
    assert program.renewed(REPORT, {}) == REPORT


def test_a_part_without_a_place_is_refused(program: ModuleType, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(REPORT)
    program.PAGES = [page]
    with pytest.raises(ValueError, match="no place for third"):
        program.put({"third": "x\n", "second": "It was 4 %.\n"})
    assert page.read_text() == REPORT.replace("3 %", "4 %")


def test_every_part_that_a_script_prints_has_a_place_and_every_place_a_script() -> None:
    studies = re.findall(r"^\t\$\(STUDY\) (\S+)", (ROOT / "Makefile").read_text(), re.MULTILINE)
    printed = [
        name
        for study in studies
        for name in re.findall(r"docs: (\w+)", (ROOT / study).read_text("utf-8"))
    ]
    pages = [page.read_text("utf-8") for page in sorted(ROOT.glob("docs/verification*.md"))]
    places = re.findall(r"<!-- docs: (\w+) -->", "".join(pages))
    assert len(set(printed)) == len(printed)
    assert sorted(printed) == sorted(places)


def test_a_script_that_fails_leaves_the_report_as_it_was(tmp_path: Path) -> None:
    report = (ROOT / "docs/verification.md").read_bytes()
    script = tmp_path / "study.py"
    script.write_text("print('docs: rod\\n| nonsense |\\n')\nraise SystemExit(3)\n")
    ended = subprocess.run([sys.executable, PROGRAM, script], capture_output=True, check=False)
    assert ended.returncode == 3
    assert b"| nonsense |" in ended.stdout
    assert (ROOT / "docs/verification.md").read_bytes() == report
