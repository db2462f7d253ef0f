"""How much memory a factorisation may take."""

from __future__ import annotations

from pathlib import Path

from mpi4py import MPI

#: Part of the memory that is free which a factorisation may take if nobody says otherwise.
_PART = 0.8

_GIB = 2**30


def memory_of_rank(comm: MPI.Comm, gibibytes: float | None) -> float | None:
    """Memory in bytes that this rank may take for factors, the same on all ranks.

    Args:
        comm: Communicator of the mesh; its ranks share the memory of their machines evenly.
        gibibytes: Memory of all ranks of a machine; if not given, most of what is free there.

    Returns:
        Bytes; None where the machine does not tell what is free.
    """
    node = comm.Split_type(MPI.COMM_TYPE_SHARED)
    free = free_memory() if gibibytes is None else None
    whole = gibibytes * _GIB if gibibytes is not None else _PART * free if free else None
    own = whole / node.size if whole is not None else None
    node.Free()
    known = [share for share in comm.allgather(own) if share is not None]
    return min(known, default=None)


def free_memory() -> float | None:
    """Free memory of the machine, or of the control group that this process is in, in bytes."""
    found = [bytes_ for bytes_ in (_free_of_machine(), _free_of_group()) if bytes_ is not None]
    return min(found, default=None)


def _free_of_machine() -> float | None:
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
    except OSError:
        return None
    kibibytes = [line.split()[1] for line in lines if line.startswith("MemAvailable:")]
    return 1024.0 * float(kibibytes[0]) if kibibytes else None


def _free_of_group(folder: Path = Path("/sys/fs/cgroup")) -> float | None:
    """What is left of the limit of a container; its page cache counts as used."""
    try:
        limit, used = ((folder / f"memory.{name}").read_text() for name in ("max", "current"))
        return float(limit) - float(used)
    except (OSError, ValueError):  # no such group, or "max": without a limit
        return None
