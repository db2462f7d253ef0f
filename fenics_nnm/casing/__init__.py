"""Rigid surfaces around a body: distances to them along given directions, in NumPy alone."""

from fenics_nnm.casing.cone import Cone
from fenics_nnm.casing.frame import Frame
from fenics_nnm.casing.passing import Passing, Turning
from fenics_nnm.casing.plane import Plane
from fenics_nnm.casing.radius import LobedRadius, RadialSurface, Radius
from fenics_nnm.casing.surface import Reversed, RoundSurface, Surface
from fenics_nnm.casing.table import RadiusTable, read_radii

__all__ = [
    "Cone",
    "Frame",
    "LobedRadius",
    "Passing",
    "Plane",
    "RadialSurface",
    "Radius",
    "RadiusTable",
    "Reversed",
    "RoundSurface",
    "Surface",
    "Turning",
    "read_radii",
]
