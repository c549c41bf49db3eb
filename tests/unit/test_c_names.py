"""Names of specs in generated C: whatever they are, it compiles without a warning and means the same."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from support.agreement import compiled, outcomes
from support.length import amount
from trackmarshal.backends.c import build
from trackmarshal.backends.c.example import example
from trackmarshal.backends.c.monitoring import Monitors
from trackmarshal.backends.c.names import distinct, identifier
from trackmarshal.backends.c.program import CProgram
from trackmarshal.backends.c.source import generate
from trackmarshal.backends.c.supervised.contract import unfit
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.semantics.expressions.calls import built_in_names
from trackmarshal.syntax.keywords import RESERVED

needs_compiler = pytest.mark.skipif(build.compiler() is None, reason="no C compiler")
STRICT = [
    "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror", "-ffp-contract=off", "-fsyntax-only",
]  # fmt: skip
#: Keywords, macros of the headers, names of functions and of our own code, and names that look like the generator's.
AWKWARD = (
    "NULL", "INFINITY", "NAN", "HUGE_VAL", "DBL_MAX", "FLT_RADIX", "INT64_MAX", "SIZE_MAX", "M_PI", "EOF", "T", "I",
    "signed", "register", "inline", "int", "double", "size_t", "bool", "true_", "isnan", "isfinite", "signbit", "errno", "unix",
    "linux", "sin", "sqrt", "fabs", "rint", "main", "template", "class", "count", "unused", "TM_TRUE", "TM_RULES", "TM_INF",
    "tm_min", "tm_least", "atm_least", "tm_context", "tm_check", "m0", "n1", "n2", "n3", "s1", "s4", "m4", "d5", "k6", "x_2", "x",
    "_x", "_Bool", "__FILE__", "__linux__", "in", "out", "c", "m", "done", "verdict", "finished", "result", "flow", "stream", "queue",
    "stack", "given", "worst_sat", "table", "limits", "rule", "context", "monitor", "have", "sample", "known", "holds", "all", "some",
    "applies", "guard", "left", "right", "windows", "value", "value_2", "y0", "gamma", "signgam", "double_t", "ego_x", "p_u",
)  # fmt: skip
#: Those that a spec may use.
FIELDS = [name for name in AWKWARD if name not in RESERVED]


def compile_strictly(spec: Spec, folder: Path, name: str = "made") -> CProgram:
    rules = Evaluator(spec, None, "reference").rules
    source = generate(spec, rules, name, online=True, doored=not unfit(spec))
    (folder / f"{name}.h").write_text(source.header, encoding="utf-8")
    (folder / f"{name}.c").write_text(source.source, encoding="utf-8")
    files = {file: text for file, text in example(source).items() if file != "CMakeLists.txt"}
    for file, text in files.items():
        (folder / file).write_text(text, encoding="utf-8")
    programs = [file for file in files if file.endswith(".c")]
    for compiler in ("gcc", "clang"):
        for standard in amount(("-std=c99",), ("-std=c99", "-std=gnu11")):
            if shutil.which(compiler):
                command = [compiler, *STRICT, standard, f"{name}.c", *programs]
                done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
                assert done.returncode == 0, done.stderr[:3000]
    program = CProgram(spec, rules)
    program.library_for()
    return program


def agree(spec: Spec, program: CProgram, *raw: dict[str, object]) -> None:
    reference = Evaluator(spec, None, "reference")
    cases = [reference.read({"signals": signals}) for signals in raw]
    run = outcomes(program, cases)
    for index, expected in enumerate(reference.evaluate(cases)):
        for rule in reference.rules:
            wanted = expected.rules[rule.name]
            assert run[index][rule.name] == (wanted.verdict, wanted.margin), rule.name


@needs_compiler
def test_fields(tmp_path: Path) -> None:
    fields = ", ".join(f"{name}: 1" for name in FIELDS)
    total, sample = (" + ".join(f"{n}.{name}" for name in FIELDS) for n in ("ego", "p"))
    spec = compiled(f"""module names
signal ego : state {{ {fields} }}
signal plan : series {{ t: s increasing, {fields} }}
rule sum "made up"
  require {total} <= 1
rule samples "made up"
  for all p in plan
  require {sample} <= 1
rule back "made up"
  along plan as p
  require historically[0 s, 1 s] {sample} <= 1
""")
    program = compile_strictly(spec, tmp_path)
    numbers = {name: 0.25 * k - 9.0 for k, name in enumerate(FIELDS)}
    columns = {name: [number, number + 1.0] for name, number in numbers.items()}
    agree(spec, program, {"ego": numbers, "plan": {"t": [0.0, 0.5], **columns}})
    monitors = Monitors(spec, spec.rules)
    assert monitors.names == ("back",)
    _, (verdict, _) = monitors.run("back", {"t": [0.0, 0.5], **columns})
    assert (
        verdict
        == Evaluator(spec, ["back"], "reference")
        .evaluate([Evaluator(spec).read({"signals": {"ego": numbers, "plan": {"t": [0.0, 0.5], **columns}}})])
        .__next__()
        .rules["back"]
        .verdict
    )


@needs_compiler
def test_signals_events_params_tables_and_rules(tmp_path: Path) -> None:
    lines, given, terms = ["module names"], dict[str, Any](), list[str]()
    for k, name in enumerate(FIELDS):
        kind = k % 4 if name not in built_in_names() else 0
        if kind == 0:
            lines.append(f"signal {name} : state {{ v: 1 }}")
            given[name] = {"v": float(k)}
            terms.append(f"{name}.v")
        elif kind == 1:
            lines.append(f"param {name} : 1 = {k}")
            terms.append(name)
        elif kind == 2:
            lines.append(f"table {name}(u: 1) -> 1 = linear clamp | 0: 1 | 1: {k + 2} |")
            terms.append(f"{name}(0.5)")
        else:
            lines.append(f'event {name} "made up"')
            given[name] = bool(k % 8 == 3)
            terms.append(f"(if {name} then 1 else 2)")
    lines.append(f'rule all_of_them "made up"\n  require {" + ".join(terms)} <= 1000\n')
    lines.append("signal trace : series { t: s increasing, u: 1 }")
    for name in FIELDS:
        lines.append(f'rule r{name} "made up"\n  require {terms[0]} <= 1\n')
    spec = compiled("\n".join(lines))
    program = compile_strictly(spec, tmp_path)
    given["trace"] = {"t": [0.0], "u": [1.0]}
    agree(spec, program, given)


@pytest.mark.acceptance  # names of declarations every day
@needs_compiler
def test_variables_lets_definitions_and_their_arguments(tmp_path: Path) -> None:
    """What is bound in a rule names locals of its functions, each beside the others."""
    names = [name for name in FIELDS if name not in built_in_names()]
    text = "module names\nsignal trace : series { t: s increasing, u: 1 }\nparam k : 1 = 2\n"
    for n, name in enumerate(names):
        text += f"define twice_{n}({name}: 1) -> 1 = {name} * 2 + abs({name})\n"
        text += f"define {name}_(a: 1) -> 1 = a * a + k\n"
        text += f'rule v{n} "made up"\n  for all {name} in trace\n  let {name}_2 = {name}.u + k\n'
        text += f"  require {name}_2 * {name}_({name}_2 - 1) + {name}_({name}.u) <= twice_{n}({name}_2 / 3) + {n}\n"
        text += f'rule l{n} "made up"\n  for all p in trace\n  let {name} = p.u - k\n  require {name} / k <= {name} * {name}\n'
        text += f'rule a{n} "made up"\n  along trace as {name}\n  require once[0 s, 1 s] {name}.u * {name}.u > {n}\n'
    spec = compiled(text)
    program = compile_strictly(spec, tmp_path)
    agree(spec, program, {"trace": {"t": [0.0, 0.5, 3.0], "u": [1.0, -7.0, 4.0]}})


@pytest.mark.acceptance  # names of rules among others every day
@needs_compiler
def test_rules(tmp_path: Path) -> None:
    """Also those that are called as functions of ours, as another rule's function, or as another but for its capitals."""
    names = [*FIELDS, "x_known", "x_any", "x_along", "x_start", "X_known", "rest", "rest_", "edge", "least", "size", "back", "Slow", "slow", "SLOW"]  # fmt: skip
    text = "module names\nsignal trace : series { t: s increasing, u: 1 }\n"
    for k, name in enumerate(names):
        text += f'rule {name} "tm_lookup */ tm_held(tm_least)"\n  along trace as p\n  require once[0 s, {k} s] p.u > {k}\n'
    spec = compiled(text)
    program = compile_strictly(spec, tmp_path)
    trace = {"t": [0.0, 0.5, 1.0, 9.0], "u": [1.0, 30.0, 2.0, 50.0]}
    agree(spec, program, {"trace": trace})
    monitors = Monitors(spec, spec.rules)
    assert set(monitors.names) == set(names)
    case = Evaluator(spec).read({"signals": {"trace": trace}})
    expected = next(iter(Evaluator(spec, None, "reference").evaluate([case])))
    for name in names:
        assert monitors.run(name, trace)[1] == (expected.rules[name].verdict, expected.rules[name].margin)


@needs_compiler
def test_places_and_lines(tmp_path: Path) -> None:
    """Shapes, the functions that set them, and what the door remembers of them."""
    lines = ["t", "number", "line", "table", "count", "stamp", "limits", "NULL", "track_left", "a_b", "A_B"]
    text = """module names
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal track : corridor { left: polyline, right: polyline }
"""
    spoken = [name for name in lines if name not in ("line", "table")]
    text += "".join(f"signal {name} : polyline\n" for name in spoken)
    text += "zone isnan = polygon (0 m, 0 m) (9 m, 0 m) (9 m, 9 m)\nzone ISNAN = polygon (0 m, 0 m) (5 m, 0 m) (5 m, 9 m)\n"
    text += 'rule left "made up"\n  for all p in plan\n  require distance_to(p, track.left) <= 3 m\n'
    for k, name in enumerate(spoken):
        text += f'rule r{k} "made up"\n  for all p in plan\n  require distance_to(p, {name}) <= {k} m\n'
    text += 'rule z "made up"\n  for all p in plan\n  require p in zone isnan or p in zone ISNAN\n'
    spec = compiled(text)
    assert not unfit(spec)
    program = compile_strictly(spec, tmp_path)
    columns = {"x": [1.0, 6.0], "y": [0.5, 0.5], "heading": [0.0, 0.0], "v": [1.0, 1.0]}
    ego = {"x": 1.0, "y": 0.5, "heading": 0.0, "v": 1.0}
    given = {name: [[0.0, -0.5 * k], [9.0, -0.5 * k]] for k, name in enumerate(spoken)}
    track = {"left": [[0.0, 2.0], [9.0, 2.0]], "right": [[0.0, -2.0], [9.0, -2.0]], "closed": False}
    agree(spec, program, {"plan": {"t": [0.0, 1.0], **columns}, "ego": ego, "track": track, **given})


@needs_compiler
def test_arrays_of_the_example_are_told_apart(tmp_path: Path) -> None:
    spec = compiled("""module names
signal a : set of object { b_c: 1 }
signal a_b : set of object { c: 1 }
signal out : set of object { emergency: 1 }
rule r "made up"
  for all p in a
  require for all q in a_b: (for all z in out: (p.b_c <= q.c + z.emergency))
""")
    compile_strictly(spec, tmp_path)


def test_identifiers() -> None:
    assert [identifier(name) for name in ("kappa", "vehicles.devbot.mass", "x0", "κ")] == [
        "kappa", "vehicles_devbot_mass", "x0", "u3ba",
    ]  # fmt: skip
    for name in AWKWARD:
        made = identifier(name)
        assert made.isidentifier()
        assert made.isascii()
        assert not made.startswith("_")
        assert not made.isupper() or made.endswith("_")
    assert [*distinct(["a", "A", "a.b", "a_b", "A_B"]).values()] == ["a", "A_", "a_b", "a_b_2", "A_B_"]
