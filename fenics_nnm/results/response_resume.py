"""What a response can take over from an earlier one of the same study: levels that are complete."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import StudyError
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.reduction.comparison import model_difference
from fenics_nnm.response.levels import Response
from fenics_nnm.response.watched import Watched
from fenics_nnm.results.header import BranchHeader
from fenics_nnm.results.response_file import StoredResponse, with_signs
from fenics_nnm.results.resume import difference
from fenics_nnm.study import Study
from fenics_nnm.study.leaves import leaves
from fenics_nnm.study.resolution import Resolution

#: Sections that may differ: they change no motion, or, as units, nothing once the study is read.
_FREE = ("title", "length_unit", "continuation", "output")

#: Keys that may differ: which motions there are.
_FREE_KEYS = ("response.levels", "response.backbone")


def going_on(
    found: list[tuple[Path, StoredResponse]], header: BranchHeader
) -> tuple[Path, StoredResponse] | None:
    """The response to go on from: the first of the same study.

    Args:
        found: Stored responses with their files.
        header: What the file of the new one says of all its motions.

    Returns:
        None if there is none.

    Raises:
        StudyError: if there are responses of other studies alone; the line names what differs.
    """
    differences = [study_difference(each.header, header) for _, each in found]
    for pair, reason in zip(found, differences, strict=True):
        if not reason:
            return pair
    if found:
        raise StudyError(f"{found[0][0]}: is of another study: {differences[0]}")
    return None


def numbers_of(found: list[tuple[Path, StoredResponse]], text: str) -> Resolution | None:
    """Harmonics, samples and modes of the first response of a study; None if there is none.

    Args:
        found: Stored responses with their files.
        text: Text of the study file.
    """
    for _, each in found:
        if not difference(each.header.study, text, response_leaves):
            return each.header.resolution
    return None


def known_levels(
    path: Path, stored: StoredResponse, model: ReducedModel, watched: Watched
) -> Response:
    """Levels of a stored response in the modal coordinates of a model.

    Modes are known up to their sign, so the columns of q take the signs of this model's modes.

    Raises:
        StudyError: if the stored model, or what is watched, is another one.
    """
    reason = model_difference(stored.header.model, model)
    if not reason and stored.watched.names != watched.names:
        reason = "other places are watched"
    if reason:
        raise StudyError(
            f"{path}: its levels cannot be taken over, as {reason}: has the mesh, or a matrix, "
            "changed?"
        )
    return with_signs(stored.found, _signs(stored, model, watched))


def _signs(stored: StoredResponse, model: ReducedModel, watched: Watched) -> Array:
    """The sign of each mode in terms of the stored ones, shape (J,)."""
    before = np.vstack([stored.header.model.Phi, stored.watched.shapes])
    now = np.vstack([model.Phi, watched.shapes])
    return np.where(np.einsum("ij,ij->j", before, now) < 0, -1.0, 1.0)


def study_difference(stored: BranchHeader, wanted: BranchHeader) -> str:
    """The first key in which two studies differ, or the first file that has changed; or nothing."""
    reason = difference(stored.study, wanted.study, response_leaves)
    if reason:
        return reason
    for key, digest in wanted.inputs.items():
        if stored.inputs.get(key, digest) != digest:
            return f"{key}: the file has changed"
    return ""


def response_leaves(study: Study) -> Iterator[tuple[str, Any]]:
    """Keys and values that the motions of a level depend on."""
    for section, values in study.model_dump(by_alias=True).items():
        if section not in _FREE and values not in (None, [], ()):
            every = leaves(section, values)
            yield from ((key, value) for key, value in every if key not in _FREE_KEYS)
