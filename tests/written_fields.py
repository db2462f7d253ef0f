"""Reads the ParaView files of a run as VTK does."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pyvista
from vtkmodules.vtkIOHDF import vtkHDFReader

Arrays = dict[str, np.ndarray]


def read_grid(path: Path) -> pyvista.UnstructuredGrid:
    """The grid of a .vtu file."""
    grid: Any = pyvista.read(path)
    return grid


def arrays_of(path: Path) -> Arrays:
    """Arrays at the nodes of a .vtu file, and their places as "Points"."""
    grid = read_grid(path)
    return {"Points": np.array(grid.points), **{n: np.array(v) for n, v in grid.point_data.items()}}


def frames(listing: Path) -> list[tuple[float, Arrays]]:
    """Time and arrays of each frame that a .pvd file lists."""
    items = ElementTree.parse(listing).getroot().iter("DataSet")
    return [
        (float(i.attrib["timestep"]), arrays_of(listing.parent / i.attrib["file"])) for i in items
    ]


def hdf_frames(path: Path) -> list[tuple[float, Arrays]]:
    """Time and arrays of each step of a .vtkhdf file."""
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    found = []
    for step in range(reader.GetNumberOfSteps()):
        reader.SetStep(step)
        reader.Update()
        grid: Any = pyvista.wrap(reader.GetOutput())
        arrays = {name: np.array(values) for name, values in grid.point_data.items()}
        found.append(
            (step / reader.GetNumberOfSteps(), {"Points": np.array(grid.points), **arrays})
        )
    return found
