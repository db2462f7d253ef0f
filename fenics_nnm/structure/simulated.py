"""From a study to a simulation: which frequencies, from which state."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import StudyError
from fenics_nnm.response.simulation import Settled, Simulation, settled, simulation
from fenics_nnm.response.structure import DrivenStructure
from fenics_nnm.stages import Stages
from fenics_nnm.structure.driven_frequencies import wanted_frequencies
from fenics_nnm.study import Study
from fenics_nnm.time_domain.driven_flow import driven_flow

#: Natural frequencies of a stored state may differ by this part from those of the structure.
_SAME = 1e-6

#: Name of the file of the last state in a folder of results.
STATE_FILE = "state.npz"


class Way(StrEnum):
    """How a simulation goes through the frequencies of the response."""

    UP = "up"
    DOWN = "down"
    BOTH = "both"


@dataclass(frozen=True, slots=True)
class Start:
    """A stored state to start from.

    Attributes:
        q: Modal coordinates in kg^1/2 m, shape (J,).
        velocity: Their velocities, shape (J,).
        omega: Natural frequencies of the modal coordinates in rad/s, shape (J,).
        path: File that it is from.
        shapes: Displacement of the places that were watched, which tell the signs of modes, shape
            (w, J); none if they are not known.
        words: What it is, in words; nothing if there is nothing to say.
    """

    q: Array
    velocity: Array
    omega: Array
    path: Path
    shapes: Array
    words: str = ""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What is to be simulated.

    Attributes:
        frequency: Constant frequency in Hz; None for a sweep through those of the response.
        periods: Periods at each frequency.
        way: Way of a sweep.
        level: Factor of all forces.
        start: The state to start from; None from rest.
    """

    frequency: float | None
    periods: int
    way: Way = Way.BOTH
    level: float = 1.0
    start: Start | None = None


#: Periods at a constant frequency, and at each frequency of a sweep, if not given.
CONSTANT, SWEPT = 500, 20

#: Oscillations of the highest mode in a period of the force, which take a minute.
_OSCILLATIONS = 1e5

#: More periods than this are a misprint.
_MOST = 10_000_000


def asked_of(frequency: float | None, periods: int | None, way: str, level: float) -> Wanted:
    """What is to be simulated, from rest.

    Args:
        frequency: Constant frequency in Hz; None for a sweep.
        periods: Periods at each frequency; usual ones if None.
        way: Way of a sweep: "up", "down" or "both".
        level: Factor of all forces.

    Raises:
        StudyError: if one of them is out of bounds.
    """
    for name, value in (("frequency", frequency), ("level", level)):
        if value is not None and not 0 < value < float("inf"):
            raise StudyError(f"--{name} {value:g}: must be positive")
    if periods is None:
        periods = SWEPT if frequency is None else CONSTANT
    if not 0 < periods <= _MOST:
        raise StudyError(f"--periods {periods}: must be from 1 to {_MOST}")
    if way not in [each.value for each in Way]:
        raise StudyError(f"--way {way}: must be one of {', '.join(each.value for each in Way)}")
    if frequency is not None and way != "both":
        raise StudyError(f"--way {way}: has no effect with --frequency")
    return Wanted(frequency, periods, Way(way), level)


@dataclass(frozen=True, slots=True)
class State:
    """A state of a structure.

    Attributes:
        q: Modal coordinates in kg^1/2 m, shape (J,).
        velocity: Their velocities, shape (J,).
    """

    q: Array
    velocity: Array


@dataclass(frozen=True, slots=True)
class Leg:
    """A part of a simulation.

    Attributes:
        name: Its way: "constant", "up" or "down".
        found: What the structure did.
    """

    name: str
    found: Simulation


@dataclass(frozen=True, slots=True)
class Simulated:
    """A simulation.

    Attributes:
        legs: Its parts in order.
        omega: Natural frequencies of the modal coordinates in rad/s, shape (J,).
        settled: Where a motion at constant frequency has come to.
    """

    legs: tuple[Leg, ...]
    omega: Array
    settled: Settled | None = None

    @property
    def failure(self) -> str:
        """Why it was given up, or nothing."""
        return self.legs[-1].found.failure


def simulated(
    study: Study, structure: DrivenStructure, wanted: Wanted, stages: Stages | None = None
) -> Simulated:
    """Follow the structure of a study in time.

    Raises:
        StudyError: if the state to start from is not one of the structure, or a period of the force
            is too long.
        ModelError: if its motion in time is not defined: points with mass, forces that are not
            linear, or damping that is a law of harmonics.
    """
    stages = stages or Stages()
    if structure.objection:
        raise StudyError(f"reduction.modes = {study.reduction.modes}: {structure.objection}")
    driven = structure.at_level(wanted.level)
    flow = driven_flow(driven.mechanics, 1.0)
    state = _first(wanted, structure)
    ways = list(_ways(study, wanted))
    _assert_short_periods(structure.model.omega, ways)
    legs: list[Leg] = []
    with stages.stage("simulation"):
        for name, frequencies in ways:
            start = (state.q, state.velocity)
            found = simulation(
                flow, structure.watched, frequencies, start, on_progress=stages.report
            )
            state = State(found.q, found.velocity)
            legs.append(Leg(name, found))
            if found.failure:
                break
        at_last = None
        if wanted.frequency is not None and not legs[-1].found.failure:
            at_last = settled(flow, state.q, state.velocity, wanted.frequency)
    return Simulated(tuple(legs), structure.model.omega, at_last)


def first_frequency(study: Study, wanted: Wanted) -> float:
    """The frequency in Hz that a simulation begins with.

    Raises:
        StudyError: if the study has no [response] to sweep through.
    """
    if wanted.frequency is not None:
        return wanted.frequency
    if study.response is None:
        raise StudyError("response: is missing: fenics-nnm simulate needs it to sweep through")
    ends = wanted_frequencies(study)[[0, -1]]
    return float(ends[1] if wanted.way == Way.DOWN else ends[0])


def _ways(study: Study, wanted: Wanted) -> Iterator[tuple[str, Array]]:
    """Names and frequencies in Hz, one for each period, of the parts of a simulation."""
    if wanted.frequency is not None:
        yield "constant", np.full(wanted.periods, wanted.frequency)
        return
    frequencies = np.repeat(wanted_frequencies(study), wanted.periods)
    if wanted.way != Way.DOWN:
        yield Way.UP, frequencies
    if wanted.way != Way.UP:
        yield Way.DOWN, frequencies[::-1]


def _assert_short_periods(omega: Array, ways: Sequence[tuple[str, Array]]) -> None:
    """Refuse a period in which modes move so often that it is never done.

    Raises:
        StudyError: if there is one.
    """
    slowest, highest = min(values.min() for _, values in ways), omega.max() / (2 * np.pi)
    if slowest * _OSCILLATIONS < highest:
        raise StudyError(
            f"simulation at {slowest:g} Hz: must be at {highest / _OSCILLATIONS:.3g} Hz or more: "
            f"in a period of the force the highest mode, of {highest:.6g} Hz, may move "
            f"{_OSCILLATIONS:g} times"
        )


def _first(wanted: Wanted, structure: DrivenStructure) -> State:
    """The state to start from: a stored one, or rest without contact and force.

    Raises:
        StudyError: if the stored one is not of this structure.
    """
    omega, start = structure.model.omega, wanted.start
    if start is None:
        return State(np.zeros(len(omega)), np.zeros(len(omega)))
    shapes = [values.shape for values in (start.q, start.velocity, start.omega)]
    if shapes != [omega.shape] * 3:
        raise StudyError(
            f"{start.path}: has {start.q.size} modal coordinates: must be {len(omega)}"
        )
    if not np.allclose(start.omega, omega, rtol=_SAME, atol=0):
        raise StudyError(f"{start.path}: is the state of another structure: frequencies differ")
    if not (np.isfinite(start.q).all() and np.isfinite(start.velocity).all()):
        raise StudyError(f"{start.path}: has numbers that are not finite")
    signs = _signs(start.shapes, structure.watched.shapes)
    return State(signs * start.q, signs * start.velocity)


def _signs(stored: Array, shapes: Array) -> Array:
    """The sign of each mode in terms of the stored ones, by what they move, shape (J,)."""
    if stored.shape != shapes.shape:
        return np.ones(shapes.shape[1])
    return np.where(np.einsum("ij,ij->j", stored, shapes) < 0, -1.0, 1.0)


def last_state(path: Path) -> Start:
    """The last state of a simulation.

    Raises:
        StudyError: if it cannot be read.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            q, velocity, own = (
                np.asarray(file[name], float) for name in ("q", "velocity", "omega")
            )
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise StudyError(f"{path}: cannot be read as the last state of a simulation") from error
    return Start(q, velocity, own, path, np.zeros((0, len(own))))
