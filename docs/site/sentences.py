"""Picks sentences of the docs at random, to be read with fresh eyes.

    python3 docs/site/sentences.py --seed 18 --count 30

With --long it lists all sentences of more than so many words instead, those in tables included.
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
_RULE = re.compile(r"^\|[-| :]*$")

#: A full stop, closed brackets, quotes and emphasis after it, and a space.
_STOP = re.compile(r"(?<![.\s])[.!?][)*\"]*\s+")

#: A point after these ends no sentence: abbreviations, and initials of names.
_ABBREVIATION = re.compile(r"(\b(St|eq|al|Fig)|(\(|, |\band |[A-Z]\. )[A-Z])\.$")

#: What ends a sentence, and what begins a line that only names files.
_WHOLE = re.compile(r"[.!?][)*\"]*$")
_NAMES = re.compile(r"\*?(Code|Run|Used by)\b")

#: A sentence has so many words at least: shorter ones are headings of lists.
_LEAST = 6


def sentences() -> Iterator[tuple[str, str]]:
    """Name of the page and text of each sentence, links by their words."""
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))):
        for paragraph in _paragraphs(page.read_text("utf-8")):
            yield from ((page.name, each) for each in _parted(paragraph))


def long_sentences(most: int) -> list[tuple[str, str]]:
    """Sentences of more words than `most`; signs such as = and + are no words."""
    return [(page, text) for page, text in sentences() if words(text) > most]


def whole_sentences() -> list[tuple[str, str]]:
    """Sentences to be read: those that end with a full stop and do more than name files."""
    return [
        (page, text)
        for page, text in sentences()
        if words(text) >= _LEAST and _WHOLE.search(text) and not _NAMES.match(text)
    ]


def words(text: str) -> int:
    """Number of words: what stands between spaces and has a letter or a digit."""
    return sum(bool(re.search(r"\w", each)) for each in text.split())


def _parted(paragraph: str) -> Iterator[str]:
    """Sentences of a paragraph."""
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", paragraph)
    begin = 0
    for stop in _STOP.finditer(plain):
        text = plain[begin : stop.end()].strip()
        if not _ABBREVIATION.search(text):
            yield text
            begin = stop.end()
    if plain[begin:].strip():
        yield plain[begin:].strip()


def _paragraphs(text: str) -> Iterator[str]:
    """Paragraphs, items of lists, cells of tables and texts of pictures, each in one line."""
    lines: list[str] = []
    for line in [*_CODE.sub("", _FENCE.sub("\n\n", text)).splitlines(), ""]:
        stripped = line.strip()
        apart = stripped.startswith(("|", "#", "!["))
        if lines and (apart or not stripped or _ITEM.match(stripped)):
            yield " ".join(lines)
            lines = []
        if stripped.startswith("|") and not _RULE.match(stripped):
            yield from (cell.strip() for cell in re.split(r"(?<!\\)\|", stripped) if cell.strip())
        elif stripped and not apart:
            lines.append(_ITEM.sub("", stripped, count=1) if not lines else stripped)


def main() -> None:
    """Print the sentences that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=30)
    parser.add_argument("--long", type=int, help="all sentences of more words than this")
    asked = parser.parse_args()
    if asked.long:
        chosen = long_sentences(asked.long)
    else:
        every = whole_sentences()
        chosen = random.Random(asked.seed).sample(every, min(asked.count, len(every)))
    for number, (page, text) in enumerate(chosen, start=1):
        sys.stdout.write(f"{number}. {page}: {text}\n")


if __name__ == "__main__":
    main()
