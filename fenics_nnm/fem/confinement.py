"""Limits that a process sets on itself, of Linux: memory, programs, connections, files.

Where the kernel lacks one of them the process goes on without it: scripts are checked before gmsh
sees them, and these limits are a second fence.
"""

from __future__ import annotations

import ctypes
import os
import platform
import resource
import signal
import struct
import sys
from pathlib import Path

_GIB = 2**30

#: prctl(2)
_SET_DEATH_SIGNAL, _SET_SECCOMP, _SET_NO_NEW_PRIVILEGES = 1, 22, 38
_FILTER = 2

#: personality(2)
_ASK, _SAME_ADDRESSES = 0xFFFFFFFF, 0x0040000

#: Number of the architecture in a filter, and of the calls execve, execveat, socket and ptrace.
_CALLS = {
    "x86_64": (0xC000003E, (59, 322, 41, 101)),
    "aarch64": (0xC00000B7, (221, 281, 198, 117)),
}

#: Calls above are those of another set, x32.
_OTHER_SET = 0x40000000

#: Instructions of a filter: load a word, compare equal, compare at least, return.
_LOAD, _EQUAL, _AT_LEAST, _RETURN = 0x20, 0x15, 0x35, 0x06
_ALLOW, _REFUSE = 0x7FFF0000, 0x00050000 | 1  # EPERM

#: landlock(7): calls, and the rights to write, remove and make of its first version.
_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF, _BENEATH = 444, 445, 446, 1
_WRITE_FILE = 1 << 1
_CHANGES = _WRITE_FILE | sum(1 << bit for bit in range(4, 13))


def die_with_parent() -> None:
    """Have the kernel end this process when the one that started it ends."""
    _libc().prctl(_SET_DEATH_SIGNAL, signal.SIGKILL, 0, 0, 0)
    if os.getppid() == 1:  # it has ended before
        raise SystemExit(1)


def same_addresses() -> None:
    """Have the program that this process becomes get the same addresses each time.

    gmsh's optimiser of curved elements goes through them in an order that depends on addresses.
    """
    if sys.platform == "linux":
        libc = _libc()
        libc.personality(libc.personality(_ASK) | _SAME_ADDRESSES)


def limit_memory(gibibytes: float) -> None:
    """Let this process have so many GiB of addresses and no core file."""
    most = int(gibibytes * _GIB)
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    if hard != resource.RLIM_INFINITY:
        most = min(most, hard)
    resource.setrlimit(resource.RLIMIT_AS, (most, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def confined(folder: Path) -> None:
    """Start no program, open no connection, and change no file outside `folder`, from now on."""
    libc = _libc()
    if libc.prctl(_SET_NO_NEW_PRIVILEGES, 1, 0, 0, 0):
        return
    _change_only(libc, folder)
    _refuse_calls(libc)


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _refuse_calls(libc: ctypes.CDLL) -> None:
    """seccomp(2): the calls that start a program or open a connection fail."""
    if platform.machine() not in _CALLS:
        return
    architecture, calls = _CALLS[platform.machine()]
    left = len(calls)  # comparisons up to the permission; the refusal comes after it
    code = [
        _instruction(_LOAD, 0, 0, 4),
        _instruction(_EQUAL, 0, left + 3, architecture),
        _instruction(_LOAD, 0, 0, 0),
        _instruction(_AT_LEAST, left + 1, 0, _OTHER_SET),
        *(_instruction(_EQUAL, left - i, 0, call) for i, call in enumerate(calls)),
        _instruction(_RETURN, 0, 0, _ALLOW),
        _instruction(_RETURN, 0, 0, _REFUSE),
    ]
    program = ctypes.create_string_buffer(b"".join(code))
    head = struct.pack("HxxxxxxP", len(code), ctypes.addressof(program))
    libc.prctl(_SET_SECCOMP, _FILTER, ctypes.create_string_buffer(head), 0, 0)


def _instruction(code: int, if_true: int, if_false: int, value: int) -> bytes:
    return struct.pack("HBBI", code, if_true, if_false, value)


def _change_only(libc: ctypes.CDLL, folder: Path) -> None:
    """landlock(7): files are written, made and removed beneath `folder` alone."""
    handled = ctypes.c_uint64(_CHANGES)
    rules = libc.syscall(_CREATE_RULESET, ctypes.byref(handled), ctypes.sizeof(handled), 0)
    if rules < 0:
        return
    for path, rights in ((folder, _CHANGES), (Path(os.devnull), _WRITE_FILE)):
        place = os.open(path, os.O_PATH | os.O_CLOEXEC)
        rule = ctypes.create_string_buffer(struct.pack("=Qi", rights, place))
        libc.syscall(_ADD_RULE, rules, _BENEATH, ctypes.byref(rule), 0)
        os.close(place)
    libc.syscall(_RESTRICT_SELF, rules, 0)
    os.close(rules)
