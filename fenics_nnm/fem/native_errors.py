"""Errors of native readers and meshers, by what they work on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from fenics_nnm.errors import Code, MeshError


class NativeErrors(Protocol):
    """Makes the errors of a job."""

    @property
    def what(self) -> str:
        """What the job works on, at the head of messages."""

    def failed(self, reason: str) -> MeshError:
        """It cannot be done."""

    def too_slow(self, reason: str) -> MeshError:
        """It takes too long."""

    def too_large(self, reason: str) -> MeshError:
        """It takes too much memory."""


@dataclass(frozen=True, slots=True)
class FileErrors:
    """Errors of a job with a file.

    Attributes:
        path: The file.
    """

    path: Path

    @property
    def what(self) -> str:
        """The file."""
        return f"mesh file {self.path}"

    def failed(self, reason: str) -> MeshError:
        """The file cannot be used."""
        return MeshError(f"mesh file {self.path}: {reason}", code=Code.MESH_FILE)

    def too_slow(self, reason: str) -> MeshError:
        """The file takes too long."""
        return MeshError(
            f"mesh file {self.path}: {reason}; or raise the time limit", code=Code.TIME_LIMIT
        )

    def too_large(self, reason: str) -> MeshError:
        """The file takes too much memory."""
        return MeshError(
            f"mesh file {self.path}: {reason}, which is the memory limit: larger elements, or a "
            "higher limit",
            code=Code.MEMORY_LIMIT,
        )


@dataclass(frozen=True, slots=True)
class GeometryErrors:
    """Errors of a job with a built-in geometry.

    Attributes:
        model: Its name.
    """

    model: str

    @property
    def what(self) -> str:
        """The geometry."""
        return f'built-in geometry "{self.model}"'

    def failed(self, reason: str) -> MeshError:
        """The geometry cannot be meshed."""
        return MeshError(f"{self.what}: {reason}")

    def too_slow(self, reason: str) -> MeshError:
        """It takes too long."""
        return self.failed(reason)

    def too_large(self, reason: str) -> MeshError:
        """It takes too much memory."""
        return self.failed(f"{reason}: larger elements")
