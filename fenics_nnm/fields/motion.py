"""Files of one motion: its frames, the contact surface, and where the stress is largest."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fenics_nnm.arrays import Array, in_space
from fenics_nnm.fields.body import FieldBody
from fenics_nnm.fields.invariants import principal, von_mises
from fenics_nnm.fields.selection import FieldName
from fenics_nnm.fields.stress_basis import StressBasis
from fenics_nnm.fields.surface import ContactSurface
from fenics_nnm.fields.vtu import GridFile, write_collection
from fenics_nnm.nonlinear.point import BranchPoint
from fenics_nnm.output.stored_branch import StoredBranch

VON_MISES = "von Mises stress (Pa)"
DISPLACEMENT = "displacement (m)"
PRESSURE = "contact pressure (Pa)"
GAP = "gap (m)"
PRINCIPAL = tuple(f"{which} principal stress (Pa)" for which in ("largest", "middle", "smallest"))

_OF_BODY = {"displacement", "velocity", "von_mises", "principal_stress", "stress"}
OF_STRESS = {"von_mises", "principal_stress", "stress"}
_OF_SURFACE = {"contact_pressure", "gap"}


@dataclass(frozen=True, slots=True)
class MotionFiles:
    """Writer of the motions of one branch.

    Attributes:
        folder: Folder of the files.
        branch: Branch with its mesh and shapes.
        body: Its body.
        stresses: Stresses of its shapes; needed where stresses are wanted.
        surface: Its contact surface.
        fields: Fields wanted.
        frames: Frames of a period, at equal steps; the last is one step before its end.
    """

    folder: Path
    branch: StoredBranch
    body: FieldBody
    stresses: StressBasis | None
    surface: ContactSurface
    fields: Sequence[FieldName]
    frames: int

    def write(self, name: str, point: BranchPoint, on_frame: Callable[[float], None]) -> None:
        """Write `name`.pvd and `name`_contact.pvd; the time is the part of the period.

        Raises:
            OSError: if they cannot be written.
        """
        times = [frame / self.frames for frame in range(self.frames)]
        if _OF_BODY & set(self.fields):
            frames = self._body_frames(point, times, on_frame)
            _write_frames(self.folder, name, self.body.grid, times, frames)
        if _OF_SURFACE & set(self.fields):
            frames = self._surface_frames(point, times)
            _write_frames(self.folder, f"{name}_contact", self.surface.grid, times, frames)

    def _body_frames(
        self, point: BranchPoint, times: Sequence[float], on_frame: Callable[[float], None]
    ) -> Iterator[dict[str, Array]]:
        for number, time in enumerate(times):
            phase = np.array([2 * np.pi * time])
            (displacement,) = self.branch.displacement(point, phase)
            fields = {}
            if "displacement" in self.fields:
                fields[DISPLACEMENT] = in_space(self.body.on_grid(displacement))
            if "velocity" in self.fields:
                (velocity,) = self.branch.velocity(point, phase)
                fields["velocity (m/s)"] = in_space(self.body.on_grid(velocity))
            if self.stresses and OF_STRESS & set(self.fields):
                coordinates = self.stresses.coordinates(point, phase)[0]
                fields.update(self._of_stress(self.stresses.stress(coordinates)))
            yield fields
            on_frame((number + 1) / len(times))

    def _of_stress(self, stress: Array) -> dict[str, Array]:
        fields = {}
        if "von_mises" in self.fields:
            fields[VON_MISES] = von_mises(stress)
        if "principal_stress" in self.fields:
            fields.update(zip(PRINCIPAL, principal(stress).T, strict=True))
        if "stress" in self.fields:
            fields["stress (Pa)"] = stress
        return fields

    def _surface_frames(
        self, point: BranchPoint, times: Sequence[float]
    ) -> Iterator[dict[str, Array]]:
        phase = 2 * np.pi * np.array(times)
        moved = self.branch.displacement(point, phase, self.surface.nodes)
        forces, gaps = self.branch.forces(point, phase), self.branch.gap(point, phase)
        for frame in range(len(times)):
            fields = {DISPLACEMENT: in_space(moved[frame])}
            if "contact_pressure" in self.fields:
                fields[PRESSURE] = self.surface.pressure(forces[frame])
            if "gap" in self.fields:
                fields[GAP] = self.surface.gap(gaps[frame])
            yield fields


def _write_frames(
    folder: Path,
    name: str,
    grid: GridFile,
    times: Sequence[float],
    frames: Iterator[dict[str, Array]],
) -> None:
    """Frames in a folder named like the .pvd file that lists them."""
    (folder / name).mkdir()
    files = [f"{name}/frame_{number:04d}.vtu" for number in range(len(times))]
    for file, fields in zip(files, frames, strict=True):
        grid.write(folder / file, fields)
    write_collection(folder / f"{name}.pvd", files, times)
