"""Laws of elasticity, their orientation, the library, and what the study file says of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, Ended

from fenics_nnm.errors import ModelError
from fenics_nnm.materials.elasticity import (
    Isotropic,
    Orthotropic,
    plane_strain,
    plane_stress,
    rotated,
    uniaxial,
)
from fenics_nnm.materials.library import library, library_material
from fenics_nnm.materials.orientation import Axes, euler_axes

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]

#: A made-up material without any equal constants.
WOOD = Orthotropic((12e9, 0.9e9, 0.5e9), (0.4, 0.6, 0.45), (0.8e9, 0.05e9, 0.7e9))
E1, E2, E3 = WOOD.young
NU12, NU23, NU13 = WOOD.poisson
G12, G23, G13 = WOOD.shear


def test_stiffness_of_an_isotropic_law_in_engineering_constants() -> None:
    E, nu = 2.1e11, 0.3
    G = E / (2 * (1 + nu))
    same = Orthotropic((E, E, E), (nu, nu, nu), (G, G, G))
    np.testing.assert_allclose(same.stiffness, Isotropic(E, nu).stiffness, rtol=1e-12, atol=1.0)


def test_constants_come_back_from_uniaxial_stress_and_pure_shear() -> None:
    strain = np.linalg.solve(WOOD.stiffness, np.eye(6))  # one column a stress of 1 Pa
    np.testing.assert_allclose(1 / np.diagonal(strain)[:3], WOOD.young, rtol=1e-12)
    np.testing.assert_allclose(1 / np.diagonal(strain)[3:], (G23, G13, G12), rtol=1e-12)
    assert -strain[1, 0] / strain[0, 0] == pytest.approx(NU12)
    assert -strain[2, 1] / strain[1, 1] == pytest.approx(NU23)
    assert -strain[2, 0] / strain[0, 0] == pytest.approx(NU13)


@pytest.mark.parametrize("degrees", [0.0, 17.0, 45.0, 90.0])
def test_young_modulus_off_axis(degrees: float) -> None:
    """1/Ex = c^4/E1 + (1/G12 - 2 nu12/E1) s^2 c^2 + s^4/E2 (Jones, Eq. 2.97)."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    expected = 1 / (c**4 / E1 + (1 / G12 - 2 * NU12 / E1) * s**2 * c**2 + s**4 / E2)
    turned = rotated(WOOD.stiffness, Axes((c, s, 0.0), (-s, c, 0.0)).matrix)
    assert uniaxial(turned) == pytest.approx(expected, rel=1e-12)
    plane = np.linalg.inv(plane_stress(turned))
    assert 1 / plane[0, 0] == pytest.approx(expected, rel=1e-12)


def test_plane_stress_has_the_reduced_stiffness_of_lamination_theory() -> None:
    """Q11 = E1 / (1 - nu12 nu21) and so on (Jones, Eq. 2.61)."""
    nu21 = NU12 * E2 / E1
    scale = 1 - NU12 * nu21
    expected = [[E1 / scale, NU12 * E2 / scale, 0], [NU12 * E2 / scale, E2 / scale, 0], [0, 0, G12]]
    np.testing.assert_allclose(plane_stress(WOOD.stiffness), expected, rtol=1e-12, atol=1e-3)


def test_plane_strain_compliance() -> None:
    """beta_ij = S_ij - S_i3 S_j3 / S_33 (Lekhnitskii)."""
    S = WOOD.compliance
    beta = S[:2, :2] - np.outer(S[:2, 2], S[2, :2]) / S[2, 2]
    found = np.linalg.inv(plane_strain(WOOD.stiffness))
    np.testing.assert_allclose(found[:2, :2], beta, rtol=1e-11)


def test_plane_strain_needs_a_plane_of_symmetry() -> None:
    turned = rotated(WOOD.stiffness, euler_axes((0.0, 30.0, 0.0)).matrix)
    with pytest.raises(ModelError, match="one material axis along z"):
        plane_strain(turned)


def test_euler_angles_turn_about_z_then_the_new_x_then_the_new_z() -> None:
    np.testing.assert_allclose(
        euler_axes((90.0, 90.0, 0.0)).matrix, [[0, 1, 0], [0, 0, 1], [1, 0, 0]], atol=1e-15
    )
    np.testing.assert_allclose(
        euler_axes((30.0, 0.0, 15.0)).matrix[0],
        [np.sqrt(0.5), np.sqrt(0.5), 0.0],
        atol=1e-15,
    )


def test_energy_does_not_depend_on_the_axes_that_describe_it() -> None:
    axes = euler_axes((20.0, 50.0, 70.0)).matrix
    rng = np.random.default_rng(5)
    tensor = rng.normal(size=(3, 3))
    tensor = tensor + tensor.T

    def voigt(strain: np.ndarray) -> np.ndarray:
        xx, yy, zz = np.diagonal(strain)
        return np.array([xx, yy, zz, 2 * strain[1, 2], 2 * strain[0, 2], 2 * strain[0, 1]])

    local = voigt(axes @ tensor @ axes.T)
    whole = voigt(tensor)
    expected = local @ WOOD.stiffness @ local
    assert whole @ rotated(WOOD.stiffness, axes) @ whole == pytest.approx(expected, rel=1e-12)


def test_library_is_admissible_and_has_sources() -> None:
    assert len(library()) == 10
    for name, material in library().items():
        assert np.linalg.eigvalsh(material.law.stiffness)[0] > 0, name
        assert 1500 < material.density < 9000 and material.source, name
    fibres = library_material("CFRP AS4/3501-6").law
    # transversely isotropic: the fibres' axis is one of symmetry
    turn = euler_axes((0.0, 33.0, 0.0)).matrix
    np.testing.assert_allclose(
        rotated(fibres.stiffness, turn), fibres.stiffness, rtol=1e-6, atol=1e-6 * 126e9
    )


CFRP: dict[str, Any] = {
    "young": [126e9, 11e9, 11e9],
    "poisson": [0.28, 0.4, 0.28],
    "shear": [6.6e9, 3.93e9, 6.6e9],
    "density": 1580.0,
}
BAD: list[tuple[dict[str, Any], str]] = [
    ({"name": "Ti6Al4V"}, 'material.name = "Ti6Al4V": is not in the library: did you mean "Ti-6Al'),
    (
        {"name": "Al 6061-T6", "orientation": {"euler": [1.0, 0.0, 0.0]}},
        "orientation: has no effect",
    ),
    ({"name": "17-4PH", "young": 1.0}, "material.young: unknown key"),
    ({**CFRP, "poisson": [4.0, 0.4, 0.28]}, "nu12 = 4: must be below sqrt(E1 / E2) = 3.384"),
    ({**CFRP, "poisson": [0.28, 1.0, 0.28]}, "nu23 = 1: must be below sqrt(E2 / E3) = 1"),
    ({**CFRP, "poisson": [2.9, 0.4, 2.9]}, "negative strain energy"),
    ({**CFRP, "shear": [6.6e9, 0.0, 6.6e9]}, "material.shear = "),
    ({**CFRP, "shear": None}, "material.shear: is missing ([G12, G23, G13] in Pa)"),
    ({**CFRP, "young": [1e9, 1e9]}, "has too few items ([E1, E2, E3] in Pa)"),
    ({**CFRP, "orientation": {}}, "must have one of axes, euler and cylindrical"),
    (
        {**CFRP, "orientation": {"axes": [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]}},
        "neither zero nor parallel",
    ),
    ({**CFRP, "orientation": {"cylindrical": [0.0, 0.0, 0.0]}}, "must not be zero"),
    ({**CFRP, "orientation": {"euler": [1.0, 0.0, 0.0], "origin": [0.0, 0.0, 0.0]}}, "origin"),
    ({**CFRP, "orientation": {"cylindrical": "z"}}, "the axis runs through the material"),
]


@pytest.mark.parametrize(("material", "words"), BAD)
def test_bad_material(
    material: dict[str, Any], words: str, study_file: StudyFile, command: Command
) -> None:
    given = {key: value for key, value in material.items() if value is not None}
    command("check", study_file(BEAM, material={"=": given})).assert_one_line(2, "material", words)


@pytest.mark.parametrize(
    ("base", "orientation", "words"),
    [
        (ROD, {"cylindrical": "x", "origin": [0.0, -1.0, 0.0]}, "a body in 2-D or 3-D"),
        (PLATE, {"cylindrical": "x", "origin": [0.0, -1.0, 0.0]}, "the axis z in 2-D"),
    ],
)
def test_axis_that_the_dimension_does_not_have(
    base: dict[str, Any], orientation: Any, words: str, study_file: StudyFile, command: Command
) -> None:
    study = study_file(base, material={"=": {**CFRP, "orientation": orientation}})
    command("check", study).assert_one_line(2, words)


def test_check_prints_the_values_used_and_their_source(
    study_file: StudyFile, command: Command
) -> None:
    named = command("check", study_file(PLATE, material={"=": {"name": "Inconel 718"}}))
    assert "Inconel 718, E 200 GPa, Poisson's ratio 0.29, density 8220 kg/m^3" in named.out
    assert "source: aged: Special Metals SMC-045" in named.out
    turned = {**CFRP, "orientation": {"euler": [90.0, 0.0, 0.0]}}
    text = command("check", study_file(BEAM, material={"=": turned})).out
    assert "E1, E2, E3 126, 11, 11 GPa" in text
    assert "axes 1, 2, 3 along (0, 1, 0), (-1, 0, 0), (0, 0, 1)" in text
