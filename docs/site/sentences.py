"""Picks sentences of the docs at random, to be read with fresh eyes.

    python3 docs/site/sentences.py --seed 18 --count 30

With --long it lists all sentences of more than so many words instead.
"""

from __future__ import annotations

import argparse
import random
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

_FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
_CODE = re.compile(r"^ {4,}.*$", re.MULTILINE)
_ITEM = re.compile(r"^([*-]|\d+\.) ")
_END = re.compile(r"(?<=[.!?])\s+(?=[A-Z`\"*(\[0-9])")

#: A sentence has so many words at least: shorter ones are headings of lists.
_LEAST = 6


def sentences() -> Iterator[tuple[str, str]]:
    """Name of the page and text of each sentence, links by their words."""
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))):
        for paragraph in _paragraphs(page.read_text("utf-8")):
            plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", paragraph)
            yield from ((page.name, each) for each in _END.split(plain) if each.strip())


def _paragraphs(text: str) -> Iterator[str]:
    """Paragraphs and items of lists, each in one line."""
    lines: list[str] = []
    for line in [*_CODE.sub("", _FENCE.sub("\n\n", text)).splitlines(), ""]:
        words = line.strip()
        ends = not words or words.startswith(("|", "#", "!["))
        if lines and (ends or _ITEM.match(words)):
            yield " ".join(lines)
            lines = []
        if not ends:
            lines.append(_ITEM.sub("", words, count=1) if not lines else words)


def main() -> None:
    """Print the sentences that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=30)
    parser.add_argument("--long", type=int, help="all sentences of more words than this")
    asked = parser.parse_args()
    known = list(sentences())
    if asked.long:
        chosen = [each for each in known if len(each[1].split()) > asked.long]
    else:
        known = [each for each in known if len(each[1].split()) >= _LEAST]
        chosen = random.Random(asked.seed).sample(known, asked.count)
    for number, (page, text) in enumerate(chosen, start=1):
        sys.stdout.write(f"{number}. {page}: {text}\n")


if __name__ == "__main__":
    main()
