"""Laws of linear elasticity as matrices of the six independent components.

Components in the order 11, 22, 33, 23, 13, 12, with engineering shear strains gamma = 2 epsilon,
so that the strain energy per volume is strain^T stiffness strain / 2.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_nnm.arrays import Array
from fenics_nnm.errors import Code, ModelError

#: Places of the components in a symmetric tensor.
PLACES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))

#: Components in the x-y plane, and those out of it.
IN_PLANE, OUT_OF_PLANE = (0, 1, 5), (2, 3, 4)

#: A compliance with a smaller ratio of eigenvalues than this holds no energy in some strain.
_SEMIDEFINITE = 1e-12

Three = tuple[float, float, float]


class Law(Protocol):
    """A law of linear elasticity in material axes."""

    @property
    def directional(self) -> bool:
        """Whether it depends on the directions of the material axes."""

    @property
    def moduli(self) -> tuple[float, ...]:
        """Young's moduli in Pa, one or three."""

    @property
    def stiffness(self) -> Array:
        """Stiffness matrix in Pa, shape (6, 6)."""

    @property
    def words(self) -> str:
        """Its constants with their units."""


@dataclass(frozen=True, slots=True)
class Isotropic:
    """Isotropic elasticity.

    Attributes:
        young: Young's modulus in Pa.
        poisson: Poisson's ratio.
    """

    young: float
    poisson: float

    @property
    def directional(self) -> bool:
        """All directions are alike."""
        return False

    @property
    def moduli(self) -> tuple[float, ...]:
        """Young's modulus in Pa."""
        return (self.young,)

    @property
    def words(self) -> str:
        """Its constants with their units."""
        return f"E {self.young / 1e9:.6g} GPa, Poisson's ratio {self.poisson:g}"

    @property
    def lame(self) -> tuple[float, float]:
        """Lame's parameters lambda and mu in Pa."""
        E, nu = self.young, self.poisson
        return E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))

    @property
    def stiffness(self) -> Array:
        """Stiffness matrix in Pa, shape (6, 6)."""
        lam, mu = self.lame
        matrix = np.diag([2 * mu, 2 * mu, 2 * mu, mu, mu, mu])
        matrix[:3, :3] += lam
        return matrix


@dataclass(frozen=True, slots=True)
class Orthotropic:
    """Orthotropic elasticity by engineering constants in the material axes 1, 2, 3.

    nu_ij is minus the strain along j over that along i when stress acts along i alone, so that
    nu_ij / E_i = nu_ji / E_j (R. M. Jones, Mechanics of Composite Materials, 2nd ed., Eq. 2.25).

    Attributes:
        young: E1, E2, E3 in Pa.
        poisson: nu12, nu23, nu13.
        shear: G12, G23, G13 in Pa.

    Raises:
        ModelError: if some strain would have no or negative energy.
    """

    young: Three
    poisson: Three
    shear: Three

    def __post_init__(self) -> None:
        scale = np.sqrt(np.abs(np.diagonal(self.compliance)))
        if np.linalg.eigvalsh(self.compliance / np.outer(scale, scale))[0] < _SEMIDEFINITE:
            raise ModelError(self._inadmissible())

    @property
    def directional(self) -> bool:
        """Each of the material axes has constants of its own."""
        return True

    @property
    def moduli(self) -> tuple[float, ...]:
        """Young's moduli E1, E2, E3 in Pa."""
        return self.young

    @property
    def words(self) -> str:
        """Its constants with their units."""
        return (
            f"E1, E2, E3 {listed(self.young, 1e9)} GPa, nu12, nu23, nu13 {listed(self.poisson)}, "
            f"G12, G23, G13 {listed(self.shear, 1e9)} GPa"
        )

    @property
    def compliance(self) -> Array:
        """Compliance matrix in 1/Pa, shape (6, 6)."""
        (E1, E2, E3), (nu12, nu23, nu13) = self.young, self.poisson
        G12, G23, G13 = self.shear
        matrix = np.diag([1 / E1, 1 / E2, 1 / E3, 1 / G23, 1 / G13, 1 / G12])
        matrix[0, 1] = matrix[1, 0] = -nu12 / E1
        matrix[1, 2] = matrix[2, 1] = -nu23 / E2
        matrix[0, 2] = matrix[2, 0] = -nu13 / E1
        return matrix

    @property
    def stiffness(self) -> Array:
        """Stiffness matrix in Pa, shape (6, 6)."""
        inverse = np.linalg.inv(self.compliance)
        return np.asarray((inverse + inverse.T) / 2)

    def _inadmissible(self) -> str:
        """Which of the conditions on the constants is not met; Jones, Eqs. 2.44 to 2.48."""
        (E1, E2, E3), (nu12, nu23, nu13) = self.young, self.poisson
        pairs = {"12": (nu12, E1, E2), "23": (nu23, E2, E3), "13": (nu13, E1, E3)}
        for name, (nu, first, second) in pairs.items():
            bound = float(np.sqrt(first / second))
            if abs(nu) >= bound:
                return (
                    f"poisson: nu{name} = {nu:g}: must be below "
                    f"sqrt(E{name[0]} / E{name[1]}) = {bound:.4g} in size, or strain energy is "
                    "negative"
                )
        return (
            f"poisson = {list(self.poisson)}: together give a negative strain energy with young = "
            f"{list(self.young)}: must keep 1 - nu12 nu21 - nu23 nu32 - nu13 nu31 - "
            "2 nu21 nu32 nu13 positive"
        )


def listed(values: Iterable[float], unit: float = 1.0) -> str:
    """Numbers over a unit with five digits, one after the other."""
    return ", ".join(f"{value / unit:.5g}" for value in values)


def rotated(stiffness: Array, axes: Array) -> Array:
    """Stiffness in global axes of a law in material axes.

    Args:
        stiffness: Stiffness in material axes, Pa, shape (6, 6).
        axes: Orthonormal material axes as rows, in global components, shape (3, 3).

    Returns:
        C_ijkl = a_pi a_qj a_rk a_sl C_pqrs, as a matrix of shape (6, 6).
    """
    number = np.empty((3, 3), dtype=np.int64)
    for index, (i, j) in enumerate(PLACES):
        number[i, j] = number[j, i] = index
    tensor = stiffness[number][:, :, number]
    turned = np.einsum("pi,qj,rk,sl,pqrs->ijkl", axes, axes, axes, axes, tensor, optimize=True)
    rows, columns = np.array(PLACES).T
    return np.asarray(turned[rows, columns][:, rows, columns])


def plane_stress(stiffness: Array) -> Array:
    """Stiffness of xx, yy, xy where no stress acts on the x-y plane, shape (3, 3)."""
    inner = stiffness[np.ix_(IN_PLANE, IN_PLANE)]
    mixed = stiffness[np.ix_(IN_PLANE, OUT_OF_PLANE)]
    outer = stiffness[np.ix_(OUT_OF_PLANE, OUT_OF_PLANE)]
    return np.asarray(inner - mixed @ np.linalg.solve(outer, mixed.T))


def plane_strain(stiffness: Array) -> Array:
    """Stiffness of xx, yy, xy where nothing moves along z, shape (3, 3).

    Raises:
        ModelError: if the x-y plane is no plane of symmetry: shear along z would arise.
    """
    shears = stiffness[np.ix_(IN_PLANE, OUT_OF_PLANE[1:])]
    if np.abs(shears).max() > 1e-9 * np.abs(stiffness).max():
        raise ModelError(
            "the orientation turns the material out of the x-y plane, so that plane strain would "
            "need shear along z: must keep one material axis along z (or choose a solid body)",
            code=Code.OUT_OF_PLANE,
        )
    return np.asarray(stiffness[np.ix_(IN_PLANE, IN_PLANE)])


def uniaxial(stiffness: Array) -> float:
    """Young's modulus along x in Pa: 1 / S_11."""
    return 1 / float(np.linalg.inv(stiffness)[0, 0])
