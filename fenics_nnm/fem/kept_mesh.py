"""A mesh as it was read, kept so that neither its file nor gmsh is needed again."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from fenics_nnm.fem.raw_mesh import RawMesh, arrays_of


@dataclass(frozen=True, slots=True)
class MeshAsRead:
    """A mesh as rank 0 has read it, as arrays to be stored.

    Attributes:
        arrays: Those of `raw_mesh.arrays_of`, whole numbers as short as they can be, and `metres`,
            the metres in one unit of the coordinates; on rank 0, none on the others.
        digest: Digest of all of them in hexadecimal digits; the same on all ranks.
    """

    arrays: Mapping[str, Any] = field(default_factory=dict)
    digest: str = ""


class StoredMesh(Protocol):
    """A mesh that an earlier run has kept.

    Attributes:
        digest: That of `MeshAsRead`.
        metres: Metres in one unit of its coordinates.
    """

    @property
    def digest(self) -> str:
        """That of `MeshAsRead`."""

    @property
    def metres(self) -> float:
        """Metres in one unit of its coordinates."""

    def read(self) -> RawMesh:
        """The mesh; called on rank 0 alone."""


def mesh_as_read(raw: RawMesh, metres: float) -> MeshAsRead:
    """A mesh as it is kept, on the rank that has read it.

    Args:
        raw: The mesh.
        metres: Metres in one unit of its coordinates.
    """
    arrays = {name: _short(values) for name, values in arrays_of(raw).items()}
    arrays["metres"] = np.array([metres])
    total = hashlib.blake2b(digest_size=16)
    for name, values in arrays.items():
        total.update(f"{name} {values.dtype.str} {values.shape}".encode())
        total.update(np.ascontiguousarray(values).data)
    return MeshAsRead(arrays, total.hexdigest())


def _short(values: Any) -> Any:
    """Whole numbers in 4 bytes where they fit."""
    if values.dtype != np.int64 or np.abs(values).max(initial=0) > np.iinfo(np.int32).max:
        return values
    return values.astype(np.int32)
