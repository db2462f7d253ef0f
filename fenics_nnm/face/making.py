"""Campbell diagrams, sweeps and simulations of a study, made in this process: as the commands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpi4py import MPI

from fenics_nnm.errors import StudyError
from fenics_nnm.face.arguments import different, numbers, positive, whole, wholes
from fenics_nnm.face.diagrams import Campbell, Sweep, load_campbell, load_sweep
from fenics_nnm.face.running import Asked
from fenics_nnm.face.simulation import Simulation, simulation_of
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.output.campbell_report import write_campbell
from fenics_nnm.output.simulation_report import write_simulation
from fenics_nnm.results.own_files import CAMPBELL, SIMULATION, assert_writable
from fenics_nnm.running.beginning import begin
from fenics_nnm.running.campbell_journal import CampbellJournal
from fenics_nnm.running.nonlinear_lines import NonlinearLines, assert_has_lines
from fenics_nnm.stages import Stages
from fenics_nnm.structure.campbell import FASTEST, campbell_lines
from fenics_nnm.structure.driven import driven_structure
from fenics_nnm.structure.motions_at_speed import Target, ascending
from fenics_nnm.structure.simulated import Wanted, simulated
from fenics_nnm.study.settings import Setting
from fenics_nnm.sweep.backbones import Backbones
from fenics_nnm.sweep.plan import plan_of
from fenics_nnm.sweep.responses import Responses
from fenics_nnm.sweep.sweep import begun


@dataclass(frozen=True, slots=True)
class Lines:
    """Lines of a Campbell diagram.

    Attributes:
        speeds: Speeds in rad/s.
        modes: Number of linear modes.
        orders: Engine orders.
        energies: Energies of nonlinear lines in J.
        amplitudes: Largest displacements of nonlinear lines in m.
    """

    speeds: Sequence[float]
    modes: int
    orders: Sequence[int]
    energies: Sequence[float]
    amplitudes: Sequence[float]

    @classmethod
    def given(
        cls, speeds: object, modes: object, orders: object, energies: object, amplitudes: object
    ) -> Lines:
        """Lines of what is given in Python.

        Raises:
            ValueError: if a number is none, is out of bounds, or is there twice.
        """
        return cls(
            numbers("speeds_rad_per_s", speeds),
            whole("modes", modes),
            different("orders", wholes("orders", orders)),
            positive("energies_J", energies),
            positive("amplitudes_m", amplitudes),
        )

    @property
    def targets(self) -> tuple[Target, ...]:
        """What each nonlinear line has."""
        return ascending(self.energies, self.amplitudes)

    def assert_possible(self) -> None:
        """Refuse speeds that the command would refuse.

        Raises:
            StudyError: if one is out of bounds.
        """
        steps = zip(self.speeds, self.speeds[1:], strict=False)
        if not self.speeds or self.speeds[0] < 0 or any(a >= b for a, b in steps):
            raise StudyError("speeds_rad_per_s: must rise from 0 or more")
        if self.speeds[-1] > FASTEST:
            raise StudyError(f"speeds_rad_per_s: must be {FASTEST:g} at most")


def campbell_of(asked: Asked, folder: Path, lines: Lines) -> Campbell:
    """Make a Campbell diagram; to be called on all ranks.

    Raises:
        NonlinearModeError: if it cannot be made.
    """
    begin()
    lines.assert_possible()
    study, comm, targets = asked.study, MPI.COMM_WORLD, lines.targets
    if targets:
        assert_has_lines(study, lines.modes)
    on_root(comm, assert_writable, folder, CAMPBELL)
    journal = on_root(comm, CampbellJournal.begun, folder, resume=False)
    motions = NonlinearLines(targets, comm, journal)
    speeds = [float(speed) for speed in lines.speeds]
    points = campbell_lines(study, speeds, lines.modes, comm, Stages(), motions)
    names: dict[str, Any] = {"title": study.title, "lobes": study.contact.passing_orders}
    on_root(comm, write_campbell, folder, points, list(lines.orders), **names)
    return load_campbell(folder)


def sweep_of(
    asked: Asked, folder: Path, values: Mapping[str, Sequence[Any]], *, response: bool
) -> Sweep:
    """Run all combinations of values; to be called on all ranks.

    Raises:
        NonlinearModeError: if a key or a value is wrong, or results cannot be written.
    """
    begin()
    comm = MPI.COMM_WORLD
    lists = [tuple(Setting(key, value) for value in given) for key, given in values.items()]
    kind = Responses() if response else Backbones()
    sweep = on_root(comm, lambda: begun(plan_of(asked.path, asked.text, folder, lists, kind)))
    on_root(comm, sweep.make_folder)
    if comm.size > 1:
        sweep.run_on_ranks(lambda: nullcontext(Stages()), comm, verbose=False)
    else:
        sweep.run(lambda: nullcontext(Stages()), verbose=False)
    sweep.look()
    on_root(comm, sweep.write_table)
    return load_sweep(folder)


def simulation(asked: Asked, folder: Path, wanted: Wanted) -> Simulation:
    """Follow a driven structure in time; to be called on all ranks.

    Raises:
        NonlinearModeError: if it cannot be driven, or the results not be written.
    """
    begin()
    study, comm, stages = asked.study, MPI.COMM_WORLD, Stages()
    on_root(comm, assert_writable, folder, SIMULATION)
    structure = driven_structure(study, comm, stages, "simulate")
    found = on_root(comm, simulated, study, structure, wanted, stages)
    on_root(comm, write_simulation, folder, structure.monitors, found, title=study.title)
    return simulation_of(folder, str(found.settled or ""), found.failure)
