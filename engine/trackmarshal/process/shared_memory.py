"""Mailboxes in shared memory, as docs/process.md describes them: this side writes one file and maps the other for reading only."""

from __future__ import annotations

import ctypes
import fcntl
import mmap
import os
import platform
import struct
import sys
import time
import weakref
from contextlib import suppress
from typing import Any

from .messages import Layout, LinkError

_START = struct.Struct("<IIQQ")
#: Numbers of the system call `futex` by machine: for processes of 64 bits, and of 32, which kernels of 64 run as well, and tell their own machine.
_FUTEX_64 = {"x86_64": 202, "aarch64": 98, "riscv64": 98, "loongarch64": 98, "ppc64le": 221}
_FUTEX_32 = dict.fromkeys(
    ("i386", "i486", "i586", "i686", "x86_64", "armv6l", "armv7l", "armv8l", "aarch64"), 240
)
_WAIT, _WAKE = 0, 1
_TRIES = 64


def _futex() -> int | None:
    """The number of the system call `futex` for this process; None where it is not known, so that readers look every 50 us."""
    if sys.platform != "linux":
        return None
    return (_FUTEX_64 if sys.maxsize > 2**32 else _FUTEX_32).get(platform.machine())


_FUTEX = _futex()


class _Timespec(ctypes.Structure):
    _fields_ = [("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long)]


class _Buffer(ctypes.Structure):
    """CPython's Py_buffer, of which the address is wanted: ctypes itself has none of memory that is read-only."""

    _fields_ = [
        ("address", ctypes.c_void_p), ("owner", ctypes.py_object), ("length", ctypes.c_ssize_t), ("item", ctypes.c_ssize_t),
        ("readonly", ctypes.c_int), ("axes", ctypes.c_int), ("format", ctypes.c_char_p), ("shape", ctypes.c_void_p),
        ("strides", ctypes.c_void_p), ("suboffsets", ctypes.c_void_p), ("internal", ctypes.c_void_p),
    ]  # fmt: skip


def _address(memory: mmap.mmap) -> int:
    """Where a mapping stands in memory, as long as it is mapped."""
    found = _Buffer()
    ctypes.pythonapi.PyObject_GetBuffer(ctypes.py_object(memory), ctypes.byref(found), 0)
    place = int(found.address)
    ctypes.pythonapi.PyBuffer_Release(ctypes.byref(found))
    return place


class Region:
    """A file of mailboxes. Raises LinkError where it is not there, or is of another layout."""

    def __init__(self, layout: Layout, name: str, path: str, writing: bool) -> None:
        self.path = path
        memory = layout.said["memory"]
        said = next(file for file in memory["files"] if file["name"] == name)
        self._boxes = {box["name"]: box for box in said["mailboxes"]}
        self._lengths = {kind.name: kind.length for kind in layout.kinds.values()}
        self._line, size = memory["line"], said["size"]
        try:
            file = os.open(path, os.O_RDWR if writing else os.O_RDONLY)
        except OSError as error:
            raise LinkError(
                f"{path} cannot be opened: no Supervisor has made it ({error.strerror})"
            ) from error
        self._file: int | None = file
        begin = os.pread(file, _START.size, 0)
        wanted = _START.pack(memory["magic"], memory["version"], layout.fingerprint, size)
        if os.fstat(file).st_size != size or begin != wanted:
            os.close(file)
            raise LinkError(
                f"{path} is for another spec, other rules, capacities or limits, of another engine, or is none of ours"
            )
        if writing:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # kept until it is closed
            except OSError as error:
                os.close(file)
                raise LinkError(f"{path} is written by another client") from error
        self._map = mmap.mmap(file, size, access=mmap.ACCESS_WRITE if writing else mmap.ACCESS_READ)
        self._bytes = memoryview(self._map)
        self._words = self._bytes.cast("Q")
        self._halves = self._bytes.cast("I")
        self._bell = memory["bell"] // 4
        self._bell_at = _address(self._map) + memory["bell"]
        self._libc: Any = ctypes.CDLL(None, use_errno=True)
        if writing:
            _written.add(self)

    def close(self) -> None:
        for view in (self._words, self._halves, self._bytes):
            view.release()
        self._map.close()
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def latest(self, box: str) -> int:
        """How many messages a mailbox has had."""
        return int(self._words[self._boxes[box]["place"] // 8])

    @property
    def heard(self) -> int:
        """How often the bell has rung."""
        return int(self._halves[self._bell])

    def put(self, name: str, message: bytearray) -> None:
        """Put a message into a mailbox, and ring.

        Python has no fences. x86-64 keeps the order of these writes; elsewhere a reader that sees them in another order finds a wrong
        CRC and takes nothing.
        """
        box, words = self._boxes[name], self._words
        following = words[box["place"] // 8] + 1
        slot = box["first"] + following % box["slots"] * box["step"]
        words[slot // 8] = 2 * following - 1
        begin = slot + self._line
        self._bytes[begin : begin + len(message)] = message
        words[slot // 8] = 2 * following
        words[box["place"] // 8] = following
        self._halves[self._bell] = (self._halves[self._bell] + 1) & 0xFFFF_FFFF
        if _FUTEX is not None:
            self._libc.syscall(_FUTEX, ctypes.c_void_p(self._bell_at), _WAKE, 0x7FFF_FFFF, None, None, 0)

    def get(self, name: str, seen: int) -> tuple[int, bytes | None]:
        """The newest message of a mailbox that is newer than `seen`, and its number; None where there is none, or no whole one."""
        box, words = self._boxes[name], self._words
        newest = seen
        for _ in range(_TRIES):
            newest = words[box["place"] // 8]
            if newest == seen:
                return seen, None
            slot = box["first"] + newest % box["slots"] * box["step"]
            if words[slot // 8] == 2 * newest:
                begin = slot + self._line
                found = bytes(self._bytes[begin : begin + self._lengths[box["message"]]])
                if words[slot // 8] == 2 * newest:
                    return newest, found
        return newest, None

    def wait(self, heard: int, seconds: float, spin: bool = False) -> None:
        """Wait until the bell has rung since it was `heard`, at most so many seconds."""
        if spin or _FUTEX is None:
            until = time.monotonic() + seconds
            while self._halves[self._bell] == heard and time.monotonic() < until:
                if not spin:
                    time.sleep(50e-6)
            return
        if self._halves[self._bell] == heard and seconds > 0.0:
            most = min(seconds, 1.0)
            span = _Timespec(int(most), int(most % 1.0 * 1e9))
            self._libc.syscall(
                _FUTEX,
                ctypes.c_void_p(self._bell_at),
                _WAIT,
                ctypes.c_uint32(heard),
                ctypes.byref(span),
                None,
                0,
            )


#: What this process writes.
_written = weakref.WeakSet[Region]()


def _forked() -> None:
    """A fork writes nothing, and has no copy of a lock, which would keep others out when the planner is gone."""
    for region in list(_written):
        with suppress(BufferError):  # another thread was writing just then
            region.close()


os.register_at_fork(after_in_child=_forked)


class SharedMemory:
    """What a client sends and hears over shared memory that a Supervisor has made. executing: it only listens."""

    def __init__(self, layout: Layout, name: str, spin: bool = False, executing: bool = False) -> None:
        self._decisions = Region(layout, "decisions", f"{name}.decisions", False)
        try:
            self._cycles = None if executing else Region(layout, "cycles", f"{name}.cycles", True)
        except LinkError:
            self._decisions.close()
            raise
        self._spin = spin
        # What was said before is not for this client.
        self._seen = {box: self._decisions.latest(box) for box in ("decision", "beat")}

    def send(self, box: str, message: bytearray) -> bool:
        """box: `cycle`, `tick`, or `line_K`."""
        assert self._cycles is not None, "whoever executes sends nothing"
        self._cycles.put(box, message)
        return True

    def receive(self, seconds: float) -> bytes | None:
        """The newest decision or sign of life that was not received yet; None where none comes."""
        until = time.monotonic() + seconds
        while True:
            heard = self._decisions.heard
            for box, seen in self._seen.items():
                self._seen[box], found = self._decisions.get(box, seen)
                if found is not None:
                    return found
            left = until - time.monotonic()
            if left <= 0.0:
                return None
            self._decisions.wait(heard, left, self._spin)

    def close(self) -> None:
        self._decisions.close()
        if self._cycles is not None:
            self._cycles.close()
