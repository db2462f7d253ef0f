"""What can be told and written of a body on a mesh."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fenics_nnm.analysis import harmonic_balance, model_in_contact
from fenics_nnm.arrays import Array
from fenics_nnm.continuation.follow import Branch
from fenics_nnm.fem.fields import gathered_basis, write_linear_modes, write_motion
from fenics_nnm.fem.harmonic import HarmonicSolver
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.output.group_table import group_table
from fenics_nnm.stages import Stages
from fenics_nnm.study import Study


@dataclass(frozen=True, slots=True)
class MeshReport:
    """Report of an analysis of a mesh.

    Attributes:
        analysis: Analysis, spread over the ranks.
    """

    analysis: LinearAnalysis

    def sizes(self) -> dict[str, float]:
        """Numbers of degrees of freedom and contact points, and their area."""
        interface = self.analysis.interface
        return {
            "dofs": self.analysis.solid.dofs,
            "contact_points": interface.count,
            "contact_area_m2": float(interface.areas.sum()),
        }

    def heading(self) -> list[str]:
        """Mesh and contact in words."""
        solid, interface = self.analysis.solid, self.analysis.interface
        return [
            f"mesh             {self._cells()} cells, {solid.dofs} degrees of freedom",
            f"bounding box     {self._box()} m",
            f"contact          {interface.count} points, {interface.areas.sum():.6g} m^2, "
            f"gap {interface.gap.min():.4g} m",
        ]

    def groups(self) -> list[str]:
        """Table of the named groups."""
        return group_table(self.analysis.solid.tagged)

    def place(self, point: int) -> str:
        """Coordinates of a contact point."""
        return "(" + ", ".join(f"{x:.5g}" for x in self.analysis.interface.points[point]) + ") m"

    def largest(self, mode: int, amplitude: float) -> str:
        """Largest displacement component of a mode at an amplitude in kg^1/2 m."""
        shape = np.abs(self.analysis.reduction.shapes[:, mode]).max(initial=0.0)
        shape = self.analysis.solid.tagged.mesh.comm.allreduce(shape, op=MPI.MAX)
        return f"{shape * amplitude:.4g} m"

    def arrays(self) -> dict[str, Array]:
        """Contact points everywhere; mesh and shapes on rank 0."""
        interface = self.analysis.interface
        contact = {
            "contact/points": interface.points,
            "contact/directions": interface.directions,
            "contact/areas": interface.areas,
        }
        return {**contact, **gathered_basis(self.analysis)}

    def write_fields(self, folder: Path, study: Study, branch: Branch, stages: Stages) -> None:
        """Write ParaView files of the linear modes and of the motions asked for."""
        on_root(self.analysis.solid.tagged.mesh.comm, folder.mkdir)
        write_linear_modes(folder / "linear_modes.pvd", self.analysis)
        wanted = study.continuation.report_at
        points = [point for point in branch.points if point.gamma_ratio in wanted]
        for index, (point, name) in enumerate(zip(points, _names(points), strict=True)):
            write_motion(
                folder / f"{name}.pvd",
                self.analysis,
                point,
                model=model_in_contact(study, self.analysis),
                series=harmonic_balance(study).series,
                frames=study.output.frames,
                added=self._inertial_displacement(study, point) if study.full_order else None,
            )
            stages.report((index + 1) / len(points))

    def _inertial_displacement(self, study: Study, point: BranchPoint) -> Array:
        """Harmonics of what inertia adds to the static residual shapes, in m."""
        series = harmonic_balance(study).series
        with HarmonicSolver(self.analysis, harmonics=series.harmonics) as solver:
            omega, ell = 2 * np.pi * point.frequency, series.analysis @ point.force
            return -solver.inertial_displacement(omega, series.order, ell)

    def _cells(self) -> int:
        mesh = self.analysis.solid.tagged.mesh
        return int(mesh.topology.index_map(mesh.topology.dim).size_global)

    def _box(self) -> str:
        tagged = self.analysis.solid.tagged
        coordinates = tagged.mesh.geometry.x[:, : tagged.dim]
        pieces = [piece for piece in tagged.mesh.comm.allgather(coordinates) if len(piece)]
        points = np.concatenate(pieces)
        ranges = zip(points.min(axis=0), points.max(axis=0), strict=True)
        return " x ".join(f"[{low:.6g}, {high:.6g}]" for low, high in ranges)


def _names(points: Sequence[BranchPoint]) -> list[str]:
    """Names of motions by their energy; later passings of an energy get a number."""
    passed: Counter[float] = Counter()
    names = []
    for point in points:
        passed[point.gamma_ratio] += 1
        again = passed[point.gamma_ratio]
        names.append(f"motion_{point.gamma_ratio:g}" + (f"_passing{again}" if again > 1 else ""))
    return names
