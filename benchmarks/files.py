"""What ParaView files of a finished run cost in both formats, on one rank and on several.

    environment/run python3 benchmarks/files.py results/branch.h5 --gamma 0.7 1.2 1.825 2.8

Exports with one rank and with several take turns, and the least of each is kept. Seconds by the
clock are those of the slowest rank, CPU seconds those of the busiest, without starting Python;
memory is the most that one rank had of its own: pages of branch.h5 are not counted, as they can
be given back at any time.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any


def measured(file: Path, ratios: list[float], frames: int, form: Any) -> dict[str, float]:
    """Seconds and memory of one export, the largest of all ranks."""
    from mpi4py import MPI

    from fenics_nnm.field_names import DEFAULT_FIELDS
    from fenics_nnm.fields.export import export
    from fenics_nnm.fields.files import Shown

    comm, ended, most = MPI.COMM_WORLD, threading.Event(), [0.0]
    watch = threading.Thread(target=watched, args=(ended, most), daemon=True)
    with tempfile.TemporaryDirectory() as own:
        folder = Path(comm.bcast(own)) / "export"
        comm.Barrier()
        begun, cpu = time.perf_counter(), time.process_time()
        watch.start()
        export(file, folder, ratios, shown=Shown(DEFAULT_FIELDS, frames, form), comm=comm)
        found = {"clock": time.perf_counter() - begun, "cpu": time.process_time() - cpu}
        ended.set()
        watch.join()
        comm.Barrier()
        files = [path for path in folder.rglob("*") if path.is_file()]
        found["MB"] = sum(path.stat().st_size for path in files) / 1e6
    found["GiB"] = most[0]
    return {name: comm.allreduce(value, op=MPI.MAX) for name, value in found.items()}


def watched(ended: threading.Event, most: list[float]) -> None:
    """Note the most memory of this process that is not of files, in GiB, until it ends."""
    while not ended.wait(0.02):
        lines = Path("/proc/self/status").read_text().splitlines()
        kibibytes = next(line.split()[1] for line in lines if line.startswith("RssAnon:"))
        most[0] = max(most[0], float(kibibytes) / 2**20)


def timed(ranks: int, form: str, arguments: argparse.Namespace) -> dict[str, Any]:
    """The same in processes of its own."""
    own = [sys.executable, __file__, "--measure", str(arguments.file), "--gamma"]
    own += [*map(str, arguments.gamma), "--frames", str(arguments.frames), "--formats", form]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    command = ["mpirun", "-n", str(ranks), *own]
    ended = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    found: dict[str, Any] = json.loads(ended.stdout.splitlines()[-1])
    return found


def main() -> None:
    """Compare one rank with several."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="branch.h5")
    parser.add_argument("--gamma", type=float, nargs="+", required=True, help="gamma ratios")
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--formats", nargs="+", default=["vtu", "vtkhdf"])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.measure:
        found = measured(arguments.file, arguments.gamma, arguments.frames, *arguments.formats)
        from mpi4py import MPI

        if MPI.COMM_WORLD.rank == 0:
            print(json.dumps(found))
        return
    kinds = [(form, ranks) for form in arguments.formats for ranks in (1, arguments.ranks)]
    runs: dict[tuple[str, int], list[dict[str, Any]]] = {kind: [] for kind in kinds}
    for _ in range(arguments.repeats):
        for (form, ranks), found in runs.items():
            found.append(timed(ranks, form, arguments))
    for (form, ranks), found in runs.items():
        clock, cpu, memory, size = (
            min(run[name] for run in found) for name in ("clock", "cpu", "GiB", "MB")
        )
        print(
            f"{form}, {ranks} ranks: {clock:.2f} s, {cpu:.2f} s of CPU time and {memory:.2f} GiB a "
            f"rank, {size:.1f} MB"
        )


if __name__ == "__main__":
    main()
