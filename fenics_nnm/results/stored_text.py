"""The study file that results keep as text."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import lru_cache
from typing import Any


@lru_cache(maxsize=32)
def values_of(text: str) -> Mapping[str, Any]:
    """Values of a stored study file; each text is parsed once.

    Raises:
        tomllib.TOMLDecodeError: if it is no TOML of this version.
    """
    return tomllib.loads(text)
