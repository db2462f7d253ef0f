"""What to try next where points are not verified: a sentence for each cause, with key and value.

A number that the study leaves to the program ("auto") is never to be raised: a number is given in
its place, above the one that was found.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from fenics_nnm.backbone.branch import Branch
from fenics_nnm.backbone.causes import Cause, cause_of
from fenics_nnm.backbone.point import FAILED, BranchPoint
from fenics_nnm.backbone.point_numbers import (
    damping_needed,
    harmonics_error,
    reduction_error,
    samples_error,
)
from fenics_nnm.backbone.verdict import VERIFIED_CHANGE
from fenics_nnm.resolution.auto import Choice
from fenics_nnm.resolution.finer import MOST, needed

#: A number is at least multiplied by this, and at most by that, in one step.
_LEAST, _FARTHEST = 1.5, 2.5

#: Damping ratio that is proposed where none is known that holds the motions, and the largest one.
_DAMPING, _MOST_DAMPING = 0.01, 0.1

#: Fewest samples a harmonic.
_SAMPLES_A_HARMONIC = 8

_Points = Sequence[BranchPoint]


def advice(chosen: Choice, branch: Branch) -> tuple[str, ...]:
    """Sentences about what to try next, those that concern most points first; none if all is well.

    Args:
        chosen: The study with all its numbers.
        branch: Its branch.
    """
    massless = not chosen.study.carries_mass
    by_cause: dict[Cause, list[BranchPoint]] = {}
    for point in branch.points:
        cause = cause_of(point, massless=massless)
        if cause is not None:
            by_cause.setdefault(cause, []).append(point)
    ordered = sorted(by_cause.items(), key=lambda item: -len(item[1]))
    sentences = [_SENTENCES[cause](chosen, points) for cause, points in ordered]
    return (*sentences, *_with_damping(chosen, branch.points))


def _of_mass(chosen: Choice, points: _Points) -> str:
    return (
        f"{_count(points)} with contact points that carry mass cannot be followed in time: set "
        f'reduction.method = "massless" in place of "{chosen.study.reduction.method}"'
    )


def _of_resonance(chosen: Choice, points: _Points) -> str:
    names = ", ".join(sorted({point.resonance for point in points}))
    if chosen.study.continuation.resonances == "skip":
        way = 'continuation.internal_resonance = "follow" shows where they lead'
    else:
        way = 'continuation.internal_resonance = "skip" leaves them aside'
    return f"{_count(points)} inside an internal resonance ({names}): {way}"


def _of_modes(chosen: Choice, points: _Points) -> str:
    error, now = _worst(map(reduction_error, points)), chosen.study.resolution.modes
    sizes = chosen.linear.sizes()
    most = sizes["dofs"] - sizes["contact_points"]  # contact points keep a flexibility of their own
    if now >= most:
        return f"{_count(points)} {_lack('modes', error)}: the structure has no more than {now}"
    found = min(_next("modes", now, error), most)
    return f"{_count(points)} {_lack('modes', error)}: {_set(chosen, {'modes': found})}"


def _of_harmonics(chosen: Choice, points: _Points) -> str:
    error, now = _worst(map(harmonics_error, points)), chosen.study.resolution
    found = {"harmonics": _next("harmonics", now.harmonics, error)}
    samples = _power_of_two(_SAMPLES_A_HARMONIC * found["harmonics"])
    if samples > now.samples:
        found["samples"] = samples
    return f"{_count(points)} {_lack('harmonics', error)}: {_set(chosen, found)}"


def _of_samples(chosen: Choice, points: _Points) -> str:
    error = _worst(map(samples_error, points))
    found = _power_of_two(_next("samples", chosen.study.resolution.samples, error))
    return f"{_count(points)} {_lack('samples', error)}: {_set(chosen, {'samples': found})}"


_SENTENCES: Mapping[Cause, Callable[[Choice, _Points], str]] = {
    Cause.MASS: _of_mass,
    Cause.RESONANCE: _of_resonance,
    Cause.MODES: _of_modes,
    Cause.HARMONICS: _of_harmonics,
    Cause.SAMPLES: _of_samples,
}

#: Keys of the study, by the numbers that they give.
_KEYS = {
    "modes": "reduction.modes",
    "harmonics": "mode.harmonics",
    "samples": "mode.samples",
}


def _with_damping(chosen: Choice, points: _Points) -> tuple[str, ...]:
    """Where undamped motions fail, or are inside resonances: the damped mode, which has neither."""
    if chosen.study.driven_sections or not any(point.status == FAILED for point in points):
        return ()
    needed_now = [damping_needed(point) for point in points]
    most = float(np.clip(np.nanmax([_DAMPING, *needed_now]), _DAMPING, _MOST_DAMPING))
    massless = chosen.study.reduction.method == "massless"
    method = "" if massless else ' and reduction.method = "massless"'
    return (
        "if points stay failed: with damping these motions are fewer and smoother: with [damping] "
        f"ratio = {most:.2g}{method} a run over energy follows damped motions, and fenics-nnm "
        "response, with an [[excitation]], those of given forces",
    )


def _set(chosen: Choice, found: Mapping[str, int]) -> str:
    """What to set numbers to; that it stands in place of "auto" where it does."""
    given = " and ".join(f"{_KEYS[name]} = {number}" for name, number in found.items())
    now = chosen.study.resolution
    automatic = [name for name in found if name in chosen.asked.automatic]
    if not automatic:
        return f"set {given}"
    had = " and ".join(f"{getattr(now, name)} {name}" for name in automatic)
    return f'set {given} in place of "auto", which took {had}'


def _lack(name: str, error: float) -> str:
    """Of what there are too few, and which error is expected of it, where that is known."""
    known = f", which are expected to put the frequency off by {error:.1%}"
    return f"with too few {name}{known if error >= VERIFIED_CHANGE else ''}"


def _next(source: str, now: int, error: float) -> int:
    """The number to try: what the error asks for, in a step that is not too large."""
    asked = needed(source, now, error, VERIFIED_CHANGE) if error > 0 else 0
    most = max(now + 1, getattr(MOST, source))
    return int(min(most, np.clip(asked, np.ceil(_LEAST * now), np.ceil(_FARTHEST * now))))


def _worst(errors: Iterable[float]) -> float:
    """Largest size of errors, 0 if none is known."""
    known = [abs(error) for error in errors if np.isfinite(error)]
    return max(known, default=0.0)


def _power_of_two(number: float) -> int:
    return int(2 ** np.ceil(np.log2(number)))


def _count(points: _Points) -> str:
    return f"{len(points)} point{'s' if len(points) > 1 else ''}"
