"""Ctrl-C and its like: steps that they must not cut in two."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

Handler = Callable[[int, FrameType | None], None]


def ending_at_once() -> None:
    """Let Ctrl-C end the process in silence, where nothing is begun or all is done.

    Where it is ignored, as behind nohup, it stays so.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def raised() -> None:
    """Have Ctrl-C raise KeyboardInterrupt again, so that work ends in order."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_DFL:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@contextmanager
def terminable() -> Iterator[None]:
    """Take SIGTERM, which mpirun and batch systems send, for a Ctrl-C.

    PETSc has a handler of its own, so this comes after the import of petsc4py.
    """
    with _handled((signal.SIGTERM,), signal.default_int_handler):
        yield


@contextmanager
def uninterrupted() -> Iterator[Callable[[], bool]]:
    """Hold back KeyboardInterrupt until the context ends.

    Yields:
        Whether one is held back.
    """
    received = False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal received
        received = True

    with _handled((signal.SIGINT, signal.SIGTERM), note):
        yield lambda: received
    if received:
        raise KeyboardInterrupt


@contextmanager
def _handled(numbers: tuple[signal.Signals, ...], handler: Handler) -> Iterator[None]:
    """Another handler of some signals; only the main thread can have one."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    previous = {number: signal.signal(number, handler) for number in numbers}
    try:
        yield
    finally:
        for number, older in previous.items():
            signal.signal(number, older or signal.SIG_DFL)
