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


class OutOfMemoryError(ConvergenceError):
    """A factorisation needs more memory than it may take."""


class TooManyModesError(ModelError):
    """A reduction whose modes leave nothing to its contact points."""


def one_line(error: BaseException) -> str:
    """What is said of an error, of whatever kind, in one line with its notes."""
    message = "; ".join([_message(error), *getattr(error, "__notes__", ())])
    return " ".join(message.split())


def _message(error: BaseException) -> str:
    if isinstance(error, NonlinearModeError):
        return str(error)
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, MemoryError):
        return "out of memory: use a coarser mesh or fewer reduction.modes"
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    if isinstance(error, ArithmeticError):
        return (
            f"a number becomes too large or too small to compute with ({error}): check lengths, "
            "units and material (--verbose shows where)"
        )
    return (
        f"this is a defect of fenics-nnm, please report it: {type(error).__name__}: {error} "
        "(--verbose shows where)"
    )
