"""Pictures that are kept: what `report` has drawn, `plot` takes, and the other way round.

A picture depends on branch.h5 and summary.json, on the program and on its libraries, and on the
format of its file.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from fenics_nnm.fem.surroundings import surroundings
from fenics_nnm.files.cache import cache_of_user, key_of
from fenics_nnm.output.picture import Picture
from fenics_nnm.results.durable import write_whole

#: Files of a results folder that pictures are drawn of.
_OF = ("branch.h5", "summary.json")

#: Name of the list of pictures among their files.
_LIST = "pictures"

Pictures = tuple[Picture, ...]


def kept_pictures(
    results: Path, folder: Path, kind: str, draw: Callable[[], Pictures], *, count: int = 0
) -> Pictures:
    """Pictures in a folder, drawn and kept if they were not before.

    Args:
        results: Results folder that they are of.
        folder: Folder of the pictures.
        kind: Which pictures, and in which format.
        draw: Draws them into the folder.
        count: Fewest that are kept: with less something could not be drawn.

    Raises:
        OSError: if they cannot be written.
    """
    cache = cache_of_user()
    if cache is None:
        return draw()
    key = key_of("pictures", kind, surroundings(), *(_digest(results / name) for name in _OF))
    found = cache.read(key)
    if found is not None:
        listed = json.loads(found.pop(_LIST).tobytes())
        for name, data in found.items():
            write_whole(folder / name, data.tobytes())
        return tuple(Picture(**{**each, "also": tuple(each["also"])}) for each in listed)
    drawn = draw()
    if len(drawn) >= count:
        files = [name for each in drawn for name in (each.file, *each.also)]
        contents = {name: _array((folder / name).read_bytes()) for name in files}
        listed = json.dumps([asdict(each) for each in drawn]).encode()
        cache.write(key, {**contents, _LIST: _array(listed)})
    return drawn


def in_formats(parts: Sequence[Pictures]) -> Pictures:
    """The same pictures in several formats as one list, the first format that of `Picture.file`."""
    return tuple(
        replace(first, also=tuple(other.file for other in others))
        for first, *others in zip(*parts, strict=True)
    )


def _array(data: bytes) -> np.ndarray:
    return np.frombuffer(data, dtype=np.uint8)


def _digest(path: Path) -> str:
    """Digest of a file; empty if there is none."""
    if not path.is_file():
        return ""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
