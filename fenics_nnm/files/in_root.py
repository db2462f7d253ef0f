"""Being elsewhere while a library reads its settings."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def in_root() -> Iterator[None]:
    """Be in the folder / for a while, so that a library reads no settings where the study lies."""
    here = os.open(".", os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.chdir("/")
        yield
    finally:
        os.fchdir(here)
        os.close(here)
