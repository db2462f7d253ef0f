"""Ctrl-C and its like: steps that they must not cut in two."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

Handler = Callable[[int, FrameType | None], None]


@contextmanager
def terminable() -> Iterator[None]:
    """Take SIGTERM, which mpirun and batch systems send, for a Ctrl-C.

    PETSc has a handler of its own, so this comes after the import of petsc4py.
    """
    with _handled((signal.SIGTERM,), signal.default_int_handler):
        yield


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Hold back KeyboardInterrupt until the context ends."""
    received = False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal received
        received = True

    with _handled((signal.SIGINT, signal.SIGTERM), note):
        yield
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
