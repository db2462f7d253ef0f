"""Errors that a user can cause; the command line shows each as one line."""


class NonlinearModeError(Exception):
    """Base of every error raised on purpose by this package."""


class StudyError(ValueError, NonlinearModeError):
    """The study file, or a file that it names, is wrong."""


class GeometryError(ValueError, NonlinearModeError):
    """A built-in geometry cannot be made from its parameters or tables."""


class MeshError(ValueError, NonlinearModeError):
    """A mesh lacks what the study needs: groups, cell types, valid elements."""


class ModelError(ValueError, NonlinearModeError):
    """Mechanical model or reduced model is not admissible: no clamp, no contact, R not SPD."""


class OutputError(OSError, NonlinearModeError):
    """Results cannot be written to, or read from, the requested place."""


class ConvergenceError(RuntimeError, NonlinearModeError):
    """A computation ended before it gave what was asked for; exit code 1."""


class TooManyModesError(ModelError):
    """A reduction whose modes leave nothing to its contact points."""
