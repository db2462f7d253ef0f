"""Folders that libraries keep compiled code and fonts in, where the home folder cannot hold them.

dolfinx, matplotlib and fontconfig write below the home folder, and MPI to the folder for temporary
files. Where these cannot be written to, all are sent to one folder that can.
"""

from __future__ import annotations

import logging
import os
import stat
import tempfile
from contextlib import suppress
from pathlib import Path

from fenics_nnm.errors import OutputError

logger = logging.getLogger(__name__)

#: Names of the variables, and where the folders are below the home folder without them.
_FOLDERS = {"XDG_CACHE_HOME": ".cache", "XDG_CONFIG_HOME": ".config"}

#: Names of variables that name a folder of one library.
_GIVEN = ("MPLCONFIGDIR",)

#: Bytes that are written to see whether a folder can hold anything.
_TRIED = 4096


def use_writable_caches() -> None:
    """Have libraries keep what they make where it can be written; before they are imported.

    Raises:
        OutputError: if there is no such place.
    """
    temporary = _temporary_folder()
    for name in _FOLDERS:
        if not Path(os.environ.get(name, "/")).is_absolute():  # its specification has it ignored
            del os.environ[name]
    for name in _GIVEN:
        if name in os.environ and not _holds(Path(os.environ[name])):
            del os.environ[name]
    home = os.path.expanduser("~")
    places = {name: Path(os.environ.get(name) or Path(home, sub)) for name, sub in _FOLDERS.items()}
    if all(_holds(place) for place in places.values()):
        return
    spare = _own_folder(temporary)
    logger.info("%s cannot be written to: caches are in %s", home, spare)
    os.environ["HOME"] = str(spare)
    for name, below in _FOLDERS.items():
        os.environ[name] = str(spare / below)
        (spare / below).mkdir(exist_ok=True)


def _temporary_folder() -> Path:
    """The folder for temporary files, which libraries take from TMPDIR alone."""
    try:
        found = tempfile.gettempdir()
    except OSError as error:
        raise OutputError(
            f"no folder for temporary files can be written to ({error.strerror}): must have space "
            "in /tmp, or in another folder that the variable TMPDIR names"
        ) from error
    if os.environ.get("TMPDIR"):
        os.environ["TMPDIR"] = found
    return Path(found)


def _holds(folder: Path) -> bool:
    """Whether a folder can be made, and a file in it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(_TRIED))
    except (OSError, ValueError):
        return False
    return True


def _own_folder(temporary: Path) -> Path:
    """A folder of this user for all commands, or a new one where somebody else has made that."""
    folder = temporary / f"fenics-nnm-{os.getuid()}"
    with suppress(OSError):
        folder.mkdir(mode=0o700)
    with suppress(OSError):
        found = folder.lstat()
        private = stat.S_ISDIR(found.st_mode) and not found.st_mode & 0o077
        if private and found.st_uid == os.getuid() and _holds(folder):
            return folder
    try:
        return Path(tempfile.mkdtemp(prefix="fenics-nnm-"))
    except OSError as error:
        raise OutputError(f"{temporary}: cannot be written: {error.strerror}") from error
