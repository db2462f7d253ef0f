"""What growing meshes of the rotor 37 blade cost: time by stage, memory, ratios.

    environment/run python3 benchmarks/large.py 0.003 0.0018 0.0011
    environment/run python3 benchmarks/large.py --solver iterative --linear-only 0.0011
    environment/run python3 benchmarks/large.py --solver both 0.0018

Each element size in m is a run in a process of its own, so that its peak memory is its own. Times
are CPU seconds of the process, which other work on the machine changes less than the clock; give
OMP_NUM_THREADS=1. Ratios: attachments over modes, the backbone (with its check in time) over modes
+ attachments, and all over mesh + assembly + factors + modes.
With "both" solvers the linear parts of both are compared: the largest relative difference of
frequencies, and that of the static flexibility R, over its largest entry.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
STUDY = ROOT / "demos/rotor37/rotor37.toml"

#: Energies of the branch: 30 points.
ENERGIES = "energies = { from = 0.7, to = 2.875, step = 0.075 }\nreport_at = [0.7, 1.2, 1.825, 2.8]"

#: Stages of a run, and ratios of their times.
COLUMNS = ("mesh", "assembly", "factors", "modes", "attachments", "backbone", "output")
RATIOS = ("attach/modes", "branch/m+a", "all/linear")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sizes", type=float, nargs="+", help="element sizes in m")
    solvers = ("auto", "direct", "iterative", "both")
    parser.add_argument("--solver", default="auto", choices=solvers)
    parser.add_argument("--linear-only", action="store_true", help="no branch and no files")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.child:
        print(json.dumps(measured(arguments.sizes[0], arguments.solver, arguments.linear_only)))
        return
    print(heading())
    for size in arguments.sizes:
        if arguments.solver == "both":
            direct, iterative = (
                told(size, solver, linear_only=True) for solver in ("direct", "iterative")
            )
            print(difference(direct, iterative), flush=True)
        else:
            told(size, arguments.solver, linear_only=arguments.linear_only)


def told(size: float, solver: str, *, linear_only: bool) -> dict[str, Any]:
    """A run in a process of its own, of which a row is printed."""
    options = ["--linear-only"] * linear_only
    command = [sys.executable, __file__, "--child", "--solver", solver, *options, str(size)]
    environment = {**os.environ, "FENICS_NNM_CACHE": "off"}
    ended = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, env=environment)
    found = json.loads(ended.stdout.splitlines()[-1])
    print(row(found), flush=True)
    return dict(found)


def difference(direct: dict[str, Any], iterative: dict[str, Any]) -> str:
    """How far two linear parts are from each other."""
    one, other = (np.array(each["frequencies"]) for each in (direct, iterative))
    R, S = (np.array(each["R"]) for each in (direct, iterative))
    return (
        f"iterative less direct: frequencies {np.abs(other / one - 1).max():.1e},"
        f" R {np.abs(S - R).max() / np.abs(R).max():.1e}"
    )


def measured(size: float, solver: str, linear_only: bool) -> dict[str, Any]:
    """CPU seconds of the stages and the peak memory of one run."""
    from fenics_nnm.importing import importing

    with importing():  # as fenics-nnm does
        from mpi4py import MPI

        from fenics_nnm.run import run_study
        from fenics_nnm.structure.analysis import linear_analysis
        from fenics_nnm.study import read_study

    stages = timed_stages()
    with tempfile.TemporaryDirectory() as folder:
        text = study_text(size, solver)
        file = Path(folder) / "study.toml"
        file.write_text(text)
        study, begun = read_study(file), time.perf_counter()
        linear: dict[str, Any] = {}
        if linear_only:
            found = linear_analysis(study, MPI.COMM_WORLD, stages)
            dofs = found.solid.dofs
            linear = {
                "frequencies": found.modes.frequencies.tolist(),
                "R": found.model.R.tolist(),
            }
        else:
            summary = run_study(study, text, Path(folder) / "results", stages=stages).summary
            dofs, linear = summary["dofs"], {"linear_Hz": summary["linear_frequencies_Hz"]}
    return {
        "size": size,
        "dofs": dofs,
        "clock": time.perf_counter() - begun,
        "peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20,
        **stages.timings,
        **linear,
    }


def timed_stages() -> Any:
    """Stages that count CPU seconds."""
    from collections.abc import Iterator
    from contextlib import contextmanager

    from fenics_nnm.stages import Stages

    class CpuStages(Stages):
        @contextmanager
        def stage(self, name: str) -> Iterator[None]:
            begun = time.process_time()
            yield
            spent = time.process_time() - begun
            self.timings[name] = self.timings.get(name, 0.0) + spent

    return CpuStages()


def study_text(size: float, solver: str) -> str:
    """The study of the demo with another mesh, 30 points, and this solver."""
    lines = STUDY.read_text().replace("../../meshes", str(ROOT / "meshes")).splitlines()
    kept = [
        line for line in lines if not line.startswith(("element_size", "energies", "report_at"))
    ]
    text = "\n".join(kept)
    text = text.replace("[mesh]", f"[mesh]\nelement_size = {size}")
    text = text.replace("[continuation]", f"[continuation]\n{ENERGIES}")
    return f'{text}\n\n[solver]\nlinear = "{solver}"\n'


def heading() -> str:
    names = ("size (m)", "dofs", *COLUMNS, "all", "clock", "peak GiB", *RATIOS)
    return "  ".join(f"{name:>12}" for name in names)


def row(found: dict[str, Any]) -> str:
    spent = [found.get(name, 0.0) for name in COLUMNS]
    linear = sum(spent[:4])
    numbers = (
        f"{found['size']:g}",
        f"{found['dofs']}",
        *(f"{seconds:.1f}" for seconds in spent),
        f"{sum(spent):.1f}",
        f"{found['clock']:.1f}",
        f"{found['peak']:.2f}",
        f"{found['attachments'] / found['modes']:.3f}",
        f"{found.get('backbone', 0.0) / (found['modes'] + found['attachments']):.4f}",
        f"{sum(spent) / linear:.2f}",
    )
    return "  ".join(f"{number:>12}" for number in numbers)


if __name__ == "__main__":
    main()
