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

from paraview import simple

MOTION = "@MOTION@"
CONTACT = "@CONTACT@"
COLOUR = "@COLOUR@"
SCALE: Any = "@SCALE@"
PLANE = "@PLANE@"
LINE_WIDTH = 6 if PLANE == "line" else 1


def folder() -> str:
    """Folder of this file, beside which the motions are."""
    if "__file__" in globals():
        return os.path.dirname(os.path.abspath(__file__))
    named = [argument.split("=", 1)[-1] for argument in sys.argv if argument.endswith("view.py")]
    return os.path.dirname(os.path.abspath(named[0])) if named else os.getcwd()


def deformed(file: str, name: str) -> Any:
    """A motion with its displacement SCALE times as large."""
    source = simple.PVDReader(registrationName=name, FileName=os.path.join(folder(), file))
    warped = simple.WarpByVector(registrationName=f"{name}, deformed x {SCALE:g}", Input=source)
    warped.Vectors = ["POINTS", "displacement (m)"]
    warped.ScaleFactor = SCALE
    return warped


def coloured(warped: Any, view: Any, array: str, *, bar: bool) -> None:
    """Colour by an array from 0 to its largest value in the period; the bar names its unit."""
    display = simple.Show(warped, view)
    display.LineWidth = LINE_WIDTH
    if "displacement" in array:
        simple.ColorBy(display, ("POINTS", array, "Magnitude"))
    else:
        simple.ColorBy(display, ("POINTS", array))
    display.RescaleTransferFunctionToDataRangeOverTime()
    colours = simple.GetColorTransferFunction(array)
    colours.RescaleTransferFunction(0.0, colours.RGBPoints[-4])
    legend = simple.GetScalarBar(colours, view)
    legend.Title, legend.ComponentTitle = array, ""
    legend.TitleColor = legend.LabelColor = [0.0, 0.0, 0.0]
    legend.WindowLocation, legend.ScalarBarLength = "Lower Center", 0.5
    legend.Orientation, legend.RangeLabelFormat = "Horizontal", "%.3g"
    display.SetScalarBarVisibility(view, bar)


def look(view: Any) -> None:
    """Camera in front of a plane body, above a corner of another one."""
    simple.ResetCamera(view)
    camera = simple.GetActiveCamera()
    if PLANE == "solid":
        camera.Azimuth(30)
        camera.Elevation(25)
        simple.ResetCamera(view)
    camera.Dolly(1.2)


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
    warped = deformed(MOTION, MOTION[:-4])
    if CONTACT:
        touched = deformed(CONTACT, CONTACT[:-4])
        coloured(touched, view, "contact pressure (Pa)", bar=False)
        simple.Hide(touched, view)
    scene = simple.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    scene.AnimationTime = float(sys.argv[2]) if len(sys.argv) > 2 else 0.0
    coloured(warped, view, COLOUR, bar=True)
    phase = simple.AnnotateTimeFilter(registrationName="phase", Input=warped)
    phase.Format = "phase {time:.3f} of the period"
    text = simple.Show(phase, view)
    text.Color = [0.0, 0.0, 0.0]
    simple.SetActiveSource(warped)
    look(view)
    simple.Render(view)
    if drawing:
        simple.SaveScreenshot(sys.argv[1], view)


main()
