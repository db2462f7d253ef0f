"""Parallel efficiency T1 / (n Tn) of the finite-element part of rotor 37, by stages.

Run with `python3 benchmarks/ranks.py` on a machine without other work: ranks wait for each other
by spinning, so a shared core shows the waiting and not the work. Runs on one rank and on several
take turns, and the least time of each stage is kept. The mesh is made by gmsh on rank 0 alone,
and spread over the ranks: the first is told apart, as no rank can help with it.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

#: Element sizes in m that give about 50 000 and 200 000 degrees of freedom.
SIZES = (0.0024, 0.0011)

#: Stages in the order of a run; the first is serial.
STAGES = ("gmsh", "mesh", "assembly", "factors", "modes", "attachments")

STUDY = Path(__file__).parents[1] / "demos/rotor37/rotor37.toml"


def measured(size: float) -> dict[str, float]:
    """Seconds of each stage of one analysis, the slowest rank's, and its degrees of freedom."""
    from mpi4py import MPI

    from fenics_nnm.fem import mesh
    from fenics_nnm.files.cache import turn_off
    from fenics_nnm.geometry import Geometry
    from fenics_nnm.stages import Stages
    from fenics_nnm.structure.analysis import linear_analysis
    from fenics_nnm.study import read_study

    turn_off()  # what was kept costs nothing
    comm, spent, generate = MPI.COMM_WORLD, [0.0], mesh.built_in

    def noted(geometry: Geometry) -> mesh.RawMesh:
        raw = generate(geometry)
        spent[0] = time.perf_counter() - start
        return raw

    mesh.built_in = noted
    study = read_study(STUDY)
    section = study.mesh.model_copy(update={"element_size": size})
    stages = Stages()
    comm.Barrier()
    start = time.perf_counter()
    analysis = linear_analysis(study.model_copy(update={"mesh": section}), comm, stages)
    seconds = {"gmsh": comm.bcast(spent[0]), **stages.timings}
    seconds["mesh"] -= seconds["gmsh"]
    slowest = {name: comm.allreduce(seconds[name], op=MPI.MAX) for name in STAGES}
    return {"dofs": analysis.solid.dofs, **slowest}


def timed(ranks: int, size: float) -> dict[str, float]:
    """The same in processes of its own."""
    command = ["mpirun", "-n", str(ranks), sys.executable, __file__, "--measure", str(size)]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    found: dict[str, float] = json.loads(ended.stdout.splitlines()[-1])
    return found


def compare(size: float, ranks: int, repeats: int) -> None:
    """Print the table of one mesh."""
    runs: dict[int, list[dict[str, float]]] = {1: [], ranks: []}
    for _ in range(repeats):
        for count, found in runs.items():
            found.append(timed(count, size))
    alone, together = (
        {name: min(run[name] for run in found) for name in STAGES} for found in runs.values()
    )
    print(f"{runs[1][0]['dofs']:.0f} dofs, 1 and {ranks} ranks, least of {repeats} runs, in s")
    rows = [(name, alone[name], together[name]) for name in STAGES]
    for title, parts in (("all", STAGES), ("all without gmsh", STAGES[1:])):
        rows.append((title, *(sum(each[name] for name in parts) for each in (alone, together))))
    for name, one, several in rows:
        efficiency = one / (ranks * several)
        print(f"    {name:18}{one:9.2f}{several:9.2f}   efficiency {efficiency:5.0%}", flush=True)


def main() -> None:
    """Compare one rank with several."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--sizes", type=float, nargs="+", default=SIZES, metavar="METRES")
    parser.add_argument("--measure", type=float, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.measure:
        found = measured(arguments.measure)
        from mpi4py import MPI

        if MPI.COMM_WORLD.rank == 0:
            print(json.dumps(found))
        return
    for size in arguments.sizes:
        compare(size, arguments.ranks, arguments.repeats)


if __name__ == "__main__":
    main()
