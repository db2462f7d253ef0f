"""dolfinx's compiler of forms, made safe against files of others and against being killed.

dolfinx and FFCx read options from the current folder, among them the folder that compiled code is
loaded from: it may be somebody else's. And a compilation that was cut short leaves a file behind
for which all later ones wait, in vain.
"""

from __future__ import annotations

import functools
import re
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import ffcx
from dolfinx import jit

from fenics_nnm.files.in_root import in_root
from fenics_nnm.interrupts import uninterrupted

#: Seconds after which a compilation that has not come to its end is taken for dead.
_DEAD = 120.0

#: Options of gcc and clang that let sums be done in any order, so that their terms are computed
#: several at once.
_ANY_ORDER = ("-fno-trapping-math", "-fno-signed-zeros", "-fassociative-math")


def quick() -> dict[str, Any]:
    """Options of dolfinx for long forms, whose values may then differ in their last digit.

    Options of the compiler that the user gives win.
    """
    own = jit.get_options()["cffi_extra_compile_args"]
    return {"cffi_extra_compile_args": [*_ANY_ORDER, *own]}


def make_safe() -> None:
    """Read the options once, without those of the current folder, and mend what was cut short."""
    with in_root():
        folder = Path(jit.get_options()["cache_dir"])
        ffcx.get_options()
    for source in folder.glob("libffcx_*.c"):
        if not _ready(source) and time.time() - _changed(source) > _DEAD:
            source.unlink(missing_ok=True)
    jit.ffcx_jit = whole(jit.ffcx_jit)


def whole(compile_: Callable[..., Any]) -> Callable[..., Any]:
    """A compiler that is not cut short by Ctrl-C, and tries again where one was."""

    @functools.wraps(compile_)
    def compiled(*given: Any, **named: Any) -> Any:
        with uninterrupted() as interrupted:
            try:
                return compile_(*given, **named)
            except Exception as error:
                if interrupted():  # as the C compiler is, too, in a terminal
                    raise KeyboardInterrupt from error
                if not _removed(error):
                    raise
            return compile_(*given, **named)

    return compiled


def _removed(error: Exception) -> bool:
    """Whether a file was found, and removed, for which the compiler has waited in vain."""
    named = re.search(r"remove (\S+\.c)\)", str(error))
    if not named or _ready(Path(named[1])):
        return False
    with suppress(OSError):
        Path(named[1]).unlink()
        return True
    return False


def _ready(source: Path) -> bool:
    return source.with_suffix(".c.cached").exists()


def _changed(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return time.time()
