"""Commands and blocks of fixed columns of Ansys files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Indices
from fenics_nnm.errors import Code, MeshError

#: Commands that a block of lines of fixed columns follows.
_BLOCKS = ("NBLOCK", "EBLOCK", "CMBLOCK", "ETBLOCK", "RLBLOCK", "CEBLOCK", "BFBLOCK", "SFEBLOCK")

#: Commands that text follows.
_TEXTS = ("/COM", "/TIT", "/STIT", "C***")

#: Most members of a component.
_MOST_MEMBERS = 100_000_000


@dataclass(frozen=True, slots=True)
class Block:
    """A command with its words, and for blocks the format and the lines that follow.

    Attributes:
        name: Command in capitals.
        words: All its words, the command first.
        place: File and line, for messages.
        form: Format of the lines of a block, as "(19i9)".
        lines: Its lines.
    """

    name: str
    words: list[str]
    place: str
    form: str = ""
    lines: list[str] = field(default_factory=list)

    def whole(self, index: int) -> int:
        """A word as a whole number.

        Raises:
            MeshError: if it is none.
        """
        return _whole(self.words[index], self.place)

    def integers(self, most: int | None = None) -> Iterator[list[int]]:
        """Whole numbers of each line, the first ones alone if `most` is given."""
        width = self._width("i")
        for line in self.lines:
            yield self._columns(line, width)[:most]

    def nodes(self) -> Iterator[tuple[int, list[float]]]:
        """Number and coordinates of each node; those at the end of a line may be left out."""
        found = re.search(r"(\d*)i(\d+)[ ,]*(?:\d+p)?(\d*)[ef](\d+)", self.form.lower())
        if found is None:
            raise MeshError(f"{self.place}: {self.form}: is no format of {self.name}")
        before, first, width = int(found[1] or 1) * int(found[2]), int(found[2]), int(found[4])
        for line in self.lines:
            number = _whole(line[:first], self.place)
            x = [line[before + i * width : before + (i + 1) * width].strip() for i in range(3)]
            try:
                yield (
                    number,
                    [float(entry.upper().replace("D", "E")) if entry else 0.0 for entry in x],
                )
            except ValueError as error:
                raise MeshError(f"{self.place}: node {number}: {x}: must be numbers") from error

    def elements(self, solid: bool) -> Iterator[list[int]]:
        """Whole numbers of each element, that of a solid over as many lines as its nodes need."""
        width = self._width("i")
        waiting: list[int] = []
        for line in self.lines:
            waiting += self._columns(line, width)
            if not solid:
                yield waiting
            elif len(waiting) >= 11 and len(waiting) >= 11 + waiting[8]:
                yield waiting[: 11 + waiting[8]]
            else:
                continue
            waiting = []
        if waiting:
            raise MeshError(f"{self.place}: {self.name} ends in the middle of an element")

    def _width(self, letter: str) -> int:
        found = re.search(rf"\d*{letter}(\d+)", self.form.lower())
        if found is None or int(found[1]) == 0:
            raise MeshError(f"{self.place}: {self.form}: is no format of {self.name}")
        return int(found[1])

    def _columns(self, line: str, width: int) -> list[int]:
        entries = (line[i : i + width].strip() for i in range(0, len(line), width))
        return [_whole(entry, self.place) if entry else 0 for entry in entries]


def blocks(path: Path) -> Iterator[Block]:
    """Commands of a file in their order; those of one line that begin with / or * too.

    Raises:
        MeshError: if the file cannot be read.
    """
    try:
        lines = path.read_text("utf-8-sig", errors="replace").splitlines()
    except OSError as error:
        raise MeshError(
            f"mesh file {path}: cannot be read: {error.strerror}", code=Code.MESH_FILE
        ) from error
    at = 0
    while at < len(lines):
        place, text = f"{path}, line {at + 1}", lines[at].partition("!")[0].strip()
        at += 1
        if not text or text.upper().startswith(_TEXTS):
            continue
        *_, words = commands = [_words(part) for part in text.split("$")]
        name = words[0].upper()
        if name not in _BLOCKS:
            yield from (Block(each[0].upper(), each, place) for each in commands)
            continue
        form = lines[at].strip() if at < len(lines) else ""
        at += 1
        start = at
        count = _whole(words[3], place) if name == "CMBLOCK" and len(words) > 3 else None
        if count is not None:
            each = int((re.search(r"(\d+)i", form.lower()) or [0, 8])[1])
            at = min(len(lines), start + -(-count // each))
        while count is None and at < len(lines) and not _ends(lines[at]):
            at += 1
        yield Block(name, words, place, form, [line for line in lines[start:at] if line.strip()])
        at += count is None


def _words(command: str) -> list[str]:
    return [word.strip() for word in command.split(",")]


def _ends(line: str) -> bool:
    """Whether a line ends a block: -1, or a command of letters."""
    text = line.strip()
    return text == "-1" or text[:1].isalpha() or text.startswith(("/", "*", "!"))


def _whole(entry: str, place: str) -> int:
    try:
        return int(entry.partition("!")[0])
    except ValueError as error:
        raise MeshError(f'{place}: "{entry.strip()}": must be a whole number') from error


def expanded(values: list[int], place: str) -> Indices:
    """Members of a component, in which -n after m stands for all from m + 1 to n.

    Raises:
        MeshError: if there are too many.
    """
    parts: list[Indices] = []
    before = 0
    for value in values:
        if value > 0:
            parts.append(np.array([value]))
        elif value < 0:
            if -value - before > _MOST_MEMBERS:
                raise MeshError(f"{place}: {-value - before} members: must be fewer")
            parts.append(np.arange(before + 1, -value + 1))
        before = abs(value)
    return np.concatenate([np.empty(0, dtype=np.int64), *parts])
