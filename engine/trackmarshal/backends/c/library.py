"""A compiled program with a context, as large as what comes needs it: what the binding exports, typed."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping

from trackmarshal.backends.c.build import library, loaded
from trackmarshal.backends.c.capacities import CAPACITIES, capacities, default
from trackmarshal.backends.c.courses import bytes_of_courses
from trackmarshal.backends.c.over_run.cells import bytes_of_pairs, bytes_of_rate
from trackmarshal.backends.c.places import bytes_of_lanes, lanes
from trackmarshal.backends.c.source import Source
from trackmarshal.errors import TrackmarshalError

#: Sizes that programs are compiled with. Series cost memory for every sample, bounds of loops do not.
_CLASSES = (256, 4096, 65536, 1 << 20, 1 << 24)
_FREE = 1 << 24
#: Cycles in a second that windows have room for where nobody says how fast they come, and the bytes that they may take.
_RATE, _BYTES = 1000, 256 << 20


class Result(ctypes.Structure):
    """A `tm_result`."""

    _fields_ = [("margin", ctypes.c_double), ("verdict", ctypes.c_int)]


def aligned(size: int) -> tuple[ctypes.Array[ctypes.c_char], int]:
    """So many bytes, and where they begin: at a multiple of 64, as the widest registers want it."""
    memory = ctypes.create_string_buffer(size + 64)
    return memory, (ctypes.addressof(memory) + 63) & ~63


class Library:
    """One compiled program with a context: what the binding exports, typed."""

    def __init__(self, source: Source, sizes: dict[str, int]) -> None:
        self.sizes = sizes
        self.dll = loaded(library(source, sizes))
        size, pointer, number = ctypes.c_size_t, ctypes.c_void_p, ctypes.c_double
        self.dll.tmg_size.restype = size
        for name, kinds in {
            "tmg_init": [pointer],
            "tmg_set_param": [pointer, size, number],
            "tmg_set_table": [pointer, size, pointer, pointer, size],
            "tmg_set_place": [pointer, size, pointer, size, pointer, size, ctypes.c_int],
            "tmg_run": [pointer, size, pointer, pointer, pointer, pointer, pointer, pointer],
            "tmg_along": [pointer, size, pointer, pointer, pointer, pointer, pointer],
        }.items():
            getattr(self.dll, name).argtypes = kinds
            getattr(self.dll, name).restype = ctypes.c_int
        if source.plan.remembers:
            self.dll.tmg_remember.argtypes = [*[pointer] * 5, ctypes.c_int]
            self.dll.tmg_missed.argtypes = [pointer, ctypes.c_uint64]
            self.dll.tmg_remembered.restype = self.dll.tmg_remembered_size.restype = size
        if source.plan.lasting:
            self.dll.tmg_without.argtypes = [pointer, size, size]
        if lanes(source.plan):
            self.dll.tmg_set_lane.argtypes = [pointer, size, size, pointer, size, pointer, size]
        if source.plan.future.rules:
            self.dll.tmg_oldest.argtypes = self.dll.tmg_present.argtypes = self.dll.tmg_end.argtypes = [
                pointer
            ]
            self.dll.tmg_oldest.restype = self.dll.tmg_present.restype = ctypes.c_uint64
            self.dll.tmg_about.argtypes = [pointer, size, ctypes.c_int, *[pointer] * 4]
            self.dll.tmg_about.restype = self.dll.tmg_room.restype = size
        self._memory, self.context = aligned(self.dll.tmg_size())
        self.status = self.dll.tmg_init(self.context)

    def take_over(self, other: Library) -> None:
        """Remember what another one does, of the same rules."""
        size = self.dll.tmg_remembered_size()
        if size != other.dll.tmg_remembered_size():
            raise AssertionError("what is remembered is of another size")
        start = self.dll.tmg_remembered()
        ctypes.memmove(self.context + start, other.context + other.dll.tmg_remembered(), size)


def fitting(source: Source, wanted: Mapping[str, int], have: Library | None) -> dict[str, int]:
    """The capacities of a program that holds what is wanted, and no less than the library at hand. Raises TrackmarshalError E473 for what takes too
    much memory, and for more elements than the library at hand remembers."""
    plan = source.plan
    if have is not None and plan.named and wanted["TM_MAX_ELEMENTS"] > have.sizes["TM_MAX_ELEMENTS"]:
        raise TrackmarshalError(
            "E473",
            "more elements come in the middle of a run than memory was made for",
            help="raise the limit `elements`, or choose another backend",
        )
    sizes = {name: _size(source, name, wanted[name], wanted["TM_MAX_ELEMENTS"]) for name in capacities(plan)}
    if have is not None:  # windows keep their room: what is remembered is taken over as it is
        sizes = {name: max(size, have.sizes[name]) for name, size in sizes.items()}
        sizes |= {name: have.sizes[name] for name in sizes if name == "TM_MAX_RATE"}
    if bytes_of_lanes(plan, sizes) > _BYTES:
        raise TrackmarshalError(
            "E473", f"lanes take more than {_BYTES >> 20} MiB", help="choose another backend"
        )
    if bytes_of_pairs(plan.kept.values(), sizes.get("TM_MAX_ELEMENTS", 0)) > _BYTES:
        raise TrackmarshalError(
            "E473", f"what is remembered of pairs of elements takes more than {_BYTES >> 20} MiB",
            help="give the sets a smaller `capacity`, or choose another backend",
        )  # fmt: skip
    return sizes


def _size(source: Source, name: str, wanted: int, came: int) -> int:
    """A capacity that holds so much; came: how many elements come."""
    plan, spec = source.plan, source.plan.spec
    if name == "TM_MAX_RATE":
        elements = default("TM_MAX_ELEMENTS", spec)
        each = bytes_of_rate(plan.kept.values(), elements, max(elements, came))
        each += plan.future.bytes_of_rate(elements)
        each += bytes_of_courses(plan.courses.values(), source.series)
        if each * default(name, spec) > _BYTES:
            raise TrackmarshalError(
                "E473",
                f"windows of rules over the run take more than {_BYTES >> 20} MiB",
                help="choose another backend",
            )
        return int(min(_RATE, _BYTES / max(each, 1.0)))
    if name == "TM_MAX_ELEMENTS" and (plan.named or lanes(plan)):
        return max(wanted, default(name, spec))
    if name == "TM_MAX_ELEMENTS" or (name == "TM_MAX_SAMPLES" and not source.series and not plan.courses):
        return _FREE
    least = max(wanted, 256)
    if name == "TM_MAX_KNOTS":
        least = max(wanted, CAPACITIES[name][0], *(len(spec.tables[table].knots) for table in plan.tables))
    if name == "TM_MAX_BORDER" and not lanes(plan):  # there is one for each lane
        least = max(wanted, CAPACITIES[name][0])
    if name == "TM_MAX_PLACE":
        least = max(wanted, *(len(p.points) for p in spec.places.values()))
    for size in _CLASSES:
        if size >= least:
            return size
    raise TrackmarshalError("E473", f"{wanted} is more than the {_CLASSES[-1]} that generated programs hold")
