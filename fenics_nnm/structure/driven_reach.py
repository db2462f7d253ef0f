r"""How far the levels of a response move a body, which decides about the kinematics that it needs.

The estimate is that of each mode alone: with the force f of a harmonic on it, its damping c, and
the circular frequency W(a) of its free motion at the amplitude a, bouncing off its first contact
point as in `mechanics.along`, the balance of one harmonic is

    a |W(a)^2 - w^2 + i c w| = f.

The largest a at any w within the frequencies of the response is taken: without contact it is that
of the linear motion, and contact raises W, into the frequencies or out of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.along import Bounce
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.response.structure import Drive
from fenics_nnm.structure.bending import Bendable
from fenics_nnm.structure.driven_frequencies import drive_harmonics, wanted_frequencies
from fenics_nnm.structure.kinematics import asked_of_study
from fenics_nnm.study import MeshStudy

#: Amplitudes that are tried beyond first contact, and the largest over that there.
_TRIED, _LARGEST = 300, 1e4


@dataclass(frozen=True, slots=True)
class Reach:
    """Energy that a response reaches in the mode that moves most.

    Attributes:
        mode: Index of the mode.
        ratio: Its energy over that of grazing with linear kinematics.
        reason: Which motion that is, in words.
    """

    mode: int
    ratio: float
    reason: str


class Motions(Protocol):
    """Something that tells how far a response moves a body."""

    def reach(self, study: MeshStudy, straight: Bendable) -> Reach:
        """What it reaches in a mode of the body with linear kinematics; on all ranks."""


class ByContact:
    """Gaps that move drive the body, by contact alone."""

    def reach(self, study: MeshStudy, straight: Bendable) -> Reach:
        """The followed mode as far as a branch of it would go."""
        ratio = asked_of_study(study, straight)
        reason = f"gaps that move drive it, as far as mode {study.mode.number} in [continuation]"
        return Reach(study.mode.number - 1, ratio, reason)


@dataclass(frozen=True, slots=True)
class Moved:
    """How far a mode is moved.

    Attributes:
        amplitude: Largest amplitude in kg^1/2 m.
        linear: The same without obstacles.
        omega: Circular frequency in rad/s of the harmonic that moves it so far.
        harmonic: Which harmonic of the frequency of the response that is.
    """

    amplitude: float
    linear: float
    omega: float
    harmonic: int

    @property
    def place(self) -> str:
        """At which frequency of the response it is."""
        return f"{self.omega / max(self.harmonic, 1) / (2 * np.pi):.5g} Hz"


@dataclass(frozen=True, slots=True)
class ModalForces:
    """Forces of the highest level on modes.

    Attributes:
        level: That level.
        harmonics: Harmonics of the forces, shape (h,).
        forces: Sizes of the modal forces of each in N kg^-1/2, shape (h, J).
        damping: Damping c of each mode in 1/s, shape (J,).
        ends: Lowest and highest circular frequency of the response in rad/s.
    """

    level: float
    harmonics: tuple[int, ...]
    forces: Array
    damping: Array
    ends: tuple[float, float]

    @classmethod
    def of(
        cls, study: MeshStudy, omega: Array, excited: Array, sizes: Array, rate: Array
    ) -> ModalForces:
        """Those of the modes of a structure.

        Args:
            study: Study with forces.
            omega: Natural circular frequencies in rad/s, shape (J,).
            excited: Displacement of the excited places per modal coordinate, shape (p, J).
            sizes: Sizes of the forces in N, 0-peak, shape (p,).
            rate: Damping matrix of dashpots and of a matrix, in 1/s, shape (J, J).
        """
        assert study.response is not None  # refused before
        level, wanted = max(study.response.levels), wanted_frequencies(study)
        turns = np.array([each.turn for each in study.excitation])
        own = drive_harmonics(study)[: len(sizes)]
        pushes = Drive(excited, level * sizes * turns, own).excitations
        damping = np.diagonal(rate).copy()
        if study.damping is not None:
            damping += np.diagonal(study.damping.rate(omega, len(omega)))
            damping += np.diagonal(study.damping.loss(omega, len(omega))) / omega
        return cls(
            level=level,
            harmonics=tuple(each.harmonic for each in pushes),
            forces=np.array([np.abs(each.cosine - 1j * each.sine) for each in pushes]),
            damping=damping,
            ends=(2 * np.pi * float(wanted[0]), 2 * np.pi * float(wanted[-1])),
        )

    def reach(self, study: MeshStudy, straight: Bendable) -> Reach:
        """What they reach in the mode that moves most, of the masters where these are named.

        A mode that moves no contact point reaches grazing. So does the followed mode where gaps are
        not positive: what second order changes is not known there.
        """
        model, named = straight.model, study.body.masters or ()
        if (model.gap <= 0).any():
            return Reach(study.mode.number - 1, 1.0, "gaps are not positive")
        masters = [number - 1 for number in named if number <= len(self.damping)]
        found = {mode: self.moved(model, mode) for mode in masters or range(len(self.damping))}
        mode = max(found, key=lambda each: found[each].amplitude * float(model.omega[each]))
        moved, most = found[mode], f"level {self.level:g} moves mode {mode + 1} most"
        if not model.at_rest().touches(mode):
            return Reach(mode, 1.0, f"{most}, at {found[mode].place}")
        grazing = model.at_rest().amplitude(mode)
        times, free = moved.amplitude / grazing, moved.linear / grazing
        reason = f"{most}: by {times:.3g} times its amplitude at first contact, at {moved.place}"
        if free > 1 and free > times:
            reason += f" (by {free:.3g} times without obstacles)"
        return Reach(mode, times**2, reason)

    def moved(self, model: ReducedModel, mode: int) -> Moved:
        """How far a mode of a model with linear kinematics is moved."""
        touches = model.at_rest().touches(mode)
        bounce = Bounce.of(model, mode, 1.0) if touches else None
        found = [
            self._by(n, mode, float(model.omega[mode]), bounce) for n in range(len(self.forces))
        ]
        return max(found, key=lambda each: each.amplitude)

    def _by(self, number: int, mode: int, natural: float, bounce: Bounce | None) -> Moved:
        """How far the force of one harmonic moves a mode."""
        n, force = self.harmonics[number], float(self.forces[number, mode])
        at, stiffness = self._softest(n, mode, natural)
        linear = force / max(stiffness, 1e-300)
        own = Moved(linear, linear, at, n)
        if bounce is None or not force or not np.isfinite(bounce.reach):
            return own
        largest = own if linear <= bounce.reach else Moved(bounce.reach, linear, at, n)
        for ratio in np.geomspace(1.0, _LARGEST, _TRIED + 1):
            amplitude = float(ratio) * bounce.reach
            raised = natural * bounce.at(float(ratio) ** 2).frequency_ratio
            at, stiffness = self._softest(n, mode, raised)
            if amplitude * stiffness <= force:
                largest = Moved(amplitude, linear, at, n)
        return largest

    def _softest(self, n: int, mode: int, natural: float) -> tuple[float, float]:
        """Circular frequency of a harmonic at which a mode is softest, and its stiffness there."""
        low, high = (n * end for end in self.ends)
        c = float(self.damping[mode])
        at = float(np.clip(np.sqrt(max(natural**2 - c**2 / 2, 0.0)), low, high))
        return at, abs(natural**2 - at**2 + 1j * c * at)
