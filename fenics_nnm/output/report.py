"""What the results of a mesh and of matrices do not share, in one place."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from fenics_nnm.arrays import Array
from fenics_nnm.continuation.follow import Branch
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.output.matrix_report import MatrixReport
from fenics_nnm.output.mesh_report import MeshReport
from fenics_nnm.reduction.matrix_analysis import MatrixAnalysis
from fenics_nnm.stages import Stages
from fenics_nnm.study import Study

Analysis = LinearAnalysis | MatrixAnalysis
"""All that is linear of a study."""


class Report(Protocol):
    """What can be told and written of one kind of structure; to be called on all ranks."""

    def sizes(self) -> dict[str, float]:
        """Sizes for summary.json."""

    def heading(self) -> list[str]:
        """Lines of `fenics-nnm check` about the structure and its contact points."""

    def groups(self) -> list[str]:
        """Lines of `fenics-nnm check` about named groups."""

    def place(self, point: int) -> str:
        """Where a contact point is."""

    def largest(self, mode: int, amplitude: float) -> str:
        """Largest displacement of a mode at an amplitude in kg^1/2 m, with its unit."""

    def arrays(self) -> dict[str, Array]:
        """Data sets for branch.h5, complete on rank 0."""

    def write_fields(self, folder: Path, study: Study, branch: Branch, stages: Stages) -> None:
        """Write fields for ParaView, if there is a mesh, to `folder`."""


def report_of(analysis: Analysis) -> Report:
    """The report of an analysis."""
    if isinstance(analysis, MatrixAnalysis):
        return MatrixReport(analysis)
    return MeshReport(analysis)
