"""Fields of a motion that can be asked for, and the fewest frames that show it."""

from __future__ import annotations

from typing import Literal, get_args

#: Fewer frames of a period would not show a motion.
LEAST_FRAMES = 24

#: More frames than this are a misprint, and fill the disk.
MOST_FRAMES = 10_000

FieldName = Literal[
    "displacement",
    "total_displacement",
    "velocity",
    "von_mises",
    "principal_stress",
    "stress",
    "contact_pressure",
    "gap",
    "peak_stress",
]
"""A field of a motion; `peak_stress` is a file of its own."""

FIELDS: tuple[FieldName, ...] = get_args(FieldName)

#: All but the six components of the stress, and the displacement with that of steady loads.
DEFAULT_FIELDS: tuple[FieldName, ...] = tuple(
    name for name in FIELDS if name not in ("stress", "total_displacement")
)

FileFormat = Literal["vtu", "vtkhdf"]
"""Format of the frames of a motion: a .vtu file each with a .pvd list, or one .vtkhdf file."""

FORMATS: tuple[FileFormat, ...] = get_args(FileFormat)
