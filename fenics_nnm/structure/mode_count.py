"""How many modes a study asks for."""

from __future__ import annotations

from fenics_nnm.errors import StudyError
from fenics_nnm.study import Study


def mode_count(study: Study, at_most: int | None, spanned: int) -> int:
    """Number of modes of a study, or `at_most` of those that hold still at the contact points.

    Raises:
        StudyError: if the number is "auto" and not found yet.
    """
    if at_most is not None:
        return max(1, min(at_most, spanned))
    modes = study.reduction.modes
    if modes == "auto":
        raise StudyError(
            'reduction.modes = "auto": is not found yet: see fenics_nnm.resolution.auto.choice'
        )
    return modes
