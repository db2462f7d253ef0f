"""Keyword lines of Abaqus and CalculiX input files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from fenics_nnm.errors import Code, MeshError

#: Deepest chain of *INCLUDE; a longer one includes itself.
_DEEPEST = 20

#: Keywords whose data may stand in a file of their own, with INPUT.
_WITH_DATA_ELSEWHERE = ("NODE", "ELEMENT", "EQUATION", "MPC")


@dataclass(frozen=True, slots=True)
class Card:
    """A keyword with its data lines.

    Attributes:
        keyword: Keyword in capitals, without its star.
        options: Options in capitals, with their values as written; "" for options without one.
        rows: Entries of each data line.
        place: File and line, for messages.
    """

    keyword: str
    options: dict[str, str]
    rows: list[list[str]]
    place: str

    def entries(self) -> list[str]:
        """Entries of all data lines, without empty ones."""
        return [entry for row in self.rows for entry in row if entry]

    def option(self, name: str) -> str:
        """Value of an option that must be there.

        Raises:
            MeshError: if it is not.
        """
        if not self.options.get(name):
            raise MeshError(f"{self.place}: *{self.keyword} must have {name} =")
        return self.options[name]


def cards(path: Path, depth: int = 0) -> Iterator[Card]:
    """Keywords of a file in their order, those of included files in their place.

    Raises:
        MeshError: if a file cannot be read.
    """
    if depth > _DEEPEST:
        raise MeshError(f"mesh file {path}: includes itself", code=Code.MESH_FILE)
    current: Card | None = None
    for number, line in _continued(_lines(path)):
        if not line.startswith("*"):
            if current is not None:
                current.rows.append(_entries(line))
            continue
        if current is not None:
            yield current
        current = _head(line, f"{path}, line {number}")
        if current.keyword == "INCLUDE":
            yield from cards(path.parent / current.option("INPUT"), depth + 1)
            current = None
        elif current.keyword in _WITH_DATA_ELSEWHERE and "INPUT" in current.options:
            current.rows.extend(_data(path.parent / current.option("INPUT")))
    if current is not None:
        yield current


def _lines(path: Path) -> list[str]:
    try:
        return path.read_bytes().decode("utf-8-sig", errors="replace").splitlines()
    except OSError as error:
        raise MeshError(
            f"mesh file {path}: cannot be read: {error.strerror}", code=Code.MESH_FILE
        ) from error


def _data(path: Path) -> Iterator[list[str]]:
    """Data lines of a file of their own."""
    for number, line in _continued(_lines(path)):
        if line.startswith("*"):
            raise MeshError(f"{path}, line {number}: {line[:40]}: must be data alone")
        yield _entries(line)


def _entries(line: str) -> list[str]:
    return [entry.strip() for entry in line.split(",")]


def _continued(lines: list[str]) -> Iterator[tuple[int, str]]:
    """Lines that are no comments, keyword lines that end in a comma joined to the next one."""
    joined = ""
    for number, line in enumerate(lines, start=1):
        if line.startswith("**") or not line.strip():
            continue
        joined += line.strip()
        if joined.startswith("*") and joined.endswith(","):
            continue
        yield number, joined
        joined = ""


def _head(line: str, place: str) -> Card:
    keyword, *options = (part.strip() for part in line[1:].split(","))
    pairs = (option.partition("=") for option in options)
    values = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
    return Card(" ".join(keyword.upper().split()), values, [], place)


def whole_number(entry: str, card: Card) -> int:
    """A number of a node or element.

    Raises:
        MeshError: if it is no whole number.
    """
    try:
        return int(entry)
    except ValueError as error:
        raise MeshError(f'{card.place}: "{entry}": must be a whole number') from error


def real_number(entry: str, card: Card) -> float:
    """A coordinate or angle, with E or D before its exponent; nothing is zero.

    Raises:
        MeshError: if it is no number.
    """
    try:
        return float(entry.upper().replace("D", "E")) if entry else 0.0
    except ValueError as error:
        raise MeshError(f'{card.place}: "{entry}": must be a number') from error
