"""Open each kind of ParaView file of a run and draw it; run by pvbatch.

environment/run --viewers pvbatch tests/paraview/open_files.py results/paraview/fields
"""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from typing import Any

from paraview import simple
from paraview.vtk.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

#: Arrays that each file must have; one of them is drawn.
ARRAYS = {
    "linear_modes.vtu": ("mode 1 (",),
    "mode_shapes.vtu": ("gamma 1.2 closed: displacement (m)", "gamma 1.2 open: displacement (m)"),
    "motion_1.2.pvd": ("von Mises stress (Pa)", "displacement (m)", "velocity (m/s)"),
    "motion_1.2_contact.pvd": ("contact pressure (Pa)", "gap (m)"),
    "peak_stress_1.2.vtu": ("peak von Mises stress (Pa)",),
}

#: Spread of the grey values that an empty picture does not have.
LEAST_SPREAD = 5.0


def main() -> None:
    """Draw all files of a folder, then view.py, and look for something in the pictures."""
    folder = Path(sys.argv[1]).resolve()
    pictures = folder.parent / "pictures_of_paraview"
    pictures.mkdir(exist_ok=True)
    for name, wanted in ARRAYS.items():
        picture = pictures / f"{name}.png"
        draw(folder / name, wanted, picture)
        told(name, picture)
    sys.argv = ["view.py", str(pictures / "view.png"), "0.0"]
    runpy.run_path(str(folder / "view.py"))
    told("view.py", pictures / "view.png")


def draw(file: Path, wanted: tuple[str, ...], picture: Path) -> None:
    """Draw the first array that is wanted."""
    open_file: Any = simple.PVDReader if file.suffix == ".pvd" else None
    reader = (
        open_file(FileName=str(file))
        if open_file
        else simple.XMLUnstructuredGridReader(FileName=[str(file)])
    )
    view = simple.CreateView("RenderView")
    view.ViewSize, view.OrientationAxesVisibility = [800, 600], 0
    reader.UpdatePipeline()
    names = list(reader.PointData.keys())
    for start in wanted:
        assert any(name.startswith(start) for name in names), (file.name, start, names)
    array = next(name for name in names if name.startswith(wanted[0]))
    display = simple.Show(reader, view)
    simple.ColorBy(display, ("POINTS", array))
    display.RescaleTransferFunctionToDataRange()
    if file.suffix == ".pvd":
        times = list(reader.TimestepValues)
        assert len(times) >= 24 and times[0] == 0.0 and 0.9 < times[-1] < 1.0, times
    simple.ResetCamera(view)
    simple.GetActiveCamera().Azimuth(40)
    simple.GetActiveCamera().Elevation(25)
    simple.ResetCamera(view)
    simple.SaveScreenshot(str(picture), view)
    simple.Delete(view)


def told(name: str, picture: Path) -> None:
    """Say how much there is in a picture.

    Raises:
        AssertionError: if it is empty.
    """
    reader = vtkPNGReader()
    reader.SetFileName(str(picture))
    reader.Update()
    pixels = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())
    spread = float(pixels.mean(axis=1).std())
    sys.stdout.write(f"{name}: {len(pixels)} pixels, spread {spread:.1f}\n")
    assert spread > LEAST_SPREAD, f"{name}: the picture is empty"


main()
