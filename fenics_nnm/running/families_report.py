"""What is said of the families of motions that a run met: for summary.json and the terminal."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any

from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.coexistence import Coexistence, Reach, coexistences, reaches
from fenics_nnm.backbone.family_jumps import Jump
from fenics_nnm.backbone.point import MAIN_BRANCH, BranchPoint

#: Most jumps that the terminal tells, the largest ones.
_MOST_TOLD = 3

#: What else there is where a run passed an internal resonance, by how it deals with them.
_ELSEWHERE = {
    "skip": "this run leaves their motions aside where it can; "
    'continuation.internal_resonance = "follow" shows where they lead',
    "follow": "this run goes where they lead; "
    'continuation.internal_resonance = "skip" shows the main branch beside them',
}

#: Most resonances that are named.
_MOST_NAMED = 3

logger = logging.getLogger(__name__)


def families_in_summary(branch: Branch, way: str) -> dict[str, Any]:
    """Entries of summary.json: families, jumps, motions at one energy, and what else there may be.

    Args:
        branch: Branch.
        way: How internal resonances were dealt with: "skip" or "follow".
    """
    return {
        "families": [_reach(each) for each in reaches(branch.points)],
        "jumps": [_jump(each) for each in branch.jumps],
        "coexisting_motions": [_coexistence(each) for each in coexistences(branch.points)],
        "several_families": several_families(branch, way),
    }


def several_families(branch: Branch, way: str) -> list[str]:
    """Sentences about other motions than those of the main branch; none where nothing tells any."""
    return [*_off_main(branch.points), *_at_one_energy(branch.points), *_passed(branch, way)]


def warn_of_families(branch: Branch) -> None:
    """Say where neighbours are of other families, and at which energies there are several."""
    largest = sorted(branch.jumps, key=lambda jump: -abs(jump.change))[:_MOST_TOLD]
    for jump in sorted(largest, key=lambda jump: jump.gamma_ratios):
        logger.warning("%s", jump)
    more = len(branch.jumps) - len(largest)
    if more:
        logger.warning("and %d more jumps: see jumps in summary.json", more)
    for sentence in (*_off_main(branch.points), *_at_one_energy(branch.points)):
        logger.warning("%s", sentence)


def _off_main(points: Sequence[BranchPoint]) -> list[str]:
    off = [each for each in reaches(points) if each.family != MAIN_BRANCH]
    if not off:
        return []
    count = sum(each.points for each in off)
    low = min(each.frequency[0] for each in off)
    high = max(each.frequency[1] for each in off)
    which = f"family {off[0].family}" if len(off) == 1 else f"families 2 to {off[-1].family}"
    return [
        f"{count} of {len(points)} points are not on the main branch: {which}, "
        f"{low:.6g} to {high:.6g} Hz"
    ]


def _at_one_energy(points: Sequence[BranchPoint]) -> list[str]:
    found = coexistences(points)
    return [str(max(found, key=lambda each: each.spread))] if found else []


def _passed(branch: Branch, way: str) -> list[str]:
    """What else there may be at the energies of internal resonances that the branch passed."""
    met = branch.encounters
    if not met:
        return []
    named = ", ".join(f"{each.name} near {each.frequency:.6g} Hz" for each in met[:_MOST_NAMED])
    more = f" and {len(met) - _MOST_NAMED} more" if len(met) > _MOST_NAMED else ""
    return [
        f"there are further families of motions about internal resonances ({named}{more}): "
        f"{_ELSEWHERE[way]}"
    ]


def _reach(each: Reach) -> dict[str, Any]:
    return {
        "family": each.family,
        "points": each.points,
        "confirmed": each.confirmed,
        "gamma_ratio": list(each.gamma_ratio),
        "energy_J": list(each.energy),
        "frequency_Hz": list(each.frequency),
    }


def _jump(each: Jump) -> dict[str, Any]:
    return {
        "gamma_ratio": list(each.gamma_ratios),
        "change": each.change,
        "predicted": list(each.predicted),
        "contacts_a_period": list(each.contacts),
        "words": str(each),
    }


def _coexistence(each: Coexistence) -> dict[str, Any]:
    return {
        "energy_J": each.energy,
        "families": list(each.families),
        "frequency_Hz": list(each.frequencies),
    }
