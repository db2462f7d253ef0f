"""Section of the study file about the reduction to a few coordinates, one record a method."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field, Tag

from fenics_nnm.study.record import Auto, Count, Record
from fenics_nnm.study.tagged import by_key

Law = Literal["complementarity", "augmented-lagrangian"]

_METHODS = '"massless" (free modes, residual flexibility), "craig-bampton", or "none"'
_OF_MATRICES = (
    "full order factorises the matrices of a mesh at every harmonic: with [matrices] must be "
    '"massless" or "craig-bampton"'
)
_MODES = 'a positive integer, the number of free, fixed-interface or explicit modes, or "auto"'


class AnyReduction(Record):
    """What is asked of every reduction.

    Attributes:
        laws: Contact laws that it goes with, the default first.
        full_order: Whether the whole model is used at every harmonic.
        needs_factors: Whether it needs factors of the stiffness.
        method: Name of the reduction.
        modes: Number of modes, or "auto".
    """

    laws: ClassVar[tuple[Law, ...]] = ("complementarity",)
    full_order: ClassVar[bool] = False
    needs_factors: ClassVar[bool] = True

    method: str
    modes: Count | Auto

    @property
    def all_directions(self) -> bool:
        """Whether contact points keep their motion along all axes."""
        return False


class MasslessSection(AnyReduction):
    """Free modes and residual flexibility: contact points carry no mass."""

    needs_factors: ClassVar[bool] = False

    method: Literal["massless"] = Field("massless", description=_METHODS)
    modes: Count | Auto = Field(40, description=_MODES)


class CraigBamptonSection(AnyReduction):
    """Fixed-interface modes and static shapes: contact points carry mass."""

    laws: ClassVar[tuple[Law, ...]] = ("augmented-lagrangian",)

    method: Literal["craig-bampton"] = Field("craig-bampton", description=_METHODS)
    modes: Count | Auto = Field(40, description=_MODES)
    interface: Literal["all", "contact"] = Field(
        "all", description='retained directions of craig-bampton: "all" (default) or "contact"'
    )

    @property
    def all_directions(self) -> bool:
        """Whether contact points keep their motion along all axes."""
        return self.interface == "all"


class FullOrderSection(AnyReduction):
    """No reduction: the whole model at every harmonic."""

    laws: ClassVar[tuple[Law, ...]] = ("complementarity", "augmented-lagrangian")
    full_order: ClassVar[bool] = True

    method: Literal["none"] = Field("none", description=_METHODS)
    modes: Count = Field(
        40,
        description="at full order no mode is left out: a positive integer, the number of modes "
        "that stay explicit",
    )


class MatrixCraigBamptonSection(AnyReduction):
    """Craig-Bampton of matrices, which have the contact directions alone."""

    laws: ClassVar[tuple[Law, ...]] = ("augmented-lagrangian",)

    method: Literal["craig-bampton"] = Field("craig-bampton", description=_OF_MATRICES)
    modes: Count | Auto = Field(40, description=_MODES)
    interface: Literal["contact"] = Field(
        "contact",
        description="all directions are those of a mesh: [matrices] have the contact directions "
        'alone, "contact"',
    )


class MatrixMasslessSection(MasslessSection):
    """The massless reduction of matrices."""

    method: Literal["massless"] = Field("massless", description=_OF_MATRICES)


ReductionSection = Annotated[
    Annotated[MasslessSection, Tag('method = "massless"')]
    | Annotated[CraigBamptonSection, Tag('method = "craig-bampton"')]
    | Annotated[FullOrderSection, Tag('method = "none"')],
    by_key("method", "massless"),
]
"""Reduction of a mesh."""

MatrixReductionSection = Annotated[
    Annotated[MatrixMasslessSection, Tag('method = "massless"')]
    | Annotated[MatrixCraigBamptonSection, Tag('method = "craig-bampton"')],
    by_key("method", "massless"),
]
"""Reduction of matrices of another code."""
