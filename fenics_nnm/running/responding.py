"""A whole response: from a study file to a folder of results."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from mpi4py import MPI

from fenics_nnm.errors import OutputError, StudyError
from fenics_nnm.fem.blocks import Blocks, Data
from fenics_nnm.fem.conducting import led
from fenics_nnm.fem.parallel import on_root
from fenics_nnm.fields.driven import of_response
from fenics_nnm.fields.files import Shown, write_motions
from fenics_nnm.interrupts import uninterrupted
from fenics_nnm.mechanics.moving_gap import GapMotion
from fenics_nnm.output.response_lines import incomplete, kinematics_note, pieces, short_of
from fenics_nnm.output.response_report import write_response
from fenics_nnm.resolution.driven_auto import DrivenChoice, driven_choice
from fenics_nnm.response.levels import Response
from fenics_nnm.response.reported import absent, reported
from fenics_nnm.response.structure import DrivenStructure
from fenics_nnm.results import response_file, response_folder
from fenics_nnm.results.header import BranchHeader
from fenics_nnm.results.response_folder import Workplace
from fenics_nnm.results.response_resume import (
    going_on,
    known_levels,
    numbers_of,
    study_difference,
)
from fenics_nnm.running.headers import header_of
from fenics_nnm.stages import Stages
from fenics_nnm.structure.driven import assert_drivable, driven_motions
from fenics_nnm.structure.driven_frequencies import reported_frequencies
from fenics_nnm.structure.driven_linear import DrivenLinear
from fenics_nnm.study import Study
from fenics_nnm.study.inputs import input_digests
from fenics_nnm.study.resolution import Resolution

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ResponseJob:
    """What is asked for; the same on all ranks.

    Attributes:
        study: Study.
        text: Text of the study file, kept in response.h5.
        resume: Whether to begin with levels of an interrupted, or finished, response.
        comm: Communicator of the mesh.
        stages: Timings and progress.
    """

    study: Study
    text: str
    resume: bool
    comm: MPI.Intracomm
    stages: Stages


@dataclass(frozen=True, slots=True)
class Responded:
    """What a response gave.

    Attributes:
        structure: The driven structure.
        found: Its motions.
        notes: What to know of them, a line each.
        missing: What is missing, a line each.
    """

    structure: DrivenStructure
    found: Response
    notes: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()


def respond(job: ResponseJob, folder: Path) -> Responded:
    """Find the response that a study asks for, and write its results.

    Raises:
        NonlinearModeError: if the study cannot be driven, or the results not be written.
    """
    comm, asked = job.comm, job.study
    assert_drivable(asked, "response")
    earlier = on_root(comm, _numbers_before, job, folder)
    chosen = driven_choice(asked, comm, job.stages, found=earlier)
    linear, structure, study = chosen.linear, chosen.structure, chosen.study
    job = replace(job, study=study)
    if study.response and study.response.report_at and not linear.has_mesh:
        raise StudyError("response.report_at: has no effect: matrices have no ParaView files")
    inputs = on_root(comm, input_digests, study)
    header = header_of(study, structure.model, "general", text=job.text, inputs=inputs)
    with _working_in(folder, comm) as place:
        data = linear.data()
        known = led(comm, data.blocks, partial(_begun, job, place, header, structure, data))
        found = on_root(comm, _solved, job, place, structure, known).doubted(linear.doubt)
        with job.stages.stage("output"):
            notes, missing = _notes(chosen, found), tuple(missing_of(study, found))
            lines = [*_lines(missing, found), *notes]
            on_root(comm, response_file.finish, place.file, found, lines)
            _write_fields(job, place, linear, header, found, structure.gap_motion)
            on_root(comm, _publish, job, place, structure, header, found)
    return Responded(structure, found, notes, missing)


def _numbers_before(job: ResponseJob, folder: Path) -> Resolution | None:
    """Numbers that an earlier response of the study has found for "auto", if it goes on."""
    if not (job.resume and job.study.automatic):
        return None
    return numbers_of(response_folder.stored(folder), job.text)


@contextmanager
def _working_in(folder: Path, comm: MPI.Comm) -> Iterator[Workplace]:
    """A folder of this response, until its results are published or it ends by an error."""
    place = on_root(comm, response_folder.claim, folder)
    try:
        yield place
    except BaseException as error:
        if comm.rank == 0:
            with uninterrupted():
                if note := place.leave():
                    error.add_note(note)
        if isinstance(error, OSError) and not isinstance(error, OutputError):
            reason = error.strerror or error
            wrapped = OutputError(f"{error.filename or folder}: cannot be written: {reason}")
            wrapped.__notes__ = getattr(error, "__notes__", [])
            raise wrapped from error
        raise


def _begun(
    job: ResponseJob,
    place: Workplace,
    header: BranchHeader,
    structure: DrivenStructure,
    data: Data,
    blocks: Mapping[str, Blocks],
) -> Response:
    """Make response.h5, and find levels of an earlier response that are wanted again."""
    arrays = {**data.arrays, **response_file.gap_arrays(structure.gap_motion)}
    whole = Data(arrays, blocks, data.packed)
    response_file.create(place.file, header, structure.watched, whole)
    if not job.resume:
        response_folder.report(place.results, place.path)
        return Response(())
    earlier = response_folder.stored(place.results, place.path)
    chosen = going_on(earlier, header)
    if chosen is None:
        logger.warning("%s: no levels to resume from: starting anew", place.results)
        return Response(())
    return known_levels(*chosen, structure.model, structure.watched)


def _solved(
    job: ResponseJob, place: Workplace, structure: DrivenStructure, known: Response
) -> Response:
    def on_level(number: int, found: Response) -> None:
        with uninterrupted():
            response_file.keep(place.file, number, found)

    if known.levels:
        logger.info("levels taken over: %s", ", ".join(f"{each:g}" for each in known.levels))
    return driven_motions(job.study, structure, job.stages, known=known, on_level=on_level)


def _write_fields(
    job: ResponseJob,
    place: Workplace,
    linear: DrivenLinear,
    header: BranchHeader,
    found: Response,
    gap_motion: GapMotion,
) -> None:
    """Write ParaView files of the motions that are asked for, if there is a mesh."""
    numbers = reported(found, reported_frequencies(job.study))
    if not linear.has_mesh or not numbers:
        return
    folder, output = place.path / "fields", job.study.output
    on_root(job.comm, folder.mkdir)
    write_motions(
        folder,
        partial(response_file.read_body, place.file),
        of_response(header, found.points, numbers, gap_motion),
        shown=Shown(output.fields, output.frames, output.format),
        comm=job.comm,
        on_progress=job.stages.report,
    )


def missing_of(study: Study, found: Response) -> Iterator[str]:
    """What a study asks for and does not get, a line each."""
    yield from incomplete(found)
    yield from absent(found, reported_frequencies(study))


def _lines(missing: Sequence[str], found: Response) -> list[str]:
    return [
        *(f"incomplete: {line}" for line in missing),
        *(f"damped backbone: {line}" for line in short_of(found.backbone)),
    ]


def _notes(chosen: DrivenChoice, found: Response) -> tuple[str, ...]:
    numbers, choice = chosen.line(found), chosen.linear.basis.choice
    return (
        *pieces(found),
        *map(str, found.instead),
        *(kinematics_note(found, choice) if chosen.linear.has_mesh else ()),
        *([numbers] if numbers else []),
    )


def _publish(
    job: ResponseJob,
    place: Workplace,
    structure: DrivenStructure,
    header: BranchHeader,
    found: Response,
) -> None:
    """Write tables and picture, and move all results to their folder."""

    def same(stored: BranchHeader) -> bool:
        return not study_difference(stored, header)

    with uninterrupted():
        write_response(place.results, structure.monitors, found, title=job.study.title)
        if job.resume:
            response_folder.remove_interrupted(place.results, found, same)
        place.publish()
