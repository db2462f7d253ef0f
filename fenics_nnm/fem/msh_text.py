"""What is wrong with a .msh written as text, as far as can be seen without gmsh.

gmsh crashes on an element that names a node which is not there.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

#: Bytes of the largest file that is looked through.
_LARGEST = 200_000_000


def fault_of_msh(path: Path) -> str:
    """A fault of a file of format 2 or 4, empty if none is found or it is not text."""
    if path.stat().st_size > _LARGEST:
        return ""
    sections = _sections(path)
    try:
        version, binary = sections["MeshFormat"][0].split()[:2]
        if binary != "0":
            return ""
        old = version.startswith("2")
        nodes = set(_nodes_2(sections["Nodes"]) if old else _nodes_4(sections["Nodes"]))
        for element, names in (_elements_2 if old else _elements_4)(sections["Elements"]):
            missing = [node for node in names if node not in nodes]
            if missing:
                return f"element {element} has the node {missing[0]}, which is not there"
    except KeyError as error:
        return f"has no section ${error.args[0]}"
    except (ValueError, IndexError, StopIteration):
        return "a line does not have the numbers that it must have"
    return ""


def _sections(path: Path) -> dict[str, list[str]]:
    """Lines between $NAME and $EndNAME, without empty ones."""
    found: dict[str, list[str]] = {}
    current: list[str] = []
    for line in path.read_bytes().decode("latin-1").splitlines():
        text = line.strip()
        if text.startswith("$"):
            current = found.setdefault(text[1:], [])
        elif text:
            current.append(text)
    return found


def _numbers(line: str) -> list[int]:
    return [int(word) for word in line.split()]


def _nodes_2(lines: list[str]) -> Iterator[int]:
    return (int(line.split(None, 1)[0]) for line in lines[1:])


def _elements_2(lines: list[str]) -> Iterator[tuple[int, list[int]]]:
    for line in lines[1:]:
        element, _, tags, *rest = _numbers(line)
        yield element, rest[tags:]


def _nodes_4(lines: list[str]) -> Iterator[int]:
    rest = iter(lines[1:])
    for head in rest:
        _, _, _, count = _numbers(head)
        yield from (int(next(rest)) for _ in range(count))
        list(islice(rest, count))


def _elements_4(lines: list[str]) -> Iterator[tuple[int, list[int]]]:
    rest = iter(lines[1:])
    for head in rest:
        _, _, _, count = _numbers(head)
        for line in islice(rest, count):
            element, *nodes = _numbers(line)
            yield element, nodes
