"""motions.jsonl: nonlinear motions of the speeds that are done, for a later run to take over."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from fenics_nnm import __version__
from fenics_nnm.errors import OutputError
from fenics_nnm.structure.motions_at_speed import MotionAtSpeed, Quantity, Target
from fenics_nnm.study import Study
from fenics_nnm.study.inputs import input_digests
from fenics_nnm.study.resolution import Resolution

#: Name of the file in the folder of a Campbell diagram.
NAME = "motions.jsonl"

#: How the mode of motions is found: those found in another way are not taken over.
_NAMED = "held modes by shape"


@dataclass(frozen=True, slots=True)
class Done:
    """A speed that is done.

    Attributes:
        motions: Its motions.
        resolution: Numbers that they were found with.
    """

    motions: tuple[MotionAtSpeed, ...]
    resolution: Resolution


@dataclass(frozen=True, slots=True)
class CampbellJournal:
    """The file, on the first rank.

    Attributes:
        path: Its path.
        known: Speeds that are done, by what `key_of` says of them.
    """

    path: Path
    known: dict[str, Done] = field(default_factory=dict)

    @classmethod
    def begun(cls, folder: Path, *, resume: bool) -> CampbellJournal:
        """Begin anew, or with what is in a folder; a line that was cut off is left out.

        Speeds that a folder has stay in the file in any case: a command that begins anew and is
        stopped, or that cannot begin, takes nothing from a later one.

        Raises:
            OutputError: if the folder cannot be written to.
        """
        path = folder / NAME
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if resume and path.exists():
                return cls(path, dict(_read(path)))
            path.touch()
        except OSError as error:
            raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from error
        return cls(path)

    def add(self, key: str, done: Done) -> None:
        """Keep a speed.

        Raises:
            OutputError: if it cannot be written.
        """
        line = json.dumps({"key": key, **asdict(done)}, default=lambda kind: kind.value)
        try:
            with self.path.open("a") as file:
                file.write(f"\n{line}\n")  # apart from a line that was cut off
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            reason = error.strerror or error
            raise OutputError(f"{self.path}: cannot be written: {reason}") from error


def key_of(study: Study, targets: Sequence[Target], resolution: Resolution | None) -> str:
    """Digest of all that motions depend on.

    Args:
        study: Study at its speed, with the number of the mode there.
        targets: Motions that are asked for.
        resolution: Numbers for "auto", if some were found before.
    """
    parts = (
        __version__,
        _NAMED,
        study.model_dump_json(),
        input_digests(study),
        targets,
        resolution,
    )
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def _read(path: Path) -> Iterator[tuple[str, Done]]:
    for line in path.read_text().splitlines():
        with suppress(ValueError, KeyError, TypeError):
            values = json.loads(line)
            motions = tuple(_motion(each) for each in values["motions"])
            yield values["key"], Done(motions, Resolution(**values["resolution"]))


def _motion(values: dict[str, Any]) -> MotionAtSpeed:
    target = values["target"]
    kept = Target(Quantity(target["quantity"]), target["value"])
    return MotionAtSpeed(**{**values, "target": kept})
