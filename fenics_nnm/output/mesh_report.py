"""What can be told and written of a body on a mesh."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fenics_nnm.analysis import harmonic_balance, model_in_contact
from fenics_nnm.arrays import Array
from fenics_nnm.continuation.follow import Branch
from fenics_nnm.fem.fields import gathered_basis, write_linear_modes, write_motion
from fenics_nnm.fem.harmonic import HarmonicSolver
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.fem.patch_summary import patch_summaries
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.output.material_report import attachment_lines, material_lines
from fenics_nnm.stages import Stages
from fenics_nnm.study import Study


@dataclass(frozen=True, slots=True)
class MeshReport:
    """Report of an analysis of a mesh.

    Attributes:
        analysis: Analysis, spread over the ranks.
    """

    analysis: LinearAnalysis

    def sizes(self) -> dict[str, Any]:
        """Numbers of degrees of freedom and contact points, their area, and each patch."""
        interface = self.analysis.interface
        return {
            "dofs": self.analysis.solid.dofs,
            "contact_points": interface.count,
            "contact_area_m2": float(interface.areas.sum()),
            "contact_patches": [dict(asdict(patch)) for patch in patch_summaries(interface)],
        }

    def heading(self) -> list[str]:
        """Mesh, groups and contact in words."""
        solid, interface = self.analysis.solid, self.analysis.interface
        return [
            f"mesh             {self._cells()} cells, {solid.dofs} degrees of freedom",
            f"bounding box     {self._box()} m",
            f"facet groups     {', '.join(sorted(solid.tagged.facets))}",
            *material_lines(solid),
            *attachment_lines(solid, interface),
            f"contact          {interface.count} points, {interface.areas.sum():.6g} m^2, "
            f"gap {interface.gap.min():.4g} m",
            *(f"  {patch}" for patch in patch_summaries(interface)),
        ]

    def place(self, point: int) -> str:
        """Coordinates of a contact point, with its patch if there are several."""
        interface = self.analysis.interface
        place = "(" + ", ".join(f"{x:.5g}" for x in interface.points[point]) + ") m"
        several = len(interface.names) > 1
        return f"{place} of {interface.names[interface.patch[point]]}" if several else place

    def largest(self, q: Array, force: Array) -> str:
        """Largest displacement component of coordinates in kg^1/2 m and contact forces in N."""
        largest = np.abs(self.analysis.reduction.displacement(q, force)).max(initial=0.0)
        largest = self.analysis.solid.tagged.mesh.comm.allreduce(largest, op=MPI.MAX)
        return f"{largest:.4g} m"

    def arrays(self) -> dict[str, Array]:
        """Contact points everywhere; mesh and shapes on rank 0."""
        interface = self.analysis.interface
        contact = {
            "contact/points": interface.points,
            "contact/directions": interface.directions,
            "contact/areas": interface.areas,
            "contact/patches": interface.patch,
            "contact/patch_names": np.array([name.encode() for name in interface.names]),
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
