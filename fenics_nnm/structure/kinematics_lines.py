"""Which kinematics a reduced model has, in words."""

from __future__ import annotations

from fenics_nnm.reduction.reduction import Reduction


def kinematics_words(reduction: Reduction) -> str:
    """Which kinematics a reduction has, and why; empty where a study does not say."""
    masters = reduction.model.kinematics.masters
    if not len(masters) and not reduction.choice.asked:
        return ""
    kind = "linear"
    if len(masters):
        kind = f"second order in mode {', '.join(str(each + 1) for each in masters)}"
    return f"{kind}: {reduction.choice.reason}"


def kinematics_lines(reduction: Reduction) -> list[str]:
    """The same as lines of a description."""
    words = kinematics_words(reduction)
    return [f"kinematics       {words}"] if words else []
