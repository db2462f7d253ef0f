"""Built-in geometries: each a frozen record that fills the current gmsh model."""

from typing import Annotated

from pydantic import Field

from fenics_nnm.geometry.beam import Beam
from fenics_nnm.geometry.blade import Blade
from fenics_nnm.geometry.fork import Fork
from fenics_nnm.geometry.plate import Plate
from fenics_nnm.geometry.rod import Rod
from fenics_nnm.geometry.shroud import Shroud

Geometry = Annotated[Rod | Beam | Plate | Fork | Shroud | Blade, Field(discriminator="model")]
"""Any built-in geometry, chosen by its key `model`."""

__all__ = ["Beam", "Blade", "Fork", "Geometry", "Plate", "Rod", "Shroud"]
