"""One linear analysis for studies of one structure that differ in gaps and motions alone.

Modes and attachment solutions are kept as long as a study has the same mesh, materials, clamp and
reduction, files compared by their contents. Contact points are made anew for each study, which
takes no solution; where their contact rows are those of the kept analysis to the last bit, gaps are
all that differs, and gaps enter the reduced model as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from mpi4py import MPI

from fenics_nnm.fem.kept_mesh import StoredMesh
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import Linear, linear_analysis, with_reference
from fenics_nnm.structure.mesh_notes import report_notes
from fenics_nnm.study import Study
from fenics_nnm.study.inputs import input_digests

#: Sections of a study that say nothing about the structure.
_OF_MOTIONS = {"title", "length_unit", "mode", "augmented_lagrangian", "continuation", "output"}
_OF_MOTIONS |= {"damping", "dashpot", "excitation", "monitor", "response"}


@dataclass(slots=True)
class SharedAnalysis:
    """`linear_analysis` that takes over what it found for the study before, where that holds.

    Attributes:
        made: How many analyses had to be made.
    """

    made: int = 0
    _structure: Any = None
    _kept: dict[int | None, Linear] = field(default_factory=dict)

    def __call__(
        self,
        study: Study,
        comm: MPI.Comm,
        stages: Stages | None = None,
        *,
        at_most: int | None = None,
        stored: StoredMesh | None = None,
    ) -> Linear:
        """All that is linear of a study; arguments and errors are those of `linear_analysis`."""
        structure = on_root(comm, _identity_of, comm, study)
        if structure != self._structure or not self._is_of(stored):
            self._structure, self._kept = structure, {}
        kept = self._kept.get(at_most)
        found = _with_contact_of(study, kept, stages or Stages()) if kept else None
        if found is None:
            found = linear_analysis(study, comm, stages, at_most=at_most, stored=stored)
            if not self._kept:
                report_notes(found.notes(), comm)
            self._kept[at_most] = found
            self.made += 1
        return found

    def _is_of(self, stored: StoredMesh | None) -> bool:
        """Whether what is kept is of a mesh that an earlier run has kept, if it must be."""
        bodies = [linear.body for linear in self._kept.values()]
        digests = {body.solid.tagged.as_read.digest for body in bodies if body is not None}
        return stored is None or digests <= {stored.digest}


def values_of_structure(study: Study) -> dict[str, Any]:
    """Values of a study that its modes depend on, without contact."""
    return study.model_dump(exclude={*_OF_MOTIONS, "contact"})


def _identity_of(comm: MPI.Comm, study: Study) -> tuple[Any, ...]:
    """All that two studies share if they are of one structure, on the same ranks."""
    return comm.py2f(), values_of_structure(study), input_digests(study)


def _with_contact_of(study: Study, kept: Linear, stages: Stages) -> Linear | None:
    """The analysis with the gaps of a study; None if its contact rows are others."""
    with stages.stage("assembly"):
        found = kept.with_contact(study)
    return found and with_reference(found, study)
