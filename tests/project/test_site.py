"""The docs as a site: every page has its place, and every link goes to something that is there."""

from __future__ import annotations

import re
import runpy
import shutil
import subprocess
from pathlib import Path

import pytest

import fenics_nnm as nnm

ROOT = Path(__file__).parents[2]
SITE = runpy.run_path(str(ROOT / "docs/site/conf.py"))
SENTENCES = runpy.run_path(str(ROOT / "docs/site/sentences.py"))


def text(name: str) -> str:
    return (ROOT / name).read_text("utf-8")


def test_every_page_is_in_the_navigation_once() -> None:
    listed = [page for pages in SITE["NAVIGATION"].values() for page in pages]
    pages = {f"docs/{path.stem}" for path in (ROOT / "docs").glob("*.md")}
    assert len(listed) == len(set(listed))
    assert set(listed) == {*pages, "api", "meshes/README", "benchmarks/README"}


def test_what_pages_link_to_is_shown_to_the_builder() -> None:
    """Sphinx reads a folder of links to the files and folders that pages have links to."""
    linked = re.findall(
        r'"([\w./]+)"', re.findall(r"^LINKED = (.*)$", text("docs/site/build.py"), re.M)[0]
    )
    for page in (*(ROOT / "docs").glob("*.md"), ROOT / "README.md"):
        for link in re.findall(r"\]\(([^)\s#]+)", page.read_text("utf-8")):
            if not link.startswith("http"):
                target = (page.parent / link).resolve().relative_to(ROOT)
                assert target.parts[0] in linked, (page.name, link)


def test_what_the_reference_describes_is_documented() -> None:
    """All but the errors, whose docstrings are lines, say what they give or have."""
    for name in nnm.__all__[1:]:
        words = getattr(nnm, name).__doc__ or ""
        assert words.strip(), name


def test_modules_that_are_mocked_are_there() -> None:
    for name in SITE["autodoc_mock_imports"]:
        if name.startswith("fenics_nnm."):
            path = ROOT / name.replace(".", "/")
            assert path.is_dir() or path.with_suffix(".py").exists(), name


def test_docs_root_has_what_the_settings_name() -> None:
    packages = text("environment/docs-packages.txt")
    assert SITE["html_theme"] in packages
    assert "python3-myst-parser" in packages
    assert "--docs)" in text("environment/run")


@pytest.mark.parametrize("broken", ["docs", "image-check", "test", "none"])
def test_ci_fails_where_a_part_of_it_fails(broken: str, tmp_path: Path) -> None:
    (tmp_path / ".ci").mkdir()
    shutil.copy(ROOT / ".ci/run", tmp_path / ".ci")
    rules = (f"{each}:\n\t@[ {broken} != {each} ]\n" for each in ("test", "docs", "image-check"))
    (tmp_path / "Makefile").write_text("".join(rules))
    ended = subprocess.run([tmp_path / ".ci/run"], capture_output=True, text=True, check=False)
    assert (ended.returncode == 0) == (broken == "none")
    failed = [line.split(" FAILED")[0] for line in ended.stdout.splitlines() if "FAILED" in line]
    assert failed == ([] if broken == "none" else [f"make {broken}"])


def wide(name: str) -> list[str]:
    """Lines over 120 characters, but for tables, pictures, code and links that cannot be parted."""
    plain = re.sub(r"^```.*?^```", "", text(name), flags=re.MULTILINE | re.DOTALL)
    lines = (line for line in plain.splitlines() if len(line) > 120)
    texts = (line for line in lines if not line.startswith(("|", "![", "    ")))
    return [line for line in texts if " " in re.sub(r"`[^`]*`|\[[^]]*\]\([^)]*\)", "", line)]


def test_lines_of_pages_are_not_too_wide() -> None:
    """`python3 docs/site/wrap.py PAGE` wraps a page."""
    pages = ["README.md", *(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md"))]
    assert [name for name in pages if wide(name)] == []


def test_no_sentence_is_long() -> None:
    """Thirty words at most, in tables as well; `python3 docs/site/sentences.py --long 30`."""
    assert SENTENCES["long_sentences"](30) == []


def test_sentences_are_told_apart() -> None:
    parted = list(
        SENTENCES["_parted"]("By name (M. Hochbruck, A. Einstein). p is *small.* At 2 J. So a . b!")
    )
    assert parted == [
        "By name (M. Hochbruck, A. Einstein).",
        "p is *small.*",
        "At 2 J.",
        "So a . b!",
    ]
    assert SENTENCES["words"]("x = [a page](page.md) + 1") == 4


def test_wrapping_keeps_code_lists_and_links() -> None:
    """And a page that is wrapped stays as it is."""
    wrapped = runpy.run_path(str(ROOT / "docs/site/wrap.py"))["wrapped"]
    link = "[a link with words](page.md#and-an-anchor)"
    long = f"* {'word ' * 19}and `code with words` {link} - 1 = x\n  goes on\n\n    f = 1 + 1\n"
    page = f"# Head\n\n| {'cell ' * 40}|\n\n```\n{'code ' * 40}\n```\n\n{long}"
    found = wrapped(page)
    assert found.split() == page.split()
    assert wrapped(found) == found
    assert all(each in found for each in ("`code with words`", link, "\n    f = 1 + 1\n"))
    assert not re.search(r"^\s*[-=+] ", found, re.MULTILINE)
    assert max(len(line) for line in found.splitlines() if line.startswith(("*", "  "))) <= 110
