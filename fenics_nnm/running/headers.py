"""What a file of results says of all its motions, of a study with all its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.results.header import BranchHeader
from fenics_nnm.running.run_summary import versions
from fenics_nnm.study import Study

_NONE: Mapping[str, str] = MappingProxyType({})


def header_of(
    study: Study,
    model: ReducedModel,
    series: str,
    *,
    text: str = "",
    inputs: Mapping[str, str] = _NONE,
) -> BranchHeader:
    """The header of motions of a study.

    Args:
        study: Study with all its numbers.
        model: Model that the motions obey.
        series: "time-reversible" or "general".
        text: Text of the study file.
        inputs: Digests of the files that the study names, by key.
    """
    numbers = study.resolution
    return BranchHeader(
        study=text,
        versions=versions(),
        mode=study.mode.number,
        harmonics=numbers.harmonics,
        samples=numbers.samples,
        modes=numbers.modes,
        series=series,
        model=model,
        inputs=inputs,
    )
