"""From a study to a simulation: which frequencies, from which state."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import StudyError
from fenics_nnm.response.simulation import Settled, Simulation, settled, simulation
from fenics_nnm.response.structure import DrivenStructure
from fenics_nnm.stages import Stages
from fenics_nnm.structure.driven import wanted_frequencies
from fenics_nnm.study import Study
from fenics_nnm.time_domain.damped_flow import DampedFlow

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
class Wanted:
    """What is to be simulated.

    Attributes:
        frequency: Constant frequency in Hz; None for a sweep through those of the response.
        periods: Periods at each frequency.
        way: Way of a sweep.
        level: Factor of all forces.
        start: Folder with the state to start from; None from rest.
    """

    frequency: float | None
    periods: int
    way: Way = Way.BOTH
    level: float = 1.0
    start: Path | None = None


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
        StudyError: if the state to start from is not one of the structure.
        ModelError: if its motion in time is not defined: points with mass, forces that are not
            linear, or damping that is a law of harmonics.
    """
    stages = stages or Stages()
    if structure.objection:
        raise StudyError(f"reduction.modes = {study.reduction.modes}: {structure.objection}")
    driven = structure.at_level(wanted.level)
    flow = DampedFlow.of(driven.mechanics, 1.0)
    state = _first(wanted, structure.model.omega)
    legs: list[Leg] = []
    with stages.stage("simulation"):
        for name, frequencies in _ways(study, wanted):
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


def _first(wanted: Wanted, omega: Array) -> State:
    """The state to start from: a stored one, or rest without contact and force."""
    if wanted.start is None:
        return State(np.zeros(len(omega)), np.zeros(len(omega)))
    return _stored(wanted.start / STATE_FILE, omega)


def _stored(path: Path, omega: Array) -> State:
    try:
        with np.load(path, allow_pickle=False) as file:
            q, velocity, own = (
                np.asarray(file[name], float) for name in ("q", "velocity", "omega")
            )
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise StudyError(f"{path}: cannot be read as the last state of a simulation") from error
    if q.shape != omega.shape or velocity.shape != omega.shape or own.shape != omega.shape:
        raise StudyError(f"{path}: has {q.size} modal coordinates: must be {len(omega)}")
    if not np.allclose(own, omega, rtol=_SAME, atol=0):
        raise StudyError(f"{path}: is the state of another structure: frequencies differ")
    if not (np.isfinite(q).all() and np.isfinite(velocity).all()):
        raise StudyError(f"{path}: has numbers that are not finite")
    return State(q, velocity)
