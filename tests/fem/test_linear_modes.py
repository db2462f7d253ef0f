"""Linear modes against closed forms and published tables."""

import numpy as np
import pytest
from mpi4py import MPI

from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.study import MeshStudy

STEEL = {"young": 2.1e11, "poisson": 0.3, "density": 7800.0}


def analysis(
    mesh: dict, body: dict, clamp: str, contact: str, direction: tuple[float, ...], modes: int
) -> LinearAnalysis:
    study = MeshStudy.model_validate(
        {
            "mesh": mesh,
            "body": body,
            "material": STEEL,
            "clamp": {"facets": [clamp]},
            "contact": {"facets": [contact], "direction": direction, "gap": 1e-3, "points": 2}
            if body["theory"] != "rod"
            else {"facets": [contact], "direction": direction, "gap": 1e-3},
            "reduction": {"modes": modes},
        }
    )
    return linear_analysis(study, MPI.COMM_SELF)


def rod(elements: int, degree: int, modes: int = 5) -> LinearAnalysis:
    mesh = {"model": "rod", "length": 1.0, "elements": elements}
    body = {"theory": "rod", "area": 9e-4, "degree": degree}
    return analysis(mesh, body, "left", "right", (1.0,), modes)


def test_rod_of_the_paper() -> None:
    assert rod(20, 1).modes.frequencies[0] == pytest.approx(1297.5, abs=0.05)


@pytest.mark.parametrize(("degree", "rate"), [(1, 2), (2, 4)])
def test_rod_frequencies_converge_at_the_rate_of_the_elements(degree: int, rate: int) -> None:
    exact = 5 / 4 * np.sqrt(STEEL["young"] / STEEL["density"])  # third mode
    errors = [rod(n, degree).modes.frequencies[2] / exact - 1 for n in (10, 20, 40)]
    assert min(errors) > 0  # Rayleigh-Ritz: from above
    rates = np.log2([errors[0] / errors[1], errors[1] / errors[2]])
    np.testing.assert_allclose(rates, rate, atol=0.2)


def test_rod_modes_are_mass_normalised_and_static_flexibility_is_exact() -> None:
    linear = rod(40, 2)
    # sqrt(2 / (rho A L)) sin at the tip; B K^-1 B^T = L / (E A)
    expected = np.sqrt(2 / (STEEL["density"] * 9e-4))
    np.testing.assert_allclose(linear.model.Phi[0], expected, rtol=1e-4)
    static = linear.model.R[0, 0] + np.sum((linear.model.Phi / linear.model.omega) ** 2)
    assert static == pytest.approx(1 / (STEEL["young"] * 9e-4), rel=1e-9)


def plane_beam(theory: str) -> np.ndarray:
    mesh = {"model": "plate", "length": 1.0, "height": 0.02, "elements": (60, 2)}
    body = {"theory": theory, "thickness": 0.05}
    return analysis(mesh, body, "left", "right", (0.0, 1.0), 3).modes.frequencies


def test_slender_plane_stress_body_is_a_beam() -> None:
    # Euler-Bernoulli cantilever: (beta L)^2 = 3.51602, 22.0345
    inertia = np.sqrt(STEEL["young"] * 0.02**2 / 12 / STEEL["density"])
    beam = np.array([3.51602, 22.0345]) * inertia / (2 * np.pi)
    np.testing.assert_allclose(plane_beam("plane-stress")[:2], beam, rtol=4e-3)


def test_plane_strain_is_stiffer_by_the_plate_factor() -> None:
    ratio = plane_beam("plane-strain")[0] / plane_beam("plane-stress")[0]
    assert ratio == pytest.approx(1 / np.sqrt(1 - STEEL["poisson"] ** 2), rel=2e-3)


@pytest.mark.parametrize("cells", ["tetrahedron", "hexahedron"])
def test_cells_of_a_solid_beam_agree_with_beam_theory(cells: str) -> None:
    mesh = {
        "model": "beam",
        "length": 1.0,
        "width": 0.03,
        "height": 0.05,
        "elements": (30, 2, 2),
        "cells": cells,
    }
    frequencies = analysis(
        mesh, {"theory": "solid"}, "left", "right", (0.0, 0.0, 1.0), 4
    ).modes.frequencies
    radius = np.sqrt(STEEL["young"] / STEEL["density"] / 12) / (2 * np.pi)
    np.testing.assert_allclose(
        frequencies[:2], 3.51602 * radius * np.array([0.03, 0.05]), rtol=6e-3
    )


def test_no_mode_is_missed_among_pairs_of_equal_frequency() -> None:
    mesh = {
        "model": "beam",
        "length": 1.0,
        "width": 0.05,
        "height": 0.05,
        "elements": (20, 2, 2),
        "cells": "hexahedron",
    }
    linear = analysis(mesh, {"theory": "solid"}, "left", "right", (0.0, 0.0, 1.0), 7)
    assert linear.modes.frequencies[0] == pytest.approx(linear.modes.frequencies[1], rel=1e-9)
    assert linear.modes.checked_below > linear.modes.omega[-1]


def test_residual_shapes_add_what_the_modes_lack() -> None:
    linear = rod(30, 2, modes=3)
    # at rest under a unit force the tip moves by the static flexibility
    tip = linear.interface.displacement(linear.reduction.residual_shapes)[0, 0]
    assert tip == pytest.approx(linear.model.R[0, 0], rel=1e-9)
