"""What an integrator asks about generated code: memory, stack, loops, operations, complexity, libm."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from pathlib import Path

from trackmarshal.backends.c import calls
from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.build import EXACT, loaded, sizes
from trackmarshal.backends.c.capacities import CAPACITIES, capacities, default
from trackmarshal.backends.c.functions.online import CAPACITY
from trackmarshal.backends.c.functions.operators import called
from trackmarshal.backends.c.rulebooks import book_codes
from trackmarshal.backends.c.source import Source
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.operators import FUNCTIONS
from trackmarshal.runtime.contract import RECORD, SET, TIMELINE
from trackmarshal.runtime.decision import MOST_REASONS
from trackmarshal.runtime.geometry.curve import MOST as MOST_PIECES

#: What rules call, and what our own functions call besides.
LIBM = (
    *dict.fromkeys(("fabs", "fabsf", *chain.from_iterable(called(name)[1] for name in FUNCTIONS))),
    "hypot",
    "fmod",
    "remainder",
)
_FUNCTION = re.compile(
    r"^(?:static (?:inline )?)?[a-z_]+ \*?(tm_[a-z0-9_A-Z]+)\([^;{]*?\)\s*\{", re.MULTILINE
)
_CALL = re.compile(r"\b(tm_[a-z0-9_A-Z]+)\(")
_DECISION = re.compile(r"\bif\b|\bfor\b|\bwhile\b|\bcase\b|&&|\|\||\?")


def report(source: Source) -> str:
    """The report, as markdown."""
    return "\n".join([*_lines(source), ""])


def libm(source: Source) -> list[str]:
    """The functions of libm that a program calls."""
    code = re.sub(r"/\*.*?\*/", "", source.source, flags=re.DOTALL)
    return [name for name in LIBM if re.search(rf"\b{name}\(", code)]


def complexity(source: Source) -> dict[str, int]:
    """Cyclomatic complexity of every function: one more than its decisions."""
    code = re.sub(r"/\*.*?\*/", "", source.source, flags=re.DOTALL)
    found = list(_FUNCTION.finditer(code))
    ends = [match.start() for match in found[1:]] + [len(code)]
    return {
        match.group(1): 1 + len(_DECISION.findall(code[match.end() : end])) for match, end in zip(found, ends)
    }


def stack(source: Source) -> dict[str, int] | None:
    """Bytes of stack of every function, as gcc says; None without gcc. Inlined functions are part of their callers."""
    gcc = shutil.which("gcc")
    if gcc is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        (place / f"{source.name}.h").write_text(source.header, encoding="utf-8")
        (place / f"{source.name}.c").write_text(source.source, encoding="utf-8")
        command = [gcc, *EXACT, "-O2", "-fstack-usage", "-c", f"{source.name}.c"]
        if subprocess.run(command, cwd=place, capture_output=True, check=False).returncode != 0:
            return None
        usage = next(place.glob("*.su"), None)
        if usage is None:
            return None
        rows = [line.split("\t") for line in usage.read_text(encoding="utf-8").splitlines()]
        return {row[0].rpartition(":")[2].split(".")[0]: int(row[1]) for row in rows}


def deepest(source: Source, usage: Mapping[str, int]) -> tuple[int, list[str]]:
    """The most bytes of stack at once, libm's own left out, and the chain of calls that needs them."""
    code = re.sub(r"/\*.*?\*/", "", source.source, flags=re.DOTALL)
    found = list(_FUNCTION.finditer(code))
    ends = [match.start() for match in found[1:]] + [len(code)]
    names = {match.group(1) for match in found}
    calls = {
        match.group(1): set(_CALL.findall(code[match.end() : end])) & names - {match.group(1)}
        for match, end in zip(found, ends)
    }
    known: dict[str, tuple[int, list[str]]] = {}

    def below(name: str) -> tuple[int, list[str]]:
        if name not in known:
            most = max((below(other) for other in sorted(calls[name])), default=(0, []))
            known[name] = (usage.get(name, 0) + most[0], [name, *most[1]] if name in usage else most[1])
        return known[name]

    return max((below(name) for name in calls), default=(0, []))


def context_bytes(source: Source) -> tuple[int, list[int]] | None:
    """Bytes of the context, and of every monitor, with the default capacities; None without a compiler for this machine."""
    types = ["tm_context", *(f"tm_online_{monitor.c_name}" for monitor in source.monitors)]
    try:
        dll = loaded(sizes(source, types))
    except TrackmarshalError as error:
        if error.code == "E471":
            return None
        raise
    context, *monitors = (ctypes.c_size_t * len(types)).in_dll(dll, "sizes")
    return context, monitors


def _step(given: Supervised, limits: Mapping[str, int]) -> Iterator[str]:
    """What a step does beside the rules."""
    sizes = {TIMELINE: limits.get("TM_MAX_SAMPLES", 0), SET: limits.get("TM_MAX_ELEMENTS", 0), RECORD: 1}
    contract = given.contract
    assert contract.plan is not None
    signals = [contract.plan, contract.plan, *given.inputs]
    values = sum(sizes[s.form] * sum(max(1, len(f.checks)) for f in (*s.numbers, *s.flags)) for s in signals)
    of_lanes = sizes[SET] * sum(len(signal.lines) for signal in given.lanes)
    lines = sum(len(signal.lines) for signal in given.borders) + of_lanes
    points = 2 * limits.get("TM_MAX_BORDER", 0) * lines
    samples = sizes[TIMELINE]
    yield "| part of a step | values looked at, worst case |"
    yield "|---|---:|"
    yield f"| door: every value, for each kind of check that it has to pass | {values} |"
    if points:
        yield f"| door: points of borders and lines that are new (they are prepared too, which takes the most of all) | {points} |"
    yield f"| watchdog and reasons: results of rules | TM_RULES x 2, and {MOST_REASONS} reasons |"
    yield f"| storing the emergency trajectory of a safe cycle | {samples * (1 + len(given.plan.fields))} |"
    yield f"| whether what is stored may be driven, and from which sample on | {2 * samples} |"
    yield ""


def _lines(source: Source) -> Iterator[str]:
    plan = source.plan
    limits = {name: default(name, plan.spec) for name in capacities(plan, source.supervised)}
    yield f"# Report on `{source.name}.c`"
    yield ""
    yield f"Generated from a spec with fingerprint `{plan.spec.fingerprint[:16]}`; {len(source.rules)} rules. C99, no allocation, no recursion, no global"
    yield "state. Figures are for the default capacities and this machine's compiler."
    yield ""
    size = context_bytes(source)
    yield f"- Context: {'unknown (no compiler for this machine)' if size is None else f'{size[0]} bytes'}."
    for monitor, bytes_ in zip(source.monitors, size[1] if size is not None else []):
        yield f"- Monitor of {monitor.rule.name}, a sample at a time: {bytes_} bytes (TM_MAX_ONLINE {CAPACITY})."
    usage = stack(source)
    if usage is None:
        yield "- Stack: unknown (gcc's -fstack-usage says it)."
    else:
        most, chain = deepest(source, usage)
        yield f"- Stack: at most {most} bytes, libm's own left out (no recursion; {' > '.join(f'`{name}`' for name in chain)})."
    yield f"- libm: {', '.join(libm(source)) or 'nothing'}."
    own = [f"{name} ({', '.join(functions)})" for name, functions in calls.inexact(source).items()]
    yield f"- Margins whose last digits depend on the C library: {', '.join(own) or 'none'}."
    if plan.spec.rulebooks:
        compiled = [f"`tm_compare_{book.c_name}`" for book in book_codes(plan.spec, source.rules)]
        yield f"- Rulebooks, of which all rules are compiled: {', '.join(compiled) or 'none'}."
    yield ""
    if limits:
        yield "| capacity | default | bounds |"
        yield "|---|---:|---|"
        for name, value in limits.items():
            yield f"| `{name}` | {value} | {CAPACITIES[name][1]} |"
        yield ""
    yield "| rule | spec | values computed, worst case | loops over |"
    yield "|---|---|---:|---|"
    for code in source.rules:
        total, loops = 0, []
        for signals, count in _operations(code.counted.body, ()):
            times = 1
            for name in signals:
                course = plan.courses.get(name)
                if course is not None:
                    times *= course.most(limits["TM_MAX_RATE"], limits["TM_MAX_SAMPLES"])
                else:
                    sequence = plan.spec.signals[name].sequence
                    times *= limits["TM_MAX_SAMPLES" if sequence else "TM_MAX_ELEMENTS"]
            total += times * count
            if signals:
                loops.append(" x ".join(signals) + f" ({times})")
        span = code.rule.span
        yield f"| {code.rule.name} | {span.file.path}:{span.line} | {total} | {', '.join(dict.fromkeys(loops)) or 'nothing'} |"
    yield ""
    if source.supervised is not None:
        yield from _step(source.supervised, limits)
    yield "A rule is computed once, taking everything for known; only where something is not known, a second time with worst and best"
    yield "cases (about twice the values). Geometry adds passes over the segments of a line or border: at most one for each point on a"
    yield "line, two for each point in an area, and 21 for each sweep, of which 18 are of those that leave the area; a sweep along a curve counts"
    yield f"as often as it has pieces, {MOST_PIECES} times at most. Boxes over the segments, and what was near in the last cycle, leave a few segments of"
    yield "each pass in practice."
    yield ""
    yield "| function | cyclomatic complexity |" + (" stack, bytes |" if usage else "")
    yield "|---|---:|" + ("---:|" if usage else "")
    for name, value in complexity(source).items():
        yield f"| `{name}` | {value} |" + (f" {usage.get(name, 'inlined')} |" if usage else "")
    yield ""


def _operations(
    body: Iterable[c.Statement], around: tuple[str, ...]
) -> Iterator[tuple[tuple[str, ...], int]]:
    own = 0
    for item in body:
        own += sum(
            [1 for expr in c.expressions(item) for each in c.within(expr) if isinstance(each, _COMPUTED)]
        )
        if isinstance(item, c.For | c.If):
            yield from _operations(
                item.body, (*around, item.over) if isinstance(item, c.For) and item.over else around
            )
    yield around, own


#: What the report counts as a value computed.
_COMPUTED = (c.Call, c.Unary, c.Binary, c.Conditional, c.Element)
