"""What a study means, up to its linear modes, in words and numbers."""

from __future__ import annotations

from dataclasses import dataclass

from mpi4py import MPI

from fenics_nnm.output.description import describe
from fenics_nnm.resolution.auto import Choice, provisional
from fenics_nnm.running.first_contact_stress import first_contact_lines
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import Analyse
from fenics_nnm.study import Study


@dataclass(frozen=True, slots=True)
class Checked:
    """A study that was looked at.

    Attributes:
        chosen: The study with all its numbers, and what is linear of it.
        text: What it means.
        warnings: What looks like a wrong unit or direction, a line each.
    """

    chosen: Choice
    text: str
    warnings: tuple[str, ...]


def checked(
    study: Study, comm: MPI.Comm, stages: Stages | None = None, analyse: Analyse | None = None
) -> Checked:
    """Look at a study; to be called on all ranks.

    Args:
        study: Study.
        comm: Communicator of the mesh.
        stages: Timings and progress.
        analyse: Finds what is linear of the study, in place of `linear_analysis`.

    Raises:
        NonlinearModeError: as `linear_analysis`.
    """
    chosen = provisional(study, comm, stages, analyse)
    text = describe(chosen.prepared)
    if study.automatic:
        text += (
            f'\n\n{", ".join(study.automatic)} = "auto": a run finds what a tolerance of '
            f"{study.tolerance:g} needs; this is with {chosen.study.resolution}"
        )
    text = "\n".join([text, *first_contact_lines(chosen.prepared, comm)])
    return Checked(chosen, text, chosen.prepared.warnings())
