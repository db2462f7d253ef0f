"""Memory that is free."""

from __future__ import annotations

from pathlib import Path


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
