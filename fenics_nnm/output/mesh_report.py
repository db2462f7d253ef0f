"""What can be told and written of a body on a mesh."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import Branch
from fenics_nnm.backbone.point import BranchPoint
from fenics_nnm.fem.blocks import Blocks, Data
from fenics_nnm.fem.conducting import led
from fenics_nnm.fem.gathering import gathered_basis, gathering
from fenics_nnm.fem.harmonic import HarmonicSolver
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.fem.patch_summary import patch_summaries
from fenics_nnm.fields.files import write_motions
from fenics_nnm.fields.linear import write_linear_modes
from fenics_nnm.output.group_table import group_table
from fenics_nnm.output.material_report import attachment_lines, material_lines
from fenics_nnm.results import branch_file
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import harmonic_balance
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
        """Mesh and contact in words."""
        solid, interface = self.analysis.solid, self.analysis.interface
        return [
            f"mesh             {self._cells()} cells, {solid.dofs} degrees of freedom",
            f"bounding box     {self._box()} m",
            *material_lines(solid),
            *attachment_lines(solid, interface),
            f"contact          {interface.count} points, {interface.areas.sum():.6g} m^2, "
            f"{'smallest ' * (len(interface.names) > 1)}gap {interface.gap.min():.4g} m",
            *(f"  {patch}" for patch in patch_summaries(interface)),
        ]

    def groups(self) -> list[str]:
        """Table of the named groups."""
        return group_table(self.analysis.solid.tagged)

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

    def data(self) -> Data:
        """Contact points everywhere, mesh on rank 0, shapes in blocks."""
        interface = self.analysis.interface
        contact = {
            "contact/points": interface.points,
            "contact/directions": interface.directions,
            "contact/areas": interface.areas,
            "contact/patches": interface.patch,
            "contact/patch_names": np.array([name.encode() for name in interface.names]),
        }
        body = gathered_basis(self.analysis)
        return replace(body, arrays={**contact, **body.arrays})

    def write_fields(self, file: Path, study: Study, branch: Branch, stages: Stages) -> None:
        """Write ParaView files of the linear modes and of the motions asked for."""
        comm, folder = self.analysis.solid.tagged.mesh.comm, file.with_name("fields")
        on_root(comm, folder.mkdir)
        write_linear_modes(folder / "linear_modes.vtu", self.analysis)
        wanted = [p for p in branch.points if p.gamma_ratio in study.continuation.report_at]
        if study.full_order:
            inertia = {p.position: self._inertial_displacement(study, p) for p in wanted}
            led(comm, inertia, lambda blocks: branch_file.add_inertia(file, blocks))

        stored = on_root(comm, lambda: branch_file.read(file)[1])
        write_motions(
            folder,
            file,
            [p for p in stored if p.gamma_ratio in study.continuation.report_at],
            fields=study.output.fields,
            frames=study.output.frames,
            comm=comm,
            on_progress=stages.report,
        )

    def _inertial_displacement(self, study: Study, point: BranchPoint) -> Blocks:
        """Harmonics of what inertia adds to the static residual shapes in m."""
        series = harmonic_balance(study).series
        with HarmonicSolver(self.analysis, harmonics=series.harmonics) as solver:
            omega, ell = 2 * np.pi * point.frequency, series.analysis @ point.force
            added = -solver.inertial_displacement(omega, series.order, ell)
        return gathering(self.analysis.solid).blocks(added.T)

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
