"""From a study to a driven structure, and the frequencies that it asks for."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from fenics_nnm.errors import StudyError
from fenics_nnm.mechanics.fourier import FourierSeries
from fenics_nnm.response.driven import ResponsePoint, response
from fenics_nnm.response.structure import DrivenStructure
from fenics_nnm.stages import Stages
from fenics_nnm.structure.analysis import structure_of
from fenics_nnm.structure.motions import assert_without_coriolis
from fenics_nnm.study import Study

#: Sections that a response needs, besides those of every study.
_NEEDED = ("damping", "excitation", "response")


def driven_structure(study: Study, comm: MPI.Comm, stages: Stages | None = None) -> DrivenStructure:
    """The driven structure of a study; to be called on all ranks.

    Raises:
        StudyError: if a section is missing, or the study cannot be driven as it is.
        MeshError, ModelError, ConvergenceError: as `Structure.driven`.
    """
    _assert_drivable(study)
    basis = structure_of(study).driven(comm, stages or Stages())
    assert study.damping is not None  # refused above
    if basis.model.gap.min() <= 0:
        raise StudyError(
            f"contact.gap = {basis.model.gap.min():g}: must be positive: the response with contact "
            "is not available yet"
        )
    return DrivenStructure(
        model=basis.model,
        rate=study.damping.rate(basis.model.omega, basis.modes),
        excited=basis.excited,
        amplitudes=np.array([each.amplitude for each in study.excitation]),
        forces=basis.forces,
    )


def driven_motions(
    study: Study, structure: DrivenStructure, stages: Stages | None = None
) -> tuple[ResponsePoint, ...]:
    """The motions of its driven structure that a study asks for."""
    assert study.response is not None  # refused by `driven_structure`
    stages = stages or Stages()
    series = FourierSeries(study.resolution.harmonics, study.resolution.samples)
    with stages.stage("response"):
        frequencies = study.response.frequencies.values
        return response(structure, series, frequencies, on_progress=stages.report)


def _assert_drivable(study: Study) -> None:
    assert_without_coriolis(study)
    missing = [name for name in _NEEDED if name not in study.driven_sections]
    if missing:
        verb = "is" if len(missing) == 1 else "are"
        raise StudyError(
            f"{', '.join(missing)}: {verb} missing: fenics-nnm response needs the sections "
            "[damping], [excitation] and [response]"
        )
    if study.automatic:
        raise StudyError(f'{study.automatic[0]} = "auto": fenics-nnm response needs a number')
    if study.reduction.method != "massless":
        raise StudyError(
            f'reduction.method = "{study.reduction.method}": fenics-nnm response needs "massless"'
        )
