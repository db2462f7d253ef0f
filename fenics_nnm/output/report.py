"""What the results of a mesh and of matrices do not share, in one place."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

from fenics_nnm.arrays import Array
from fenics_nnm.backbone.follow import Branch
from fenics_nnm.fem.blocks import Data
from fenics_nnm.output.matrix_report import MatrixReport
from fenics_nnm.output.mesh_report import MeshReport
from fenics_nnm.reduction.matrix_analysis import MatrixAnalysis
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import Analysis
from fenics_nnm.study import Study


class Report(Protocol):
    """What can be told and written of one kind of structure; to be called on all ranks."""

    def sizes(self) -> dict[str, Any]:
        """Sizes for summary.json."""

    def heading(self) -> list[str]:
        """Lines of `fenics-nnm check` about the structure and its contact points."""

    def groups(self) -> list[str]:
        """Lines of `fenics-nnm check` about named groups."""

    def place(self, point: int) -> str:
        """Where a contact point is."""

    def largest(self, q: Array, force: Array) -> str:
        """Largest displacement, with its unit, of coordinates in kg^1/2 m and forces in N."""

    def data(self) -> Data:
        """Data sets for branch.h5: arrays on rank 0, and blocks on all ranks."""

    def write_fields(self, file: Path, study: Study, branch: Branch, stages: Stages) -> None:
        """Write fields for ParaView, if there is a mesh, beside a finished branch.h5."""


def report_of(analysis: Analysis) -> Report:
    """The report of an analysis."""
    if isinstance(analysis, MatrixAnalysis):
        return MatrixReport(analysis)
    return MeshReport(analysis)
