"""A picture that lies in a folder."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture in a folder.

    Attributes:
        file: Name of its file.
        title: A few words.
        caption: What is seen, in sentences, with units.
        group: "frequency", "contact", "motion", "accuracy", "body" or "linear".
        also: Names of the files with the same picture in other formats.
    """

    file: str
    title: str
    caption: str
    group: str
    also: tuple[str, ...] = ()
