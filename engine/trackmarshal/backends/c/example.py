"""What comes with the generated code: an example program of one cycle, and a build file."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.backends.c.layout import Input
from trackmarshal.backends.c.names import comment, distinct
from trackmarshal.backends.c.places import _bordered, _setters, sources
from trackmarshal.backends.c.source import Source
from trackmarshal.ir.spec import FieldType
from trackmarshal.runtime.contract import IS_EMERGENCY

#: Samples of the example's timelines; its sets have one element.
SAMPLES = 8


def main_c(source: Source) -> str:
    """A program that checks one cycle of constant data and prints the verdicts."""
    return "\n".join([*_main(source), ""])


def _main(source: Source) -> Iterator[str]:
    plan = source.plan
    yield "/* One cycle with constant data: replace the numbers by those of the planner and of perception. */"
    yield f'#include "{source.name}.h"'
    yield ""
    yield "#include <stdio.h>"
    yield ""
    columns = [
        (item, info) for item in plan.inputs.values() if item.kind == "columns" for info, _ in item.fields
    ]
    # What stands beside them in the program is one word, but for one.
    arrays = distinct((f"{item.name}.{info.name}" for item, info in columns), ["out_emergency"])
    for item, info in columns:
        yield from _column(item, info, arrays[f"{item.name}.{info.name}"])
    given = sources(plan)
    if any(_bordered(plan, name) for name in given):
        yield "static const double left[4] = {-100.0, 6.0, 100.0, 6.0}; /* m: x, y by turns */"
        yield "static const double right[4] = {-100.0, -6.0, 100.0, -6.0};"
    if any(not _bordered(plan, name) for name in given):
        yield "static const double line[4] = {-100.0, 0.0, 100.0, 0.0}; /* m: x, y by turns */"
    yield "static tm_context context; /* too large for many a stack */"
    yield ""
    yield "int main(void)"
    yield "{"
    yield f"  static const char *const verdicts[5] = {{{', '.join(_quoted(v) for v in ('satisfied', 'violated', 'undefined', 'inactive', 'open'))}}};"
    yield f"  static const char *const rules[TM_RULES] = {{{', '.join(_quoted(code.rule.name) for code in source.rules)}}};"
    yield "  tm_input in;"
    yield "  tm_output out;"
    if source.doored:
        yield "  tm_input emergency;"
        yield "  tm_output out_emergency;"
        yield "  const tm_stamp stamp = {1, 0.0, 0.0};"
        yield "  tm_fault fault;"
    yield '  if (tm_init(&context) != TM_OK) { (void)puts("a table or place of the spec is unusable"); }'
    names = _setters(plan)
    for name in given:
        args = "left, 2u, right, 2u" if _bordered(plan, name) else "line, 2u"
        closed = ", false" if _bordered(plan, name) else ""
        unusable = f'(void)puts("{comment(name)} is unusable");'
        if source.doored:
            admit = names[name].replace("tm_set_", "tm_admit_", 1)
            yield f"  if (!{admit}(&context, {args}, &fault)) {{ {unusable} }}"
        yield f"  if ({names[name]}(&context, {args}{closed}) != TM_OK) {{ {unusable} }}"
    for item in plan.inputs.values():
        yield from _assignments(item, arrays)
    if not plan.inputs:
        yield "  in.unused = 0;"
    if source.doored:
        yield "  emergency = in;"
        if IS_EMERGENCY in plan.inputs:
            yield f"  emergency.{plan.input(IS_EMERGENCY).c_name} = TM_TRUE;"
        yield "  if (!tm_admit(&context, &stamp, &in, &emergency, &fault)) {"
        yield '    (void)printf("refused: fault %d of %s.%s\\n", (int)fault.name, fault.signal, fault.field);'
        yield "    return 1;"
        yield "  }"
        yield "  if (tm_check_both(&context, &in, &emergency, &out, &out_emergency) != TM_OK) {"
    else:
        yield "  if (tm_check(&context, &in, &out) != TM_OK) {"
    yield '    (void)puts("the input does not fit");'
    yield "    return 1;"
    yield "  }"
    yield "  for (size_t i = 0u; i < TM_RULES; ++i) {"
    yield '    (void)printf("%-24s %-10s %g\\n", rules[i], verdicts[out.rule[i].verdict], out.rule[i].margin);'
    yield "  }"
    yield "  return 0;"
    yield "}"


def _quoted(text: str) -> str:
    return '"' + comment(text).replace('"', "'") + '"'


def _column(item: Input, info: FieldType, array: str) -> Iterator[str]:
    assert item.signal is not None
    name = info.name
    count = SAMPLES if item.signal.sequence else 1
    if info.kind == "bool":
        yield f"static const tm_flag {array}[{count}] = {{{', '.join(['TM_TRUE'] * count)}}};"
        return
    step = 0.1 if info.increasing else 0.5 if item.signal.sequence and name in ("x", "s") else 0.0
    start = (
        info.default
        if info.default is not None
        else 1.0
        if name in ("length", "width", "grip")
        else 30.0
        if not item.signal.sequence and name == "x"
        else 0.0
    )
    values = ", ".join(repr(round(start + step * k, 6)) for k in range(count))
    yield f"static const double {array}[{count}] = {{{values}}};"


def _assignments(item: Input, arrays: dict[str, str]) -> Iterator[str]:
    if item.kind == "event":
        yield f"  in.{item.c_name} = TM_FALSE;"
        return
    assert item.signal is not None
    if item.kind == "columns":
        yield f"  in.{item.c_name}.count = {SAMPLES if item.signal.sequence else 1}u;"
        for info, c_name in item.fields:
            yield f"  in.{item.c_name}.{c_name} = {arrays[f'{item.name}.{info.name}']};"
        return
    for info, c_name in item.fields:
        yield f"  in.{item.c_name}.{c_name} = {'TM_TRUE' if info.kind == 'bool' else '0.0'};"
    if not item.fields:
        yield f"  in.{item.c_name}.unused = 0;"


def cmake(source: Source) -> str:
    """A build file with the flags that keep arithmetic as it is written."""
    name = source.name
    flags = "-Wall -Wextra -Wconversion -pedantic -ffp-contract=off -fno-fast-math"
    return f"""cmake_minimum_required(VERSION 3.13)
project({name} C)
set(CMAKE_C_STANDARD 99)
set(CMAKE_C_STANDARD_REQUIRED ON)
set(CMAKE_C_EXTENSIONS OFF)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
# Fused or re-associated arithmetic would give other margins than the spec's other evaluators.
add_compile_options({flags})
add_library({name} STATIC {name}.c)
target_include_directories({name} PUBLIC ${{CMAKE_CURRENT_SOURCE_DIR}})
target_link_libraries({name} PUBLIC m)
add_executable({name}_example main.c)
target_link_libraries({name}_example PRIVATE {name})
"""
