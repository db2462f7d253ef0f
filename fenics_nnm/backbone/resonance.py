"""Internal resonance: energy in a mode j that harmonic n of the motion meets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.mechanics.fourier import Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.mechanics.rest import RestState

#: omega_j and n omega meet within this part, or within a part of the most by which contact can
#: raise the frequency of the followed mode: n omega passes many omega_j far from resonance where
#: that is little.
_DETUNING, _OF_RANGE = 0.02, 0.06

#: A resonance this far below the linear frequency is named: a branch may begin beside it.
_BELOW = 0.05

#: A motion with more than this share of its kinetic energy in one resonance is inside it. Beyond
#: a harmonic less will do, by the square of n as the shares of a force that jumps fall.
_INSIDE, _HIGH_HARMONIC = 0.025, 20


#: With less than this part of the slope d omega / d gamma of the followed mode alone the frequency
#: stands still, and energy flows into whatever else has some of it, if ever so little: in the mouth
#: of a tongue it grows with the square of the way from first contact.
STILL, _TRACE = 0.1, 1e-12

#: With less than this part it lags behind the main branch, where it is off that already and
#: something else has more than `_INSIDE` of the energy.
LAGS = 0.5

#: A resonance with more than this part of the energy of whatever else has most of it is named.
_MAIN_PART = 0.5

#: What takes energy where the frequency stands still, and no resonance is near enough to be named.
UNNAMED = "other modes"


@dataclass(frozen=True, slots=True)
class Resonance:
    """The mode and harmonic that draw most energy from a motion in resonance.

    Attributes:
        mode: Index of the mode.
        harmonic: Number of the harmonic.
        share: Share of the mean kinetic energy in it; 0 where none meet.
    """

    mode: int
    harmonic: int
    share: float

    @property
    def strength(self) -> float:
        """Share over that of a motion that is inside the resonance."""
        inside = _INSIDE * min(1.0, (_HIGH_HARMONIC / max(self.harmonic, 1)) ** 2)
        return self.share / inside

    @property
    def entered(self) -> bool:
        """Whether the motion is inside it."""
        return self.strength > 1

    def __str__(self) -> str:
        return f"mode {self.mode + 1} in harmonic {self.harmonic}"

    def named(self, largest: float) -> str:
        """It, or "other modes" where these have most of the energy.

        Args:
            largest: Share of what has most besides the followed mode.
        """
        return str(self) if self.share > _MAIN_PART * largest else UNNAMED


def strongest_resonance(
    model: ReducedModel,
    series: Series,
    q: Array,
    omega: float,
    *,
    mode: int,
    harmonic: int = 1,
) -> Resonance:
    """The internal resonance that draws most energy.

    In it n omega stays near omega_j while energy flows into mode j, so the frequency lags behind
    that of the main branch. Modes and frequencies are those about the state of rest.

    Args:
        model: Reduced model, with frequencies in the unit of omega.
        series: Series in time.
        q: Coefficients of the motion, shape (N + 1, J).
        omega: Frequency of the motion.
        mode: Index of the followed mode.
        harmonic: Its harmonic, in which its energy does not count.
    """
    order, rest = series.order, model.at_rest()
    kinetic = _kinetic(series, q @ rest.shapes)
    total = float(kinetic.sum())
    kinetic[np.ix_(order == harmonic, [mode])] = 0.0
    detuned = np.abs(rest.omega / (np.maximum(order, 1)[:, None] * omega) - 1)
    near = detuned < _detuning(model, rest, mode)
    kinetic[~near] = 0.0
    row, column = np.unravel_index(int(np.argmax(kinetic)), kinetic.shape)
    return Resonance(int(column), int(order[row]), float(kinetic[row, column] / total))


def _detuning(model: ReducedModel, rest: RestState, mode: int) -> float:
    """Largest distance of omega_j from n omega in a resonance, relative.

    The followed mode alone, with all contact points closed, or open, for half of its motion, is a
    bilinear oscillator without a gap: its frequency does not depend on energy, and no motion goes
    beyond.
    """
    ends = model.ends_alone(mode)
    if not ends:
        return _DETUNING
    at_rest = float(rest.omega[mode])
    widest = max(abs(2 / (1 + at_rest / other) - 1) for other in ends)
    return min(_DETUNING, _OF_RANGE * widest)


def left_behind(
    series: Series, q: Array, slope_ratio: float, *, mode: int, harmonic: int = 1
) -> bool:
    """Whether a motion off the main branch is held back by other modes: in a tongue.

    There the frequency stands still, or has come to lag behind, while energy flows into them.

    Args:
        series: Series in time.
        q: Coefficients of the motion in modes about the state of rest, shape (N + 1, J).
        slope_ratio: d omega / d gamma over that of the followed mode alone; nan if unknown.
        mode: Index of the followed mode.
        harmonic: Its harmonic.
    """
    least = _TRACE if slope_ratio < STILL else _INSIDE
    return slope_ratio < LAGS and largest_share(series, q, mode, harmonic) > least


def largest_share(series: Series, q: Array, mode: int, harmonic: int = 1) -> float:
    """Largest share of the kinetic energy in one coefficient besides that of the followed mode.

    Args:
        series: Series in time.
        q: Coefficients of the motion in modes about the state of rest, shape (N + 1, J).
        mode: Index of the followed mode.
        harmonic: Its harmonic.
    """
    kinetic = _kinetic(series, q)
    total = float(kinetic.sum())
    kinetic[np.ix_(series.order == harmonic, [mode])] = 0.0
    return float(kinetic.max()) / total


def _kinetic(series: Series, q: Array) -> Array:
    """Kinetic energy by coefficient, in units of omega^2 / 2."""
    return np.asarray((series.mean_square * series.order**2)[:, None] * q**2)


@dataclass(frozen=True, slots=True)
class Meeting:
    """A frequency at which a harmonic of the motion meets a linear mode.

    Attributes:
        mode: Index of the mode j.
        harmonic: Number of the harmonic n.
        ratio: omega_j / (n omega) with the frequency omega of the followed linear mode; the branch
            meets the mode where its frequency ratio comes to this.
        gamma_ratio: Energy of that frequency on the branch of the followed mode alone; nan where
            the branch does not go there.
    """

    mode: int
    harmonic: int
    ratio: float
    gamma_ratio: float


def meetings(
    natural: Array, *, mode: int, harmonics: int, gamma_ratio: Array, frequency_ratio: Array
) -> tuple[Meeting, ...]:
    """Internal resonances on the way of a branch, by their frequency.

    Args:
        natural: Natural frequencies, shape (J,).
        mode: Index of the followed mode.
        harmonics: Number of harmonics N.
        gamma_ratio: Energies of the branch of the followed mode alone, ascending.
        frequency_ratio: Its frequencies.
    """
    found = []
    low = min(1 - _BELOW, float(frequency_ratio.min()) * (1 - _DETUNING))
    high = float(frequency_ratio.max()) * (1 + _DETUNING)
    for harmonic in range(1, harmonics + 1):
        ratios = natural / (harmonic * natural[mode])
        for index in np.flatnonzero((low < ratios) & (ratios < high)):
            if index == mode and harmonic == 1:
                continue
            ratio = float(ratios[index])
            at = passing(ratio, gamma_ratio, frequency_ratio)
            found.append(Meeting(int(index), harmonic, ratio, at))
    return tuple(sorted(found, key=lambda meeting: meeting.ratio))


def passing(ratio: float, gamma_ratio: Array, frequency_ratio: Array) -> float:
    """Energy where a branch first has a frequency; its last one where it ends before, on this side.

    Args:
        ratio: Frequency ratio.
        gamma_ratio: Energies, ascending.
        frequency_ratio: Frequencies.

    Returns:
        A gamma ratio; nan for a frequency on the side that the branch does not go to.
    """
    missing = frequency_ratio - ratio
    if missing[0] == 0:
        return float(gamma_ratio[0])
    passed = np.flatnonzero(missing[1:] * missing[0] <= 0)
    if passed.size:
        i = int(passed[0])
        part = missing[i] / (missing[i] - missing[i + 1])
        return float(gamma_ratio[i] + part * (gamma_ratio[i + 1] - gamma_ratio[i]))
    falls = frequency_ratio[-1] < frequency_ratio[0]
    ahead = missing[-1] > 0 if falls else missing[-1] < 0
    return float(gamma_ratio[-1]) if ahead else float("nan")
