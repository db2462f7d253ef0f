"""What is known of a study of a sweep: whether it is done, and what it gave."""

from __future__ import annotations

from collections.abc import Mapping

from fenics_nnm.errors import StudyError
from fenics_nnm.results.resume import LeavesOf, difference
from fenics_nnm.results.stored_text import values_of
from fenics_nnm.study.inputs import input_digests
from fenics_nnm.sweep.case import Case, Outcome, RunState


def state_of_ended(
    case: Case, stored: str, digests: Mapping[str, str], leaves: LeavesOf | None = None
) -> RunState:
    """How far a study is whose results are finished: as far as they are all that it asks for.

    Args:
        case: Study.
        stored: Text of the study file that the results keep.
        digests: SHA-256 of the files that went in, by their keys.
        leaves: Keys and values of a study that results depend on; by default those of a branch.

    Raises:
        StudyError: if they are of another study.
    """
    advice = f"remove {case.folder}, or choose another --output"
    found = difference(stored, case.text, leaves)
    if found:
        raise StudyError(f"{case.folder}: is of another study: {found}: {advice}")
    for key, digest in input_digests(case.study).items():
        if digests.get(key) != digest:
            raise StudyError(
                f"{case.folder}: is of another study: the file of {key} has changed: {advice}"
            )
    same = values_of(stored) == values_of(case.text)
    return RunState.ENDED if same else RunState.BEGUN


def outcome_of(case: Case, state: RunState, failure: str = "") -> Outcome:
    """What the folder of a study holds.

    Args:
        case: Study.
        state: How far it is.
        failure: Why it could not be run, if it could not.

    Raises:
        OutputError: if the results cannot be read.
    """
    if state is RunState.ENDED:
        return case.kind.ended(case)
    status = "failed" if failure else state.value
    note = "" if state is RunState.NEW else "its points are kept: sweep again to go on"
    return Outcome(case, status, failure or note)
