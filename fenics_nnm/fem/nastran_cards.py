"""Cards of Nastran bulk data, with those of included files in their place."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from fenics_nnm.errors import Code, MeshError

#: Deepest chain of INCLUDE; a longer one includes itself.
_DEEPEST = 20


@dataclass(frozen=True, slots=True)
class Line:
    """A line of a file, and where it stands."""

    text: str
    place: str


@dataclass(frozen=True, slots=True)
class BulkCard:
    """Fields of a card with those of its continuations, and where it begins."""

    name: str
    fields: list[str]
    place: str

    def has(self, index: int) -> bool:
        """Whether a field is filled."""
        return index < len(self.fields) and bool(self.fields[index])

    def whole(self, index: int, default: int | None = None) -> int:
        """A field as a whole number.

        Raises:
            MeshError: if it is no whole number, or is empty without a default.
        """
        entry = self.fields[index] if self.has(index) else ""
        if not entry and default is not None:
            return default
        try:
            return int(entry)
        except ValueError as error:
            raise MeshError(
                f'{self.place}: {self.name}: "{entry}" must be a whole number'
            ) from error

    def real(self, index: int) -> float:
        """A field as a real number, such as 1.5, 1.5E-3, 1.5D-3 or 1.5-3; 0 if it is empty.

        Raises:
            MeshError: if it is no number.
        """
        entry = self.fields[index] if self.has(index) else ""
        text = re.sub(r"(?<=[\d.])([+-]\d+)$", r"E\1", entry.upper().replace("D", "E"))
        try:
            return float(text) if text else 0.0
        except ValueError as error:
            raise MeshError(f'{self.place}: {self.name}: "{entry}" must be a number') from error


def lines_of(path: Path, depth: int = 0) -> Iterator[Line]:
    """Lines of a file, those of included files in their place.

    Raises:
        MeshError: if a file cannot be read.
    """
    if depth > _DEEPEST:
        raise MeshError(f"mesh file {path}: includes itself", code=Code.MESH_FILE)
    try:
        text = path.read_text("utf-8-sig", errors="replace")
    except OSError as error:
        raise MeshError(
            f"mesh file {path}: cannot be read: {error.strerror}", code=Code.MESH_FILE
        ) from error
    waiting = ""
    for number, line in enumerate(text.splitlines(), start=1):
        if not waiting and not re.match(r"\s*INCLUDE\b", line.upper()):
            yield Line(line, f"{path}, line {number}")
            continue
        waiting += line.partition("$")[0].strip()
        quotes = waiting.count("'") + waiting.count('"')
        if quotes == 1:
            continue  # a name over several lines
        name = re.sub(r"(?i)^\s*INCLUDE\s*", "", waiting).strip(" '\"")
        waiting = ""
        yield from lines_of(path.parent / name, depth + 1)


def bulk_cards(lines: list[Line]) -> Iterator[BulkCard]:
    """Cards of the bulk data: all lines, or those after BEGIN BULK."""
    begin = next(
        (i for i, line in enumerate(lines) if re.match(r"BEGIN\s+BULK", line.text.upper())), -1
    )
    current: BulkCard | None = None
    for line in lines[begin + 1 :]:
        text = line.text.partition("$")[0].expandtabs(8).rstrip()
        if not text:
            continue
        if text.upper().startswith("ENDDATA"):
            break
        name, fields = _split(text)
        if current is not None and (not name or name.startswith("+")):
            current.fields.extend(fields)
            continue
        if current is not None:
            yield current
        current = BulkCard(name, fields, line.place)
    if current is not None:
        yield current


def _split(line: str) -> tuple[str, list[str]]:
    """Name and fields of one line, in free, small or large fields, without continuation marks.

    A line of large fields has four of them, a line of small ones eight; a continuation has no name
    or one that begins with + or *.
    """
    if "," in line:
        first, *fields = (part.strip() for part in line.split(","))
        count = 4 if first.endswith("*") or first.startswith("*") else 8
        fields = [*fields, *[""] * count][:count]
    else:
        first = line[:8].strip()
        wide = first.endswith("*") or first.startswith("*")
        width = 16 if wide else 8
        fields = [line[i : i + width].strip() for i in range(8, 72, width)]
    name = first.upper().rstrip("*").strip()
    if first.startswith(("*", "+")):
        name = ""
    return name.split(" ")[0], fields
