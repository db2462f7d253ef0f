"""Imports of many modules without Python's search for cycles in between."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def importing() -> Iterator[None]:
    """Import modules inside: cycles are not searched for, and what is there is never searched.

    Modules make many objects that stay. To go through them again and again takes a sixth of the
    time of their imports.
    """
    searched = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        if searched:
            gc.enable()
