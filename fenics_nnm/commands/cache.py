"""fenics-nnm cache: where meshes, static states and modes are kept, and how to be rid of them."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from fenics_nnm.commands.shared import DONE, Commands, add_verbose, console_of, show
from fenics_nnm.errors import OutputError
from fenics_nnm.files.sizes import size_words

if TYPE_CHECKING:
    from fenics_nnm.files.cache import Cache


def add_to(commands: Commands) -> None:
    """Add the command."""
    cache = commands.add_parser("cache", help="show, or empty, the folder of kept meshes and modes")
    cache.add_argument("--clear", action="store_true", help="remove all that is kept")
    add_verbose(cache)
    cache.set_defaults(action=_cache)


def _cache(arguments: argparse.Namespace) -> int:
    from mpi4py import MPI

    from fenics_nnm.fem.parallel import on_root
    from fenics_nnm.files.cache import OFF, VARIABLE, cache_of_user

    cache = cache_of_user()
    words = f"the cache is off: {VARIABLE} is {OFF}"
    if cache is not None:
        words = on_root(MPI.COMM_WORLD, _cleared if arguments.clear else _held, cache)
    show(console_of(MPI.COMM_WORLD), words)
    return DONE


def _held(cache: Cache) -> str:
    return (
        f"{cache.folder}: {len(cache.files())} files, {size_words(cache.size())} of "
        f"{size_words(cache.most)} at most"
    )


def _cleared(cache: Cache) -> str:
    try:
        return f"{cache.folder}: {cache.clear()} files removed"
    except OSError as error:
        raise OutputError(f"{cache.folder}: cannot be emptied: {error.strerror}") from error
