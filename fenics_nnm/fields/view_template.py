"""The motion at @WORDS@, for ParaView.

paraview --state=view.py               opens it: press play
pvbatch view.py picture.png 0.25       draws a picture of a part of the period

The deformation is drawn SCALE times as large as it is. The contact surface is loaded too and
hidden: switch on its eye to see pressure and gap.
"""

from __future__ import annotations

import os
import sys
from typing import Any

import numpy as np
from paraview import servermanager, simple
from vtkmodules.numpy_interface import dataset_adapter as dsa

MOTION = "@MOTION@"
CONTACT = "@CONTACT@"
COLOUR = "@COLOUR@"
SCALE: Any = "@SCALE@"
PLANE = "@PLANE@"
FROM: Any = "@FROM@"
UP: Any = "@UP@"
HIGHEST = 0.995
LINE_WIDTH = 6 if PLANE == "line" else 1


def folder() -> str:
    """Folder of this file, beside which the motions are."""
    if "__file__" in globals():
        return os.path.dirname(os.path.abspath(__file__))
    named = [argument.split("=", 1)[-1] for argument in sys.argv if argument.endswith("view.py")]
    return os.path.dirname(os.path.abspath(named[0])) if named else os.getcwd()


def deformed(file: str, name: str) -> Any:
    """A motion with its displacement SCALE times as large."""
    read = simple.VTKHDFReader if file.endswith(".vtkhdf") else simple.PVDReader
    source = read(registrationName=name, FileName=os.path.join(folder(), file))
    warped = simple.WarpByVector(registrationName=f"{name}, deformed x {SCALE:g}", Input=source)
    warped.Vectors = ["POINTS", "displacement (m)"]
    warped.ScaleFactor = SCALE
    return warped


def coloured(warped: Any, view: Any, array: str, *, bar: bool) -> None:
    """Colour by an array from 0 to the largest 99.5 % quantile of an instant; the bar has its unit.

    The few larger values, such as stresses at corners, have the last colour.
    """
    display = simple.Show(warped, view)
    display.LineWidth = LINE_WIDTH
    if "displacement" in array:
        simple.ColorBy(display, ("POINTS", array, "Magnitude"))
    else:
        simple.ColorBy(display, ("POINTS", array))
    display.RescaleTransferFunctionToDataRangeOverTime()
    colours = simple.GetColorTransferFunction(array)
    colours.RescaleTransferFunction(0.0, quantile(warped, array) or colours.RGBPoints[-4])
    legend = simple.GetScalarBar(colours, view)
    legend.Title, legend.ComponentTitle = array, ""
    legend.TitleColor = legend.LabelColor = [0.0, 0.0, 0.0]
    legend.WindowLocation, legend.ScalarBarLength = "Lower Center", 0.5
    legend.Orientation, legend.RangeLabelFormat = "Horizontal", "%.3g"
    display.SetScalarBarVisibility(view, bar)


def quantile(source: Any, array: str) -> float:
    """Value of an array that a part of 0.995 of the nodes stay below at all times of the period."""
    highest = 0.0
    for time in simple.GetAnimationScene().TimeKeeper.TimestepValues:
        source.UpdatePipeline(time)
        data = dsa.WrapDataObject(servermanager.Fetch(source))
        values = np.asarray(data.PointData[array])
        sizes = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
        highest = max(highest, float(np.quantile(sizes, HIGHEST)))
    return highest


def look(view: Any) -> None:
    """Camera in front of a plane body, and across the plane of another one."""
    simple.ResetCamera(view)
    camera = simple.GetActiveCamera()
    if PLANE == "solid":
        middle = camera.GetFocalPoint()
        camera.SetPosition([a + b for a, b in zip(middle, FROM)])
        camera.SetViewUp(UP)
        simple.ResetCamera(view)
    camera.Dolly(1.0 if PLANE == "solid" else 1.2)


def main() -> None:
    """Open the files and show them."""
    drawing = len(sys.argv) > 1
    simple._DisableFirstRenderCameraReset()
    view = simple.GetActiveViewOrCreate("RenderView")
    if drawing:
        view.ViewSize = [1200, 800]
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    view.OrientationAxesLabelColor = [0.0, 0.0, 0.0]
    warped = deformed(MOTION, os.path.splitext(MOTION)[0])
    if CONTACT:
        touched = deformed(CONTACT, os.path.splitext(CONTACT)[0])
        coloured(touched, view, "contact pressure (Pa)", bar=False)
        simple.Hide(touched, view)
    scene = simple.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    coloured(warped, view, COLOUR, bar=True)
    scene.AnimationTime = float(sys.argv[2]) if len(sys.argv) > 2 else 0.0
    phase = simple.AnnotateTime(registrationName="phase")
    phase.Format = "phase {time:.3f} of the period"
    text = simple.Show(phase, view)
    text.Color = [0.0, 0.0, 0.0]
    simple.SetActiveSource(warped)
    look(view)
    simple.Render(view)
    if drawing:
        simple.SaveScreenshot(sys.argv[1], view)


main()
