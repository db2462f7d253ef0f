"""Nonlinear modes of elastic structures in unilateral contact.

`import fenics_nnm as nnm` offers the names of `__all__`; docs/python.md describes them. What is
behind a name is imported when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

#: Module of each name of the face.
_FACE = {
    "read_study": "face.study",
    "make_study": "face.study",
    "new_study": "face.study",
    "load_branch": "face.branch",
    "load_response": "face.response",
    "load_campbell": "face.diagrams",
    "load_sweep": "face.diagrams",
    "Study": "face.study",
    "Check": "face.check",
    "Branch": "face.branch",
    "Point": "face.point",
    "Response": "face.response",
    "ResponseCurve": "face.response_curve",
    "Campbell": "face.diagrams",
    "Sweep": "face.diagrams",
    "Simulation": "face.simulation",
    "ContactHistory": "face.histories",
    "MotionHistory": "face.histories",
    "UnknownsHistory": "face.histories",
    "NonlinearModeError": "errors",
    "StudyError": "errors",
    "GeometryError": "errors",
    "MeshError": "errors",
    "ModelError": "errors",
    "OutputError": "errors",
    "ConvergenceError": "errors",
}

__all__ = ["__version__", *_FACE]


def __getattr__(name: str) -> Any:
    """A name of the face, imported now."""
    if name not in _FACE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(f"{__name__}.{_FACE[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Names of the face."""
    return sorted(__all__)
