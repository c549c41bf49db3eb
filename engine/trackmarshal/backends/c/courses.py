"""Courses in generated C: what was driven is kept in a ring of fixed size, and joined with a candidate into columns of the context."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from trackmarshal.backends.c.names import comment, distinct
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import CourseInfo, FieldType, RuleInfo

#: Members of a course's columns that no field may be called.
_TAKEN = ("begin", "count", "end", "missing", "now")
#: What the names of a course's functions end in, after its own: no other course's name may.
_ENDINGS = ("_at", "_add", "_gap", "_now", "_remember", "_item")


@dataclass(frozen=True)
class Course:
    """A course with its C name, and the fields that rules read of it, with theirs; the time is one of them where it is read."""

    info: CourseInfo
    c_name: str
    fields: tuple[tuple[FieldType, str], ...]

    @property
    def kept(self) -> tuple[tuple[FieldType, str], ...]:
        """The fields that are kept of what was driven."""
        return tuple((info, c_name) for info, c_name in self.fields if info.name != "t")

    @property
    def room(self) -> str:
        """C of how many items there is room for, of what was driven."""
        return f"TM_CYCLES_IN(UINT64_C({math.ceil(self.info.back / 1e6)}))"

    @property
    def size(self) -> str:
        """C of how many samples there are at most: beside those, the one that is now with a gap before it, and what is planned."""
        return f"({self.room} + TM_MAX_SAMPLES + 2u)"

    def most(self, rate: int, samples: int) -> int:
        """How many samples there are at most, by the capacities."""
        return math.ceil(self.info.back / 1e6) * rate // 1000 + 6 + samples


def courses_of(rules: Iterable[RuleInfo], columns: dict[str, set[str]]) -> dict[str, Course]:
    """The courses that rules live along, by name, whose fields are taken out of `columns`; what they join is put there instead."""
    infos = {rule.course.signal.name: rule.course for rule in rules if rule.course is not None}
    read = {name: columns.pop(name, set()) for name in infos}
    for name, info in infos.items():
        columns.setdefault(info.lived, set()).update(read[name] - {"t"})
        columns.setdefault(info.planned, set()).update(read[name] | {"t"})
    names = distinct(infos, endings=_ENDINGS)
    return {name: _course(info, names[name], read[name]) for name, info in infos.items()}


def _course(info: CourseInfo, c_name: str, read: set[str]) -> Course:
    chosen = [each for each in info.signal.fields_ if each.name in read]
    fields = distinct((each.name for each in chosen), _TAKEN)
    return Course(info, c_name, tuple((each, fields[each.name]) for each in chosen))


def described(course: Course, field: Callable[[str, str], str]) -> dict[str, Any]:
    """What the templates ask about a course. field: C of a field of a signal; of none, how many samples it has."""
    info = course.info
    return {
        "name": comment(info.signal.name), "c_name": course.c_name, "about": comment(str(info.signal.span)),
        "back": f"INT64_C({info.back})", "room": course.room, "size": course.size, "planned": field(info.planned, ""),
        "due": field(info.planned, "t"),
        "fields": [_field(course, each, c_name, field) for each, c_name in course.fields],
    }  # fmt: skip


def _field(
    course: Course, info: FieldType, c_name: str, field: Callable[[str, str], str]
) -> Mapping[str, Any]:
    flag, time = info.kind == "bool", info.name == "t"
    return {
        "c_name": c_name, "type": "tm_flag" if flag else "double", "unknown": "TM_MISSING" if flag else "TM_NAN", "is_time": time,
        "lived": "" if time else field(course.info.lived, info.name), "planned": field(course.info.planned, info.name),
    }  # fmt: skip


def longest(courses: Iterable[Course]) -> Course | None:
    """The course that goes back farthest: its samples are the most."""
    return max(courses, key=lambda each: each.info.back, default=None)


def bytes_of_courses(courses: Collection[Course], series: int) -> float:
    """About how many bytes courses take for each cycle a second that there is room for, with so many formulas at all of their samples."""
    found = [(64 + 16 * len(each.fields)) * each.info.back / 1e9 for each in courses]
    most = max((each.info.back for each in courses), default=0)
    return sum(found) + 16 * (series + 3) * most / 1e9


def counts_samples(nodes: Iterable[ir.AnyNode]) -> bool:
    """Whether samples of a timeline are counted."""
    return any(isinstance(node, ir.Tallied) for node in nodes)
