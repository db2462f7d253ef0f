"""What a sweep saves: gaps of a blade in one sweep, against lone runs of the same studies.

    environment/run python3 benchmarks/sweep.py [--gaps 4] [--element-size 5.0]

Both ways run in turn on one core, and CPU seconds of their processes are compared, so that other
work on the machine matters little. The backbones must be the same to the last byte. No ParaView
files are written: they are no part of what is shared, and take longer than a backbone.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

GAP = 3.56e-4


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gaps", type=int, default=4)
    parser.add_argument("--element-size", type=float, default=5.0, help="mm")
    arguments = parser.parse_args()
    gaps = [GAP * (1 + number / 10) for number in range(arguments.gaps)]
    common = ("--set", f"mesh.element_size={arguments.element_size}",
              "--set", "continuation.report_at=[]")  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        nnm("new", "blade", folder=folder)
        lone = [
            nnm("run", "blade.toml", *common, "--set", f"contact.gap={gap!r}",
                "--output", f"lone/{number}", folder=folder)
            for number, gap in enumerate(gaps)
        ]  # fmt: skip
        values = ",".join(map(repr, gaps))
        swept = nnm("sweep", "blade.toml", "--set", f"contact.gap={values}", *common,
                    "--output", "sweep", folder=folder)  # fmt: skip
        report(Path(folder), lone, swept)


def nnm(*words: str, folder: str) -> float:
    """CPU seconds of a command."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "fenics_nnm", *words]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def report(folder: Path, lone: list[float], swept: float) -> None:
    studies = sorted((folder / "sweep").glob("contact.gap=*"))
    for number, study in enumerate(studies):
        backbones = study / "backbone.csv", folder / "lone" / str(number) / "backbone.csv"
        assert backbones[0].read_bytes() == backbones[1].read_bytes(), study
    sizes = json.loads((studies[0] / "summary.json").read_text())
    print(f"{sizes['dofs']} dofs, {len(lone)} gaps; CPU seconds")
    print(f"lone runs   {sum(lone):8.1f}   ({min(lone):.1f} each)")
    print(f"one sweep   {swept:8.1f}")
    print(f"ratio       {sum(lone) / swept:8.2f}")


if __name__ == "__main__":
    main()
