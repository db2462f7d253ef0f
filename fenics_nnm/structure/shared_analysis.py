"""One linear analysis for studies of one structure that differ in gaps and motions alone.

Modes and attachment solutions are kept as long as a study has the same mesh, materials, clamp and
reduction, files compared by their contents. Contact points are made anew for each study, which
takes no solution; where their contact rows are those of the kept analysis to the last bit, gaps are
all that differs, and gaps enter the reduced model as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from mpi4py import MPI

from fenics_nnm.arrays import Array
from fenics_nnm.fem.contact import ContactInterface, contact_interface
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.reduction.matrix_analysis import MatrixAnalysis
from fenics_nnm.reduction.reduction import Reduction
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import Analysis, linear_analysis, with_reference
from fenics_nnm.structure.contact_patches import contact_patches
from fenics_nnm.study import MatrixStudy, MeshStudy, Study
from fenics_nnm.study.inputs import input_digests

#: Sections of a study that say nothing about the structure.
_OF_MOTIONS = {"title", "mode", "augmented_lagrangian", "continuation", "output"}


@dataclass(slots=True)
class SharedAnalysis:
    """`linear_analysis` that takes over what it found for the study before, where that holds.

    Attributes:
        made: How many analyses had to be made.
    """

    made: int = 0
    _structure: Any = None
    _kept: dict[int | None, Analysis] = field(default_factory=dict)

    def __call__(
        self,
        study: Study,
        comm: MPI.Comm,
        stages: Stages | None = None,
        *,
        at_most: int | None = None,
    ) -> Analysis:
        """All that is linear of a study; arguments and errors are those of `linear_analysis`."""
        structure = on_root(comm, lambda: (comm.py2f(), _structure_of(study)))
        if structure != self._structure:
            self._structure, self._kept = structure, {}
        kept = self._kept.get(at_most)
        found = _with_contact_of(study, kept, stages or Stages()) if kept else None
        if found is None:
            found = linear_analysis(study, comm, stages, at_most=at_most)
            self._kept[at_most] = found
            self.made += 1
        return found


def structure_of(study: Study) -> dict[str, Any]:
    """Values of a study that its modes depend on, without contact."""
    return study.model_dump(exclude={*_OF_MOTIONS, "contact"})


def _structure_of(study: Study) -> tuple[dict[str, Any], dict[str, str]]:
    return structure_of(study), input_digests(study)


def _with_contact_of(study: Study, kept: Analysis, stages: Stages) -> Analysis | None:
    """The analysis with the gaps of a study; None if its contact rows are others."""
    with stages.stage("assembly"):
        if isinstance(study, MatrixStudy):
            assert isinstance(kept, MatrixAnalysis)
            matrices = replace(kept.matrices, gap=study.contact.gap)
            reduction = _with_gap(kept.reduction, matrices.gap)
            return with_reference(replace(kept, matrices=matrices, reduction=reduction), study)
        assert isinstance(kept, LinearAnalysis)
        interface = _interface_of(study, kept)
    if not _same_rows(interface, kept.interface):
        return None
    reduction = _with_gap(kept.reduction, interface.gap)
    return with_reference(replace(kept, interface=interface, reduction=reduction), study)


def _interface_of(study: MeshStudy, kept: LinearAnalysis) -> ContactInterface:
    return contact_interface(kept.solid, contact_patches(study.contact, kept.solid.tagged))


def _with_gap(reduction: Reduction, gap: Array) -> Reduction:
    return replace(reduction, model=replace(reduction.model, gap=gap, reference=None))


def _same_rows(first: ContactInterface, second: ContactInterface) -> bool:
    """Whether the contact rows B of two interfaces on one mesh are equal; the same on all ranks."""
    one, other = first.weights, second.weights
    pairs = [(first.directions, second.directions)]
    pairs += [(getattr(one, name), getattr(other, name)) for name in ("indptr", "indices", "data")]
    same = one.shape == other.shape and all(np.array_equal(a, b) for a, b in pairs)
    return bool(first.comm.allreduce(same, MPI.LAND))
