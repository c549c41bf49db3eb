"""Monitors of generated C from Python: a timeline pushed a sample at a time, with memory that is there before the first one."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.c.build import library, loaded
from trackmarshal.backends.c.functions.online import CAPACITY
from trackmarshal.backends.c.source import generate
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.verdict import VERDICTS

_OUTCOME = np.dtype([("margin", np.float64), ("verdict", np.int32)], align=True)


class Monitors:
    """The monitors of those rules that can be judged a sample at a time; `names` says which these are.

    capacity: the samples of the longest window, and a few. Raises TrackmarshalError E470 to E472.
    """

    def __init__(self, spec: Spec, rules: Sequence[RuleInfo], capacity: int = CAPACITY) -> None:
        source = generate(spec, rules, online=True)
        self._fields = {
            monitor.rule.name: [(info.name, info.kind == "bool") for info, _ in monitor.fields]
            for monitor in source.monitors
        }
        self.names = tuple(self._fields)
        self._dll = loaded(library(source, {"TM_MAX_ONLINE": capacity}))
        pointer, size = ctypes.c_void_p, ctypes.c_size_t
        for name, result, kinds in (
            ("tmg_size", size, []),
            ("tmg_init", ctypes.c_int, [pointer]),
            ("tmg_online_size", size, [size]),
            ("tmg_online", size, [pointer, size, pointer, size, pointer, pointer]),
        ):
            getattr(self._dll, name).restype, getattr(self._dll, name).argtypes = result, kinds
        self._context = np.zeros(self._dll.tmg_size() // 8 + 1)
        self._dll.tmg_init(self._context.ctypes.data)
        self._memory = [np.zeros(self._dll.tmg_online_size(i) // 8 + 1) for i in range(len(self.names))]

    def run(self, name: str, columns: Mapping[str, Any]) -> tuple[NDArray[Any], tuple[str, float]]:
        """Push a whole timeline: verdict codes and margins, one a sample, and the rule's verdict and margin.

        columns: by field, float64 in SI; Booleans int8 with -1 for missing. Raises E473 where a sample does not fit: a time
        that does not increase, more samples at once than the capacity.
        """
        number = self.names.index(name)
        given = [
            np.ascontiguousarray(columns[field], dtype=np.int8 if flag else np.float64)
            for field, flag in self._fields[name]
        ]
        count = min((len(column) for column in given), default=0)
        pointers = np.array([column.ctypes.data for column in given] or [0], dtype=np.uint64)
        out = np.zeros(count + 1, dtype=_OUTCOME)
        done = self._dll.tmg_online(
            self._context.ctypes.data, number, self._memory[number].ctypes.data, count, pointers.ctypes.data, out.ctypes.data,
        )  # fmt: skip
        if done != count:
            raise TrackmarshalError(
                "E473", f"the monitor of `{name}` refuses a sample after {done} decided ones"
            )
        return out[:count], (VERDICTS[out[count]["verdict"]], float(out[count]["margin"]))
