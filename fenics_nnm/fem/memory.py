"""How much memory a factorisation may take."""

from __future__ import annotations

from mpi4py import MPI

from fenics_nnm.files.free_memory import free_memory

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
