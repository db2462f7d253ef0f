"""A motion of a stored response as the state that a simulation starts from."""

from __future__ import annotations

from pathlib import Path

from fenics_nnm.errors import StudyError
from fenics_nnm.response.in_time import state_at
from fenics_nnm.response.point import ResponsePoint
from fenics_nnm.response.reported import nearest
from fenics_nnm.results import response_file
from fenics_nnm.results.response_file import NAME, StoredResponse
from fenics_nnm.structure.simulated import Start


def start_of_response(
    folder: Path, frequency: float, level: float, place: tuple[int, int] | None = None
) -> Start:
    """The state at phase 0 of the force of a motion of a response.

    Args:
        folder: Folder of the response.
        frequency: First frequency of the simulation in Hz: the nearest motion is taken, of several
            there a stable one before others, and the largest.
        level: Level of the simulation.
        place: Numbers of the branch and of the point on it, if they are given.

    Raises:
        OutputError: if the response cannot be read.
        StudyError: if it has no such motion.
    """
    stored = response_file.read(folder / NAME)
    number, point = _chosen(stored, frequency, level, place)
    q, velocity = state_at(stored.header.time_series, point.q, point.omega, 0.0)
    words = (
        f"starts from level {point.level:g}, branch {point.branch}, point {number}: "
        f"{point.frequency:.6g} Hz, {point.judgement.stability or point.status}"
    )
    return Start(
        q, velocity, stored.header.model.omega, folder / NAME, stored.watched.shapes, words
    )


def _chosen(
    stored: StoredResponse, frequency: float, level: float, place: tuple[int, int] | None
) -> tuple[int, ResponsePoint]:
    """A motion and its number on its branch, from 1."""
    found, levels = stored.found, stored.found.levels
    if level not in levels:
        raise StudyError(
            f"--level {level:g}: the response has no such level: must be one of "
            f"{', '.join(f'{each:g}' for each in levels)}"
        )
    own = found.only((level,))
    if place is not None:
        branch, number = place
        points = [point for point in own.points if point.branch == branch]
        if not 1 <= number <= len(points):
            raise StudyError(
                f"--point {branch}:{number}: level {level:g} has {len(points)} motions on branch "
                f"{branch}"
            )
        chosen = points[number - 1]
        if not chosen.found:
            raise StudyError(f"--point {branch}:{number}: is no motion: {chosen.reason}")
        return number, chosen
    near = [own.points[each] for each in nearest(own, frequency, (level,))]
    if not near:
        raise StudyError(f"--start: level {level:g} of the response has no motions")
    best = max(near, key=lambda each: (each.judgement.stability == "stable", each.amplitude[0]))
    branch_points = [point for point in own.points if point.branch == best.branch]
    return 1 + next(n for n, each in enumerate(branch_points) if each is best), best
