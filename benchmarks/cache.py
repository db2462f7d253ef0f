"""Seconds before the backbone of the first and of the second check and run of one study.

    environment/run python3 benchmarks/cache.py [STUDY.toml] [--rounds 3]

Each command is a process of its own, as a user calls it; an empty cache lies in a folder for
temporary files. Seconds are those of the stages that the program reports, but for the backbone and
output; wall time has besides what Python takes to load the libraries. Without a study, that of
demos/step is taken. The second run must be as the first one to the last bit, and take a fifth.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]

#: Stages after those that are kept.
_AFTER = ("backbone", "output", "fields")

#: Part of the time of the first command that the second one may take.
_PART = 0.2


def seconds(command: str, study: Path, *more: str) -> tuple[float, float]:
    """Seconds of the stages before the backbone, and of the whole command."""
    begun = time.perf_counter()
    ended = subprocess.run(
        [sys.executable, "-m", "fenics_nnm", command, str(study), "--verbose", *more],
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=True,
    )
    whole = time.perf_counter() - begun
    stages = re.findall(r"^fenics-nnm: ([a-z ]+): ([0-9.]+) s$", ended.stderr, re.MULTILINE)
    return sum(float(taken) for name, taken in stages if name not in _AFTER), whole


def main() -> int:
    """Measure, print a table, and say whether the second command takes little enough."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("study", type=Path, nargs="?", default=ROOT / "demos/step/blade.toml")
    parser.add_argument("--rounds", type=int, default=1)
    arguments = parser.parse_args()
    if not (ROOT / "demos/step/results/blade.step").exists():
        subprocess.run([sys.executable, ROOT / "demos/step/blade.py"], check=True)
    slow = 0
    print("command   first (s)   second (s)   part   whole command (s)")
    for _ in range(arguments.rounds):
        for command in ("check", "run"):
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                os.environ["FENICS_NNM_CACHE"] = str(folder / "cache")
                outputs = [folder / "1", folder / "2"] if command == "run" else [None, None]
                taken = [
                    seconds(command, arguments.study, *(("--output", str(o)) if o else ()))
                    for o in outputs
                ]
                if command == "run":
                    tables = {(o / "backbone.csv").read_bytes() for o in outputs if o}
                    assert len(tables) == 1, "the second run is another one"
            (first, whole), (second, again) = taken
            slow += second > _PART * first
            print(
                f"{command:8s} {first:10.2f} {second:12.2f} {second / first:6.2f}   "
                f"{whole:.1f} -> {again:.1f}"
            )
    return 1 if slow else 0


if __name__ == "__main__":
    sys.exit(main())
