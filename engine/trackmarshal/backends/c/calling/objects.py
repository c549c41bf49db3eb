"""How Python's objects and numpy's arrays stand in memory, as C reads and makes them: looked at in objects of which all is known."""

from __future__ import annotations

import ctypes
import struct
import sys
from typing import Any

import numpy as np


class OtherObjectsError(OSError):
    """Objects of Python or numpy are not what they are taken for: then C does not touch them, and Python does the same."""

    def __init__(self) -> None:
        super().__init__("objects of Python or numpy are not what they are taken for")


def as_known() -> bool:
    """Whether Python's objects and numpy's arrays look as gather.c takes them to look."""
    head, pointer = object.__basicsize__, ctypes.sizeof(ctypes.c_void_p)
    if head != 2 * pointer:
        return False
    probe, swapped = np.zeros((3, 2))[:, 1], np.dtype(np.float64).newbyteorder()
    _, kind, data, ndim, shape, strides, base, dtype = struct.unpack_from("@nPPiPPPP", memory(probe))
    if (kind, data, ndim, base, dtype) != (
        id(np.ndarray),
        probe.ctypes.data,
        1,
        id(probe.base),
        id(probe.dtype),
    ):
        return False
    sizes = [ctypes.c_ssize_t.from_address(at).value for at in (shape, strides)]
    orders = [struct.unpack_from("@nPPccc", memory(one))[-3:] for one in (probe.dtype, swapped)]
    order = b"<" if sys.byteorder == "big" else b">"
    return sizes == [3, 16] and orders == [(b"f", b"d", b"="), (b"f", b"d", order)]


def memory(one: object, more: int = 0) -> bytes:
    """The bytes of an object, without what varies in length but for the first so many."""
    return ctypes.string_at(id(one), type(one).__basicsize__ + more)


def places(cls: type, *names: str) -> list[int]:
    """Where the attributes of these slots stand in the memory of a class's objects; raises OSError where they do not."""
    probe: Any = object.__new__(cls)
    marks = [object() for _ in names]
    for name, mark in zip(names, marks):
        object.__setattr__(probe, name, mark)
    return [_place(probe, mark) for mark in marks]


def place_of_items() -> int:
    """Where the items of a tuple begin; raises OSError where they do not."""
    items = object(), object()
    first, second = (_place(items, one, 2 * ctypes.sizeof(ctypes.c_void_p)) for one in items)
    if second - first != ctypes.sizeof(ctypes.c_void_p):
        raise OtherObjectsError
    return first


def place_of_number() -> int:
    """Where the number of a float stands; raises OSError where it does not."""
    found = memory(-1234.5).find(struct.pack("@d", -1234.5))
    if found < object.__basicsize__:
        raise OtherObjectsError
    return found


def place_of_bytes() -> int:
    """Where the bytes of bytes begin; raises OSError where they do not."""
    said = b"where they begin"
    found = memory(said, len(said)).find(said)
    if found < object.__basicsize__:
        raise OtherObjectsError
    return found


def _place(holder: object, held: Any, more: int = 0) -> int:
    seen = memory(holder, more)
    words = struct.unpack_from(f"@{len(seen) // ctypes.sizeof(ctypes.c_void_p)}P", seen)
    if words.count(id(held)) != 1:
        raise OtherObjectsError
    return words.index(id(held)) * ctypes.sizeof(ctypes.c_void_p)
