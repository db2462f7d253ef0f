"""Errors that a user can cause; the command line shows each as one line."""

from __future__ import annotations

from enum import StrEnum


class Code(StrEnum):
    """What an error is about, where a key of the study can mend it.

    Rooms that know no study file speak in their own words; `study.error_keys` has the keys.
    """

    CELLS_OF_MATERIALS = "cells of materials"
    CONSTRAINED = "constrained"
    CURVED_ELEMENTS = "curved elements"
    CYLINDRICAL_AXES = "cylindrical axes"
    DEGREE = "degree"
    DEGREE_WITHOUT_MEMORY = "degree without memory"
    ELEMENT_SIZE = "element size"
    EXPANSION = "thermal expansion"
    WARMING = "warming"
    FULL_ORDER_GAP = "gap at full order"
    GAP = "gap"
    GAP_WITH_FORCES = "gap with forces"
    GAP_WITH_KINEMATICS = "gap with second-order kinematics"
    GAP_WITH_MASS = "gap of points with mass"
    KINEMATICS_AT_FULL_ORDER = "second-order kinematics at full order"
    LENGTH_UNIT = "length unit"
    MASS_AT_CONTACT = "mass at contact points"
    MEMORY = "memory"
    MEMORY_OF_FACTORS = "memory of factors"
    MEMORY_LIMIT = "memory limit"
    MESHING = "meshing"
    MESH_FILE = "mesh file"
    MODE = "mode"
    MODES = "modes"
    HELD_MODES = "modes with held points"
    MODES_OF_ITERATION = "modes of an iteration"
    NOT_HELD = "not held"
    OUT_OF_PLANE = "out of plane"
    REFINED_SIZE = "refined size"
    REFERENCE = "reference displacement"
    STEADY_LOADS = "steady loads"
    STILL_MODE = "still mode"
    THEORY = "theory"
    TIME_LIMIT = "time limit"
    TOO_MANY_MODES = "too many modes"


class NonlinearModeError(Exception):
    """Base of every error raised on purpose by this package.

    Attributes:
        code: What it is about, if a key of the study can mend it.
    """

    def __init__(self, *arguments: object, code: Code | None = None) -> None:
        """An error with a message and, if a key of the study can mend it, its code."""
        super().__init__(*arguments)
        self.code = code


class StudyError(NonlinearModeError, ValueError):
    """The study file, or a file that it names, is wrong."""


class GeometryError(NonlinearModeError, ValueError):
    """A built-in geometry cannot be made from its parameters or tables."""


class MeshError(NonlinearModeError, ValueError):
    """A mesh lacks what the study needs: groups, cell types, valid elements."""


class ModelError(NonlinearModeError, ValueError):
    """Mechanical model or reduced model is not admissible: no clamp, no contact, R not SPD."""


class OutputError(NonlinearModeError):
    """Results cannot be written to, or read from, the requested place.

    It is no `OSError`, so that code that turns those of the operating system into a line lets it
    pass.
    """


class NoBodyError(OutputError):
    """Pictures or fields are asked of results of matrices, which have no mesh: bad input."""


class ConvergenceError(NonlinearModeError, RuntimeError):
    """A computation ended before it gave what was asked for; exit code 1."""


class OutOfMemoryError(ConvergenceError):
    """A factorisation needs more memory than it may take."""


class MissedModesError(ConvergenceError):
    """Modes that a count by other means finds and an eigensolver did not."""


class TooManyModesError(ModelError):
    """A reduction whose modes leave nothing to its contact points."""
