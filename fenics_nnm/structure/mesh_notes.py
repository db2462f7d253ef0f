"""What was left out or changed on reading a mesh, said once."""

from __future__ import annotations

import logging
from collections.abc import Sequence

from mpi4py import MPI

logger = logging.getLogger(__name__)


def report_notes(notes: Sequence[str], comm: MPI.Comm) -> None:
    """Give each note as a line of the log, on rank 0."""
    if comm.rank == 0:
        for note in notes:
            logger.warning("mesh file: %s", note)
