"""Branch points, switching and period doubling, against Hill's equation and the exact flow.

Two equal oscillators, coupled, each before its own obstacle of flexibility R. In phase they move as
one bilinear oscillator, in contact for T2 and free for T1 of each period, known in closed form. A
small motion y out of phase obeys Hill's equation

    y'' + (omega_2^2 + [in contact] / R) y = 0,

whose discriminant is 2 where the symmetry breaks, and -2 where the period doubles.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

from fenics_nnm.backbone.continuity import Continuity, kinetic_shares
from fenics_nnm.backbone.harmonic_copy import harmonic_copy, linear_motion
from fenics_nnm.backbone.mode_trace import FOLD_IN_OMEGA, GAMMA_UP, mode_trace
from fenics_nnm.continuation.arc_length import Problem
from fenics_nnm.continuation.branch_switching import switched
from fenics_nnm.continuation.events import BRANCH_POINT, Event
from fenics_nnm.continuation.heading import Along
from fenics_nnm.continuation.trace import Trace
from fenics_nnm.continuation.trace_options import ArcLength, Range
from fenics_nnm.errors import ModelError
from fenics_nnm.mechanics.contact_law import Complementarity
from fenics_nnm.mechanics.fourier import CosineSeries, FourierSeries, Series
from fenics_nnm.mechanics.model import ReducedModel
from fenics_nnm.nonlinear.equations import HarmonicEquations, harmonic_equations
from fenics_nnm.nonlinear.solution import Solution
from fenics_nnm.time_domain.family import Steps, periodic_motion
from fenics_nnm.time_domain.flow import Flow
from fenics_nnm.time_domain.period_map import Target, period_map

R = 0.2


def pair(natural: float) -> ReducedModel:
    """The oscillators in modal form, in units in which they touch in phase at amplitude 1."""
    s = np.sqrt(0.5)
    model = ReducedModel([1.0, natural], [[s, s], [s, -s]], R * np.eye(2), [1.0, 1.0])
    return model.dimensionless()[0]


def equations(model: ReducedModel, series: Series) -> HarmonicEquations:
    return harmonic_equations(model, series, Complementarity(model.R, model.gap))


def problem(of: HarmonicEquations) -> Problem:
    return Problem.of(of, ArcLength().newton)


def stages(energy: float) -> tuple[float, float]:
    """Free and contact time a period of x'' + x + (x - 1)_+ / R = 0."""
    free = 2 * np.arccos(-np.sqrt(1 / (2 * energy)))
    stiff = 1 + 1 / R
    contact = 2 / np.sqrt(stiff) * np.arccos(1 / np.sqrt(2 * energy * stiff - 1 / R))
    return float(free), float(contact)


def discriminant(energy: float, natural: float) -> float:
    """Trace of the monodromy matrix of a small motion out of phase."""
    free, contact = stages(energy)
    nu = np.sqrt(natural**2 + 1 / R)
    a, b = natural * free, nu * contact
    return float(2 * np.cos(a) * np.cos(b) - (natural / nu + nu / natural) * np.sin(a) * np.sin(b))


def exact_frequencies(natural: float, value: float) -> list[float]:
    """Frequencies, ascending, at which the discriminant has a value."""
    energies = np.linspace(0.501, 2.5, 800)
    missing = [discriminant(energy, natural) - value for energy in energies]
    found = [
        brentq(lambda energy: discriminant(energy, natural) - value, low, high)
        for low, high, at_low, at_high in zip(
            energies, energies[1:], missing, missing[1:], strict=False
        )
        if at_low * at_high < 0
    ]
    return [2 * np.pi / sum(stages(energy)) for energy in found]


def branch_points(branch: Trace) -> list[Event]:
    events = [point.event for point in branch if point.event is not None]
    return [event for event in events if event.kind == BRANCH_POINT.kind]


def in_phase(natural: float, series: Series) -> tuple[Trace, list[Event]]:
    of = equations(pair(natural), series)
    branch = mode_trace(
        problem(of),
        linear_motion(of, 0),
        GAMMA_UP,
        options=ArcLength(largest_step=0.05),
        gamma=Range(high=1.0),
    )
    return branch, branch_points(branch)


def test_symmetry_breaks_where_hills_equation_says() -> None:
    exact = exact_frequencies(2.05, 2.0)  # one for motions even, one for odd in time
    assert len(exact) == 2
    branch, (even,) = in_phase(2.05, CosineSeries(15, 192))
    assert branch.reason == "gamma leaves its range at 1"
    assert even.solution.omega == pytest.approx(exact[1], rel=2e-5)
    # motions odd in time feel the ends of contact, which m samples know to 1 / m
    _, both = in_phase(2.05, FourierSeries(9, 1600))
    assert [event.solution.omega for event in both] == pytest.approx(exact, rel=2e-4)


def test_kernel_at_a_symmetry_breaking_point() -> None:
    _, (point,) = in_phase(2.05, CosineSeries(9, 96))
    assert not point.at_kink
    assert point.bracket <= 1e-8
    assert point.singular_values[1] < 1e-8
    assert point.singular_values[2] > 0.1
    assert len(point.kernel) == 1
    motion = point.kernel[0][:-1].reshape(-1, 2)
    assert np.abs(motion[:, 0]).max() < 1e-6  # out of phase alone
    assert np.linalg.norm(motion[:, 1]) == pytest.approx(1.0)
    assert abs(point.kernel[0] @ point.point.tangent) < 1e-10


def test_other_branch_is_a_motion_of_the_exact_flow() -> None:
    branch, (point,) = in_phase(2.05, CosineSeries(15, 192))
    ends = []
    for side in switched(branch.problem, point):
        assert side is not None
        other = mode_trace(
            branch.problem,
            side.solution,
            Along(side.metric.unscaled(side.tangent)),
            options=ArcLength(points=12),
        )
        ends.append(list(other)[-1].solution)
    first, second = ends
    np.testing.assert_allclose(first.q, second.q * [1, -1], atol=1e-7)  # mirror images
    of = branch.problem.about(first.omega)
    shares = kinetic_shares(of, first.q).sum(axis=0)
    assert shares[1] > 0.1
    shot = exact_motion(of, first)
    assert np.linalg.norm(shot - np.append(of.model.omega * first.q.sum(axis=0), 1)) < 2e-2


def exact_motion(of: HarmonicEquations, solution: Solution) -> np.ndarray:
    """The periodic motion of the same energy that shooting finds: (omega q at rest, T / T0)."""
    start = solution.q.sum(axis=0)  # all cosines at t = 0
    flow = Flow(of.model)
    energy = flow.energy(start, np.zeros_like(start))
    period = 2 * np.pi / solution.omega
    shooting = period_map(
        flow, Target(start, np.zeros_like(start), period, energy), reversible=True
    )
    found = periodic_motion(shooting, shooting.start, Steps(), keep_energy=True)
    assert not found.failure
    amplitude = np.sqrt(2 * energy)
    return np.append(found.unknowns[:-1] * amplitude, found.unknowns[-1])


@pytest.mark.parametrize("series", [CosineSeries(5, 48), FourierSeries(5, 48)])
@pytest.mark.parametrize("k", [2, 3])
@pytest.mark.parametrize("later", [False, True])
def test_copy_is_the_same_motion(series: Series, k: int, later: bool) -> None:
    of = equations(pair(2.6), series)
    branch = mode_trace(problem(of), linear_motion(of, 0), GAMMA_UP, gamma=Range(high=0.4))
    motion = list(branch)[-1].solution
    longer, copy = harmonic_copy(of, motion, k, later=later)
    assert copy.residual < 1e-9
    assert copy.energies.gamma == pytest.approx(k**2 * motion.energies.gamma, rel=1e-12)
    assert copy.omega == pytest.approx(motion.omega / k, rel=1e-14)
    assert copy.energies.total(copy.omega) == pytest.approx(
        motion.energies.total(motion.omega), rel=1e-12
    )
    phase = np.linspace(0, 2 * np.pi, 7)
    shift = np.pi if later else 0.0
    np.testing.assert_allclose(
        longer.series.basis_at(phase) @ copy.q,
        series.basis_at(k * phase + shift) @ motion.q,
        atol=1e-12,
    )


def test_period_doubles_where_hills_equation_says() -> None:
    """A cosine series sees one of the two bounds of the unstable range from each begin."""
    exact = exact_frequencies(2.6, -2.0)
    assert len(exact) == 2
    found = []
    for later in (False, True):
        of = equations(pair(2.6), CosineSeries(9, 1600))
        longer, copy = harmonic_copy(of, linear_motion(of, 0), 2, later=later)
        branch = mode_trace(
            problem(longer),
            copy,
            GAMMA_UP,
            gamma=Range(high=2.0),
            rules=Continuity(grazing_gamma=4 * 0.25),
        )
        (point,) = branch_points(branch)
        assert len(point.kernel) == 1
        found.append(2 * point.solution.omega)
        starts = switched(branch.problem, point)
        for side in starts:
            assert side is not None
            odd = kinetic_shares(longer, side.solution.q)[1::2].sum()
            assert 1e-9 < odd < 1e-3  # off the copy, and near it
    assert found == pytest.approx(exact, rel=3e-4)


def test_subharmonic_branch_meets_the_main_one() -> None:
    """Mode 2 in harmonic 2 has a branch point where the branch of mode 1 ends in it."""
    model = ReducedModel([1.0, 1.89], [[-1.0, -12.2]], [[0.87]], [1.0])
    of = equations(model, CosineSeries(6, 64))
    main = mode_trace(problem(of), linear_motion(of, 0), GAMMA_UP, gamma=Range(low=0.007))
    (met,) = branch_points(main)
    shares = kinetic_shares(of, met.solution.q)
    assert shares[2::2, :].sum() > 1 - 1e-9  # only even harmonics are left
    alone = equations(model, CosineSeries(3, 32))
    second = mode_trace(
        problem(alone),
        linear_motion(alone, 1),
        GAMMA_UP,
        gamma=Range(high=met.solution.energies.gamma / 4),
    )
    assert list(second)[-1].solution.omega == pytest.approx(2 * met.solution.omega, rel=1e-6)


def test_folds_have_no_other_branch() -> None:
    model = ReducedModel([1.0, 3.3], [[1.0, 1.0]], [[0.1]], [1.0])
    of = equations(model, CosineSeries(6, 72))
    branch = mode_trace(problem(of), linear_motion(of, 0), GAMMA_UP)
    fold = next(point.event for point in branch if point.event is not None)
    assert fold.kind == FOLD_IN_OMEGA.kind
    with pytest.raises(ModelError, match="only a branch point"):
        switched(branch.problem, fold)


@pytest.mark.parametrize(
    ("harmonic", "amplitude", "named"), [(0, 0.5, "harmonic = 0"), (1, 1.0, "amplitude = 1")]
)
def test_bad_linear_motion_is_refused(harmonic: int, amplitude: float, named: str) -> None:
    of = equations(pair(2.6), CosineSeries(3, 16))
    with pytest.raises(ModelError, match=named):
        linear_motion(of, 0, harmonic=harmonic, amplitude=amplitude)
    with pytest.raises(ModelError, match="order 0"):
        harmonic_copy(of, linear_motion(of, 0), 0)
    assert linear_motion(of, 1, harmonic=3).omega == pytest.approx(2.6 / 3)
