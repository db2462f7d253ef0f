"""Wraps the paragraphs of pages at 110 characters: `python3 docs/site/wrap.py docs/*.md`.

Tables, code, headings, pictures and formulas stay as they are. Links and words in code are never
parted, and no line begins with what would make a list of it. A page that is wrapped is not changed.
"""

from __future__ import annotations

import re
import sys
import textwrap
from pathlib import Path

WIDTH = 110

#: What stands for a space where no line may end.
_JOINT = "\N{NO-BREAK SPACE}"

#: Beginnings of lines that are no text to be wrapped.
_KEPT = ("|", "#", "![", "<!--", "    ")

_FENCE = re.compile(r"^\s*```")
_ITEM = re.compile(r"(\s*)([*-]|\d+\.) ")
_WHOLE = re.compile(r"`[^`]+`|\[[^\]]*\]\([^)]*\)")
_OPERATOR = re.compile(r"(?<=\S) (?=(?:[-+*=<>|#]|\d+[.)]) )")


def wrapped(text: str) -> str:
    """A page with its paragraphs wrapped."""
    lines: list[str] = []
    paragraph: list[str] = []
    fenced = False
    for line in text.splitlines():
        fence = bool(_FENCE.match(line))
        kept = fenced or fence or not line.strip() or _is_kept(line, paragraph)
        if paragraph and (kept or _ITEM.match(line)):
            lines += _paragraph(paragraph)
            paragraph = []
        if kept:
            lines.append(line)
        else:
            paragraph.append(line)
        fenced ^= fence
    return "\n".join([*lines, *_paragraph(paragraph)]) + "\n"


def _is_kept(line: str, paragraph: list[str]) -> bool:
    """Whether a line stays as it is; one that is set in is code unless it goes on with a list."""
    if line.startswith("    ") and paragraph and _ITEM.match(paragraph[0]):
        return False
    return line.startswith(_KEPT) or line.endswith("  ")


def _paragraph(lines: list[str]) -> list[str]:
    if not lines:
        return []
    item = _ITEM.match(lines[0])
    first = item.group() if item else re.match(r"\s*", lines[0]).group()  # type: ignore[union-attr]
    later = " " * len(first)
    if len(lines) > 1 and not item:
        later = first
    text = " ".join(line.strip() for line in lines)[len(first.strip()) :].strip()
    text = _OPERATOR.sub(_JOINT, _WHOLE.sub(lambda m: m.group().replace(" ", _JOINT), text))
    found = textwrap.wrap(
        text,
        WIDTH,
        initial_indent=first,
        subsequent_indent=later,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace(_JOINT, " ") for line in found]


def main() -> None:
    """Wrap the pages that are named."""
    for name in sys.argv[1:]:
        page = Path(name)
        old = page.read_text("utf-8")
        new = wrapped(old)
        assert old.split() == new.split(), f"{name}: a word would be lost"
        if new != old:
            page.write_text(new, "utf-8")


if __name__ == "__main__":
    main()
