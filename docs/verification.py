"""Run a study of the verification report, and put what it prints into the report.

python3 docs/verification.py SCRIPT [ARGUMENT ...]

Where a script prints a line `docs: NAME`, the lines after it, up to an empty one, take the place of
those that follow `<!-- docs: NAME -->` in a page of the report, up to an empty one. A script that
fails leaves the report as it was.
"""

from __future__ import annotations

import fcntl
import re
import subprocess
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted((ROOT / "docs").glob("verification*.md"))

#: Figures that a script prints for the report, and their place there.
PRINTED = re.compile(r"^docs: (\w+)\n((?:.+\n)+)", re.MULTILINE)
PLACE = re.compile(r"^<!-- docs: (\w+) -->\n\n((?:.+\n)+)", re.MULTILINE)


def printed(lines: Iterable[str]) -> dict[str, str]:
    """Parts for the report in the output of a script, by name."""
    text = re.sub(r"(?<=\d)%", " %", "".join(lines))
    return dict(PRINTED.findall(text))


def renewed(page: str, parts: Mapping[str, str]) -> str:
    """A page of the report with those of the parts that have their places there."""

    def part(place: re.Match[str]) -> str:
        name, old = place.groups()
        return f"<!-- docs: {name} -->\n\n{parts.get(name, old)}"

    return PLACE.sub(part, page)


def put(parts: Mapping[str, str]) -> None:
    """Renew the pages; studies that run side by side wait for each other.

    Raises:
        ValueError: if a part has no place.
    """
    places: set[str] = set()
    for path in PAGES:
        with path.open("r+") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            page = file.read()
            places |= {name for name, _ in PLACE.findall(page)}
            file.seek(0)
            file.write(renewed(page, parts))
            file.truncate()
    if missing := parts.keys() - places:
        raise ValueError(f"docs/verification*.md: no place for {', '.join(sorted(missing))}")


def main(command: list[str]) -> int:
    """Run a script, show what it prints, and keep what is for the report; its exit code."""
    if not command:
        sys.exit("usage: python3 docs/verification.py SCRIPT [ARGUMENT ...]")
    lines = []
    arguments = [sys.executable, "-u", *command]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            sys.stdout.write(line)
            sys.stdout.flush()
            lines.append(line)
    if process.returncode == 0:
        put(printed(lines))
    return process.returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
