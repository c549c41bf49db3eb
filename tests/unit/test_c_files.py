"""What `compile --target c` writes: clean under strict compilers and sanitizers, documented, refusing what it cannot say."""

from __future__ import annotations

import ctypes
import hashlib
import json
import os
import platform
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from support.agreement import outcomes
from support.emitted import SCENARIOS, emit, name_of
from support.length import AT_LENGTH, amount, at_length
from support.sanitized import FLAGS as SANITIZED
from support.shared import SUPERVISOR
from support.supervised import shipped
from trackmarshal.backends.c import build
from trackmarshal.backends.c.calls import inexact
from trackmarshal.backends.c.cycles import digest
from trackmarshal.backends.c.program import CProgram
from trackmarshal.backends.c.report import complexity, context_bytes, libm, report
from trackmarshal.backends.c.source import Source, generate
from trackmarshal.backends.results import chosen_rules
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import CHUNK, Evaluator, loads
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo, Spec

needs_compiler = pytest.mark.skipif(build.compiler() is None, reason="no C compiler")
STRICT = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffp-contract=off"]


@cache
def spec() -> Spec:
    return shipped()


@cache
def source() -> Source:
    return generate(spec(), chosen_rules(spec(), None))


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The shipped Supervisor, with the cycles of one scenario."""
    return emit(tmp_path_factory.mktemp("compiled"), recordings=[SCENARIOS[0]], stack=AT_LENGTH)


CYCLES = f"{name_of(SCENARIOS[0])}.cycles"
#: Files that are written for a whole Supervisor.
FILES = {"supervisor.c", "supervisor.h", "main.c", "cycles.c", "cycles.h", "CMakeLists.txt", "report.md"}


def test_files(written: Path) -> None:
    assert {path.name for path in written.iterdir()} == FILES | {CYCLES}


@pytest.mark.parametrize("compiler", [at_length("gcc"), "clang"])
def test_clean_and_sanitized(written: Path, compiler: str) -> None:
    """Every day, gcc makes the same in test_c_example.py."""
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    program = written.parent / f"example_{compiler}"
    sources = sorted(name for name in FILES if name.endswith(".c"))
    command = [compiler, *STRICT, *SANITIZED, *sources, "-o", str(program), "-lm"]
    done = subprocess.run(command, cwd=written, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    runs_from_cycles(program, written)


def runs_from_cycles(program: Path, written: Path) -> None:
    """From a file, and from standard input."""
    ran = subprocess.run([str(program), CYCLES], cwd=written, capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stderr) == (0, "")
    decided = [line for line in ran.stdout.splitlines() if line.startswith("decision ")]
    assert len(decided) > 90
    assert decided[0].startswith("decision drive safe driving 0 ")
    with (written / CYCLES).open(encoding="utf-8") as file:
        again = subprocess.run([str(program)], stdin=file, capture_output=True, text=True, check=False)
    assert again.stdout == ran.stdout


HOST = """
#include <cstdio>
#include <cstring>
#include "supervisor.h"
#include "cycles.h"
#include "client.h"
#include "desk.h"
#include "executing.h"

static tm_context context;
static tm_decision decision;
static tm_configuration configuration;

static double clock_of(void *user) { return *static_cast<double *>(user); }

int main(int, char **argv) {
  tm_cycle cycle;
  double finished = 0.0;
  if (tm_init(&context) != TM_OK) { return 1; }
  tm_defaults(&configuration);
  configuration.limits.longest_gap = 0.3;  // and rules look no further than before
  if (tm_configure(&context, &configuration).status != TM_BAD_LIMIT) { return 2; }
  if (std::strcmp(tm_configure(&context, &configuration).which, "longest_gap") != 0) { return 3; }
  configuration.params.supervisor_limits_longest_gap = 0.3;
  if (tm_configure(&context, &configuration).status != TM_BAD_CONSTRAINT) { return 4; }
  cycles_open(argv[1], &configuration);
  if (tm_configure(&context, &configuration).status != TM_OK) { return 1; }
  while (cycles_next(&cycle, &finished)) {
    tm_step(&context, &cycle, clock_of, &finished, &decision);
    std::printf("%d\\n", decision.safe ? 1 : 0);
  }
  tm_defaults(&configuration);
  if (tm_configure(&context, &configuration).status != TM_OK) { return 5; }
  configuration.limits.longest_gap = 100.0;  // what is refused is not what the stored trajectory is held to
  if (tm_configure(&context, &configuration).status != TM_BAD_LIMIT) { return 6; }
  cycle.came = false;
  cycle.now = finished;
  tm_step(&context, &cycle, clock_of, &finished, &decision);
  if (decision.driven != TM_DRIVE_STORED || decision.valid_until != finished + 0.15) { return 7; }
  return (tml_length(0u) == 0u) ? 0 : 1;
}
"""


@pytest.mark.skipif(shutil.which("gcc") is None or shutil.which("g++") is None, reason="no gcc or g++")
def test_a_host_in_cpp(tmp_path: Path) -> None:
    """Headers are for both languages; what is generated stays C."""
    folder = emit(tmp_path / "out", "--process", recordings=[SCENARIOS[0]])
    (folder / "host.cpp").write_text(HOST, encoding="utf-8")
    units = ["supervisor", "cycles", "messages"]
    for command in (
        ["gcc", "-std=c99", "-ffp-contract=off", "-c", *(f"{name}.c" for name in units)],
        ["g++", "-std=c++11", *STRICT[1:], "-c", "host.cpp"],
        ["g++", "host.o", *(f"{name}.o" for name in units), "-o", "host", "-lm"],
    ):
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")
    ran = subprocess.run(
        [str(folder / "host"), CYCLES], cwd=folder, capture_output=True, text=True, check=False
    )
    assert (ran.returncode, ran.stderr) == (0, "")
    assert set(ran.stdout.split()) == {"0", "1"}


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_rules_alone_come_with_constant_data(tmp_path: Path, compiler: str) -> None:
    """What cannot be supervised with gets an example of one input."""
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    text = (
        'module alone\n\nsignal gap : state { ahead: m, closing: m/s }\nevent raining "it rains"\n\n'
        'rule apart "Stay apart"\n  satisfies R-1\n  require gap.ahead > 2 m\n\n'
        'rule slow "Close in slowly in the rain"\n  satisfies R-1\n  whenever raining\n  require gap.closing < 3 m/s\n'
    )
    spec = tmp_path / "alone.spec"
    spec.write_text(text, encoding="utf-8")
    folder = emit(tmp_path / "out", spec=spec, recordings=[])
    assert {path.name for path in folder.iterdir()} == FILES - {"cycles.c", "cycles.h"}
    command = [compiler, *STRICT, "supervisor.c", "main.c", "-o", "example", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    ran = subprocess.run([str(folder / "example")], capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert [line.split()[:2] for line in ran.stdout.splitlines()] == [
        ["apart", "violated"],
        ["slow", "inactive"],
    ]
    with pytest.raises(TrackmarshalError, match="takes no cycles") as caught:
        emit(tmp_path / "more", spec=spec, recordings=[elsewhere(tmp_path)])
    assert caught.value.code == "E475"


def elsewhere(folder: Path) -> Path:
    """A scenario that names no track."""
    path = folder / "elsewhere.tmrec.jsonl"
    lines = (SCENARIOS[0].parent / "cut_in.tmrec.jsonl").read_text(encoding="utf-8").splitlines()
    head = {key: value for key, value in json.loads(lines[0]).items() if key != "use"}
    path.write_text("\n".join([json.dumps(head), *lines[1:], ""]), encoding="utf-8")
    return path


def test_recordings_that_do_not_go_together_are_refused(tmp_path: Path) -> None:
    with pytest.raises(TrackmarshalError, match="not of the same vehicle and track") as caught:
        emit(tmp_path / "out", recordings=[SCENARIOS[0], elsewhere(tmp_path)])
    assert caught.value.code == "E475"
    with pytest.raises(TrackmarshalError, match="two recordings have the name") as caught:
        emit(tmp_path / "out", recordings=[SCENARIOS[0], SCENARIOS[0]])
    assert caught.value.code == "E475"


def test_above_every_rule_stands_what_the_spec_says_and_where() -> None:
    for code in source().rules:
        head = code.text.partition("*/")[0]
        assert f"{code.rule.span.file.path}:{code.rule.span.line};" in head
        for line in code.rule.text.splitlines():
            assert " ".join(line.split()) in " ".join(head.split()), code.rule.name


def test_rules_read_like_the_spec() -> None:
    """Names of the spec, whole expressions, and the place in the spec where it changes."""
    text = next(code.text for code in source().rules if code.rule.name == "friction")
    body = text[text.index("{") :]
    for line in (
        "const double mass = context->params.vehicles_devbot_mass;",
        "for (size_t p = 0u; p < in->plan.count; ++p) {",
        "const double p_v_squared = tm_square(in->plan.v[p]);",
        "tm_for_all_any(&all, tm_at_most_any(left, mu * in->plan.grip[p] * mass * g));",
    ):
        assert line in body
    assert re.findall(r"/\* (.*?) \*/", body) == [f"line {line_of('mass * sqrt(')}"]
    assert not re.search(
        r"\b[a-z]{1,2}\d+\b",
        re.sub(r"/\*.*?\*/", "", source().source[source().source.index("tm_rule_") :], flags=re.DOTALL),
    )


def line_of(text: str) -> int:
    """The line of the shipped rules about the trajectory in which a text stands."""
    lines = (SUPERVISOR / "trajectory.spec").read_text(encoding="utf-8").splitlines()
    return 1 + next(number for number, line in enumerate(lines) if text in line)


def test_header_gives_units() -> None:
    header = source().header
    assert re.search(r"const double \*kappa; /\* 1/m", header)
    assert re.search(r"double vehicles_devbot_mass; /\* kg", header)


def test_no_allocation_recursion_or_global_state() -> None:
    code = re.sub(r"/\*.*?\*/", "", source().source, flags=re.DOTALL)
    assert not re.search(r"\b(malloc|calloc|realloc|free|alloca|fmin|fmax)\b", code)
    assert not [line for line in code.splitlines() if re.match(r"static (?!const)[^(]*;", line)]
    bodies = re.split(r"^(?=\S[^;]*\{|\S.*\)\n\{)", code, flags=re.MULTILINE)
    assert len(bodies) > 50
    for body in bodies:
        name = re.search(r"\b(tm_\w+)\(", body)
        if name is not None:
            assert body.count(f"{name.group(1)}(") == 1, name.group(1)


def test_report_knows_libm_and_complexity() -> None:
    assert {"sqrt", "fabs", "sin", "cos"} <= set(libm(source()))
    assert "pow" not in libm(source())
    values = complexity(source())
    assert values["tm_check"] >= 1
    assert values["tm_timeline_inside"] > 10


def test_what_is_exact_in_every_c_library_is_no_reason_for_other_digits() -> None:
    """`round` is `rint`, a table that repeats is read by `fmod`, and a rule with a deadline asks `isnan`: docs/language.md says that none of these differs."""
    exact = loads("""
module exact
signal e : state { a: 1, m: m }
table laps(m: m) -> m = linear wrap 100 m
  | 0 m: 1 m | 50 m: 2 m |
rule rounded "Round"
  require round(e.a) <= 3
rule wrapped "Wrap"
  require laps(e.m) <= 1.5 m
rule due "Within a time"
  whenever e.a > 1
  within 2 s
  require e.m > 1 m
rule grown "The C library's own"
  require exp(e.a) <= 3
""")
    generated = generate(exact, chosen_rules(exact, None))
    assert inexact(generated) == {"grown": ["exp"]}
    assert {"rint", "fmod", "exp"} <= set(libm(generated))


@needs_compiler
def test_report_says_what_an_integrator_asks(written: Path) -> None:
    text = (written / "report.md").read_text(encoding="utf-8")
    assert re.search(r"^- Context: \d{6} bytes\.$", text, re.MULTILINE)
    assert re.search(r"^- libm: .*sqrt.*remainder\.$", text, re.MULTILINE)
    assert re.search(
        r"^- Margins whose last .*: .*contact \(cos, sin\).*heading_integrity", text, re.MULTILINE
    )
    assert re.search(r"^\| friction \| .*trajectory\.spec:\d+ \| \d+ \| plan \(128\) \|$", text, re.MULTILINE)
    pieces = re.search(r"#define TM_PIECES (\d+)u", (written / "supervisor.h").read_text(encoding="utf-8"))
    assert pieces is not None
    assert f"as often as it has pieces, {pieces.group(1)} times at most" in text
    if AT_LENGTH and shutil.which("gcc") is not None:
        stack = re.search(r"^- Stack: at most (\d+) bytes, .*`tm_\w+` > `tm_\w+`", text, re.MULTILINE)
        assert stack is not None
        assert int(stack.group(1)) > 1000


@needs_compiler
def test_the_report_says_the_bytes_that_a_host_takes() -> None:
    """They are asked of the header; the compiled program says the same of its context and monitors. What no compiler takes is refused all the same."""
    spec = loads(
        "module m\nsignal ego : state { v: m/s }\nsignal log : series { t: s increasing, v: m/s }\n"
        'rule apart "" require ego.v < 9 m/s\n'
        'rule slow "" along log as p require always p.v <= 9 m/s\n'
        'rule later "" along log as p require always[0 s, 2 s] eventually[0 s, 1 s] p.v <= 9 m/s\n'
    )
    made = generate(spec, list(spec.rules), online=True)
    assert [monitor.rule.name for monitor in made.monitors] == ["slow", "later"]
    dll = ctypes.CDLL(str(build.library(made, {})))
    for function in (dll.tmg_size, dll.tmg_online_size):
        function.restype = ctypes.c_size_t
    sizes = [dll.tmg_online_size(ctypes.c_size_t(place)) for place in range(2)]
    assert len({dll.tmg_size(), *sizes}) == 3
    assert context_bytes(made) == (dll.tmg_size(), sizes)
    with pytest.raises(TrackmarshalError, match="nothing") as caught:
        context_bytes(
            replace(made, source=f"{made.source}\nint nothing(void) {{ return nothing_of_that_name; }}\n")
        )
    assert caught.value.code == "E472"


def test_the_report_counts_the_borders_of_lanes(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are looked at, and prepared, where they are new, as those of a track are: the report had none of them."""
    spec = loads(
        "module m\nsignal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }\n"
        "signal ego : state { x: m, y: m, heading: rad }\nsignal lanes : set of lane { left: polyline, right: polyline }\n"
        'rule kept "" require exists l in lanes: (footprint(ego, 4 m, 2 m) inside l)\n'
    )
    for name in ("context_bytes", "stack"):
        monkeypatch.setattr(f"trackmarshal.backends.c.report.{name}", lambda _: None)
    text = report(generate(spec, list(spec.rules), doored=True))
    numbers = 32 * 2 * 2048 * 2  # lanes, borders, points, x and y
    assert re.search(rf"^\| door: points of borders .* \| {numbers} \|$", text, re.MULTILINE)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_the_report_says_how_much_stack_is_taken(tmp_path: Path) -> None:
    small = tmp_path / "small.spec"
    small.write_text(
        'module small\nsignal ego : state { v: m/s }\nrule slow "Slow"\n  require ego.v <= 3 m/s\n', "utf-8"
    )
    text = (emit(tmp_path / "c", recordings=[], spec=small, stack=True) / "report.md").read_text("utf-8")
    assert re.search(r"^- Stack: at most [1-9]\d* bytes, .*`tm_\w+`\)\.$", text, re.MULTILINE)


def test_unknown_nodes_are_an_error_of_ours_and_no_reason_to_choose_another_backend() -> None:
    class Sorcery(ir.IR):
        """A node that no backend knows."""

    rule = next(r for r in spec().rules if r.name == "friction")
    values: list[Any] = [
        Sorcery() if name == "formula" else None if name == "active" else getattr(rule, name)
        for name in RuleInfo.fields
    ]
    changed = RuleInfo(*values)
    with pytest.raises(AssertionError, match="Sorcery"):
        generate(spec(), [changed])


def test_without_a_compiler(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path))
    monkeypatch.setenv("CC", "no-such-compiler-here")
    with pytest.raises(TrackmarshalError) as caught:
        CProgram(spec(), [r for r in spec().rules if r.name == "friction"]).library_for()
    assert caught.value.code == "E471"
    assert not list((tmp_path / "c").rglob("*.so"))


def one_rule(name: str = "turn_radius") -> CProgram:
    return CProgram(spec(), [rule for rule in spec().rules if rule.name == name])


@needs_compiler
@pytest.mark.parametrize("spoil", ["cut", "flip", "empty"])
def test_a_spoilt_cache_entry_is_built_anew(
    spoil: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path))
    kept = build.library(one_rule().source, {})
    content = kept.read_bytes()
    spoilt = {"cut": content[: len(content) // 2], "flip": content[:-9] + b"?" + content[-8:], "empty": b""}[
        spoil
    ]
    kept.unlink()
    kept.write_bytes(spoilt)
    again = build.library(one_rule().source, {})
    assert again.read_bytes() not in (spoilt, b"")
    assert again.stem.rpartition("-")[2] == hashlib.sha256(again.read_bytes()).hexdigest()[:32]
    assert build.library(one_rule().source, {}) == again
    assert one_rule().library_for().status == 0


@needs_compiler
def test_an_entry_is_compiled_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path))
    first = build.library(one_rule().source, {})
    monkeypatch.setattr(build, "_compile", None)  # whoever calls it fails
    assert build.library(one_rule().source, {}) == first


@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="elsewhere, a processor has programs of one kind"
)
def test_what_another_python_cannot_load_is_kept_apart(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Of 32 bits beside 64, or of musl beside glibc (a container with the same home): what the one had built, the other took, and did not load."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path))
    monkeypatch.setattr(build, "_compile", lambda files, units, flags, root, name, *_: name)
    names = []
    for kind in (
        "x86_64-linux-gnu",
        "i386-linux-gnu",
        "x86_64-linux-musl",
        "aarch64-linux-musl",
        "arm-linux-gnueabihf",
    ):
        monkeypatch.setattr(sys.implementation, "_multiarch", kind, raising=False)  # not every Python says it
        names.append(build.library(one_rule().source, {}))
    assert len(set(names)) == 5


PROCESSOR = "processor\t: {n}\nmodel name\t: one\nflags\t\t: fpu {more}\nbogomips\t: {n}\n\n"
WITHOUT, WITH = PROCESSOR.format(n=1, more="sse2 fma avx"), PROCESSOR.format(n=2, more="sse2 fma avx avx2")


def test_what_another_processor_cannot_run_is_kept_apart(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Of a cache that machines share, each takes what was built for the likes of it."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path))
    told = tmp_path / "cpuinfo"
    monkeypatch.setattr(build, "PROCESSORS", told)
    monkeypatch.setattr(build, "_compile", lambda files, units, flags, root, name, *_: (name, flags))
    names, flagged = {}, set()
    for what, text in {
        "with": WITH, "with, and without": WITH + WITHOUT, "without": WITHOUT, "without, and with": WITHOUT + WITH,
        "arm": "processor\t: 0\nFeatures\t: fp asimd\n\n", "empty": "", "absent": None,
    }.items():  # fmt: skip
        told.unlink(missing_ok=True)
        if text is not None:
            told.write_text(text)
        built: Any = build.library(one_rule().source, {})
        names[what] = built[0]
        if any(flag.startswith("-m") for flag in built[1]):
            flagged.add(what)
    assert flagged == {"with", "with, and without"}
    assert len({names[what] for what in flagged}) == 1
    assert len({names[what] for what in names.keys() - flagged}) == 1
    assert len(set(names.values())) == 2


@needs_compiler
@pytest.mark.skipif(platform.machine() != "x86_64", reason="looks for instructions of an x86")
@pytest.mark.parametrize(
    "flags",
    [at_length("-O2 -mavx2"), at_length("-O2 -mfma"), at_length("-O3 -mfma"), at_length("-O3 -march=native")],
)
def test_nothing_is_fused(flags: str, tmp_path: Path) -> None:
    """Digits are those of each operation by itself, whatever a processor could do at once: gcc 12.2 alone took five sums of products for one each."""
    made = source()
    (tmp_path / f"{made.name}.h").write_text(made.header)
    (tmp_path / f"{made.name}.c").write_text(made.source)
    compiler = build.compiler() or []
    command = [*compiler, *build.EXACT, *build.FAST, *flags.split(), "-S", "-o", "-", f"{made.name}.c"]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert len(re.findall(r"\bv?mul[sp]d\b", said)) > 500
    assert not re.findall(r"\bvfn?m(?:add|sub)\w*", said)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
@pytest.mark.skipif(platform.machine() != "x86_64", reason="looks for instructions of an x86")
@pytest.mark.parametrize(
    ("rule", "flags"), [("static_collision", "-mfma4"), at_length("obstacle_collision", "-mavx512f")]
)
def test_nothing_is_fused_where_no_macro_says_fma(rule: str, flags: str, tmp_path: Path) -> None:
    """Processors that fuse by other instructions than FMA3's: gcc 12.2 took pairs of sums of products for one each, as above."""
    made = one_rule(rule).source
    (tmp_path / f"{made.name}.h").write_text(made.header)
    (tmp_path / f"{made.name}.c").write_text(made.source)
    command = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", flags, "-S", "-o", "-", f"{made.name}.c"]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert re.search(r"\bv?mul[sp]d\b", said)
    assert not re.findall(r"\bvfn?m(?:add|sub)\w*", said)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
@pytest.mark.parametrize(
    "flags",
    [
        "-Ofast",
        "-ffast-math",
        "-ffinite-math-only",
        "-funsafe-math-optimizations",
        "-freciprocal-math",
        "-fno-signed-zeros",
        "-mfpmath=387",
    ],
)
def test_arithmetic_of_another_kind_is_refused(flags: str, tmp_path: Path) -> None:
    """With gcc 12.2 and `-O0 -ffast-math`, trajectories with a speed that is NaN were driven as safe."""
    if flags.startswith("-m") and platform.machine() not in ("x86_64", "AMD64"):
        pytest.skip("another machine")
    made = source()
    (tmp_path / f"{made.name}.h").write_text(made.header)
    (tmp_path / f"{made.name}.c").write_text(made.source)
    command = ["gcc", "-std=c99", "-E", flags, f"{made.name}.c"]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert said.returncode != 0
    assert "compile this file with" in said.stderr


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
@pytest.mark.parametrize("macro", ["__DBL_MANT_DIG__=24", "__DBL_MAX_EXP__=128"])
def test_a_double_that_is_a_float_is_refused(macro: str, tmp_path: Path) -> None:
    """As compilers for AVR, RX and SH-4 have it: the bound of a finite number was infinite, and constants had seven digits."""
    made = one_rule("friction").source
    (tmp_path / f"{made.name}.h").write_text(made.header)
    (tmp_path / f"{made.name}.c").write_text(made.source)
    command = ["gcc", "-std=c99", "-E", f"-U{macro.partition('=')[0]}", f"-D{macro}", f"{made.name}.c"]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert said.returncode != 0
    assert "none of IEEE 754 with 64 bits" in said.stderr


BEGINS = """
#include "supervisor.h"
static tm_context context;
int main(void) { return (int)tm_init(&context); }
"""
#: With which flags a whole Supervisor is compiled every day.
A_SUPERVISOR_TOO = ("gcc -O1 -fsingle-precision-constant", "gcc -O0")


@pytest.mark.parametrize(
    ("flags", "status"),
    [
        ("clang -O2 -fno-honor-nans", 4), ("clang -O2 -fassociative-math -fno-signed-zeros -fno-trapping-math", 4), ("clang -O2", 0),
        ("clang -O2 -freciprocal-math", 4), ("clang -O2 -fno-signed-zeros", 4), ("clang -O2 -mfma -ffp-contract=fast", 4),
        ("clang -O2 -mfma -ffp-contract=on", 0), ("gcc -O1 -fsingle-precision-constant", 4), at_length("gcc -O3 -mfma -ffp-contract=fast", 0),
        # gcc tells of them, which is taken back here, so that it is tried where there is no clang.
        at_length("gcc -O2 -freciprocal-math -U__RECIPROCAL_MATH__", 4), at_length("gcc -O2 -fno-signed-zeros -U__NO_SIGNED_ZEROS__", 4),
        ("gcc -O2 -ffinite-math-only -U__FINITE_MATH_ONLY__", 4),
        ("gcc -O2 -fassociative-math -fno-signed-zeros -fno-trapping-math -U__ASSOCIATIVE_MATH__ -U__NO_SIGNED_ZEROS__", 4), ("gcc -O2", 0), ("gcc -O0", 0),
    ],
)  # fmt: skip
def test_arithmetic_of_another_kind_that_no_macro_tells_of(flags: str, status: int, tmp_path: Path) -> None:  # fmt: skip
    """Of rules alone; a Supervisor's configuration is refused likewise, so that it admits no cycle. Both ask one function: every day, a Supervisor is
    compiled with two kinds of flags, of which one is refused."""
    name, *options = flags.split()
    if "-mfma" in options and "fma" not in build._features():
        pytest.skip("this machine does not fuse")
    compiler = shutil.which(name) or shutil.which(f"{name}-14")
    if compiler is None:
        pytest.skip(f"no {name}")
    for doored in (False, True) if AT_LENGTH or flags in A_SUPERVISOR_TOO else (False,):
        made = generate(
            shipped(), [rule for rule in shipped().rules if rule.name == "friction"], doored=doored
        )
        (tmp_path / "supervisor.h").write_text(made.header)
        (tmp_path / "supervisor.c").write_text(made.source)
        (tmp_path / "main.c").write_text(BEGINS)
        command = [compiler, "-std=c99", *options, "supervisor.c", "main.c", "-o", "begins", "-lm"]
        subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
        assert subprocess.run([tmp_path / "begins"], check=False).returncode == status


GOES_ON = """
#include "supervisor.h"
#include <stdio.h>
static tm_context context;
static tm_online_slow monitor;
int main(void) {
  static const double t[1] = {0.0}, v[1] = {3.0};
  tm_sample_slow sample;
  tm_input in;
  tm_output out;
  sample.v = 3.0;
  in.gap.ahead = 9.0;
  in.log.count = 1u;
  in.log.t = t;
  in.log.v = v;
  (void)tm_init(&context);
  const int status = (int)tm_check(&context, &in, &out);
  tm_online_slow_start(&monitor);
  const int pushed = (int)tm_online_slow_push(&context, &monitor, &sample);
  tm_online_slow_finish(&context, &monitor);
  (void)printf("%d %d %d %d", status, (int)out.rule[0].verdict, pushed, (int)monitor.verdict.verdict);
  return 0;
}
"""


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_rules_alone_have_no_verdict_with_arithmetic_of_another_kind(tmp_path: Path) -> None:
    """A host that went on after `tm_init` had them, and so had a monitor. The example blames what is to blame."""
    text = (
        "module alone\n\nsignal gap : state { ahead: m }\nsignal log : series { t: s increasing, v: m/s }\n\n"
        'rule apart "Stay apart"\n  satisfies R-1\n  require gap.ahead > 2 m\n\n'
        'rule slow "Stay slow"\n  satisfies R-1\n  along log as p\n  require always (p.v <= 9 m/s)\n'
    )
    (tmp_path / "alone.spec").write_text(text, encoding="utf-8")
    folder = emit(tmp_path / "out", spec=tmp_path / "alone.spec", recordings=[])
    (folder / "host.c").write_text(GOES_ON)
    others = ["-ffinite-math-only", "-U__FINITE_MATH_ONLY__"]
    said = []
    for host, flags in (("host.c", []), ("host.c", others), ("main.c", others)):
        command = ["gcc", "-std=c99", "-O1", *flags, "supervisor.c", host, "-o", "made", "-lm"]
        subprocess.run(command, cwd=folder, capture_output=True, check=True)
        done = subprocess.run([folder / "made"], capture_output=True, text=True, check=False)
        said.append((done.returncode, done.stdout, "compiler's flags" in done.stderr))
    assert said == [(0, "0 0 1 0", False), (0, "4 2 0 2", False), (1, "", True)]


#: As a host has it for each of its programs.
ITS_OWN = """#include "supervisor.h"
static tm_context context;
int begun_{limit}(void) {{ return (int)tm_init(&context); }}
"""


@pytest.mark.skipif(shutil.which("gcc") is None or shutil.which("ar") is None, reason="no gcc")
@pytest.mark.parametrize("doored", [False, True])
def test_two_programs_that_are_linked_are_told_apart(doored: bool, tmp_path: Path) -> None:
    """Functions of both have the same names: of libraries, as the CMakeLists.txt makes them, the linker takes the first one's without a word. A car
    of which at most 10 m/s are demanded was held to the other one's 20 m/s."""
    text = (
        "module m\nparam top : m/s = {limit} m/s\n"
        "signal plan : trajectory {{ t: s increasing, x: m, y: m, heading: rad, v: m/s }}\n"
        "signal ego : state {{ x: m, y: m, heading: rad, v: m/s }}\n"
        'rule slow ""\n  for all p in plan\n  require p.v <= top\n'
    )
    begun = [f"begun_{limit}" for limit in (10, 20)]
    main = f"int {begun[0]}(void);\nint {begun[1]}(void);\nint main(void) {{ return {begun[0]}() + (10 * {begun[1]}()); }}\n"
    (tmp_path / "main.c").write_text(main)
    for limit in (10, 20):
        spec, folder = loads(text.format(limit=limit)), tmp_path / str(limit)
        made = generate(spec, list(spec.rules), doored=doored)
        folder.mkdir()
        (folder / "supervisor.h").write_text(made.header)
        (folder / "supervisor.c").write_text(made.source)
        (folder / "host.c").write_text(ITS_OWN.format(limit=limit))
        for words in ("gcc -std=c99 -c supervisor.c host.c", "ar rc lib.a supervisor.o"):
            subprocess.run(words.split(), cwd=folder, check=True)
    ends = []
    for libraries in (["10/lib.a", "20/lib.a"], ["20/lib.a", "10/lib.a"]):
        command = ["gcc", "main.c", "10/host.o", "20/host.o", *libraries, "-lm", "-o", "made"]
        subprocess.run(command, cwd=tmp_path, check=True)
        ends.append(subprocess.run([tmp_path / "made"], check=False).returncode)
    assert ends == [40, 4]


@pytest.mark.parametrize(
    ("changed", "other"),
    [
        # The door's, of which no rule knows: what one car cannot do is no fault to the other one's.
        (("v: m/s }", "v: m/s in [0 m/s, 10 m/s] }"), True),
        (("x: m, y: m, heading: rad, v: m/s }\nrule", "y: m, x: m, heading: rad, v: m/s }\nrule"), True),
        (("rule slow", "rule fast"), True),
        (('""', '""  -- and steady'), False),
        (("module m\n", "module m\n\n"), False),
    ],
)
def test_what_is_compiled_otherwise_is_another_program(changed: tuple[str, str], other: bool) -> None:
    text = (
        "module m\nsignal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }\n"
        'signal ego : state { x: m, y: m, heading: rad, v: m/s }\nrule slow ""\n  for all p in plan\n  require p.v <= 10 m/s\n'
    )
    assert changed[0] in text
    numbers, files = [], []
    for written, name in ((text, "supervisor"), (text.replace(*changed), "car")):
        spec = loads(written)
        made = generate(spec, list(spec.rules), name, doored=True)
        numbers += re.findall(r"#define TM_PROGRAM 0x([0-9a-f]{8})ul\n", made.header)
        files.append(digest(made))  # by which a file of cycles is known, and a process
    assert len(numbers) == 2
    assert (numbers[0] != numbers[1], files[0] != files[1]) == (other, other)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
@pytest.mark.parametrize("capacity", [at_length("SAMPLES"), "BORDER", at_length("REASONS")])
def test_a_host_with_other_capacities_has_no_context(capacity: str, tmp_path: Path) -> None:
    """It was overwritten beyond its end, without a word."""
    rules = [rule for rule in shipped().rules if rule.name in ("friction", "safe_gap", "static_collision")]
    made = generate(shipped(), rules, doored=True)
    (tmp_path / "supervisor.h").write_text(made.header)
    (tmp_path / "supervisor.c").write_text(made.source)
    (tmp_path / "main.c").write_text(BEGINS)
    subprocess.run(["gcc", "-std=c99", "-c", "supervisor.c"], cwd=tmp_path, check=True)
    found = []
    for flags in ([], [f"-DTM_MAX_{capacity}=40u"]):
        command = ["gcc", "-std=c99", *flags, "-c", "main.c"]
        subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
        command = ["gcc", "supervisor.o", "main.o", "-o", "begins", "-lm"]
        subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
        found.append(subprocess.run([tmp_path / "begins"], check=False).returncode)
    assert found == [0, 4]


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
@pytest.mark.parametrize("rule", ["no_reversing", at_length("friction")])
@pytest.mark.parametrize("doored", [False, True])
def test_a_host_with_other_structs_has_no_context(doored: bool, rule: str, tmp_path: Path) -> None:
    """Results stood elsewhere, and a violated rule was read as satisfied, where nothing in the context gave that away."""
    made = generate(shipped(), [found for found in shipped().rules if found.name == rule], doored=doored)
    (tmp_path / "supervisor.h").write_text(made.header)
    (tmp_path / "supervisor.c").write_text(made.source)
    (tmp_path / "main.c").write_text(BEGINS)
    begun = {}
    for flag in ("", "-fpack-struct", "-fpack-struct=4", "-fshort-enums"):
        for unit, given in (("supervisor", []), ("main", flag.split())):
            if unit == "main" or not flag:
                command = ["gcc", "-std=c99", *given, "-c", f"{unit}.c"]
                subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
        subprocess.run(["gcc", "supervisor.o", "main.o", "-o", "begins", "-lm"], cwd=tmp_path, check=True)
        begun[flag] = subprocess.run([tmp_path / "begins"], check=False).returncode
    assert begun == {"": 0, "-fpack-struct": 4, "-fpack-struct=4": 4, "-fshort-enums": 4}


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_a_host_with_other_inputs_has_no_context(tmp_path: Path) -> None:
    """A 32-bit PC aligns doubles to 4 bytes: there, only inputs have holes that a host may be without."""
    text = 'module m\nevent rain ""\nsignal ego : state { v: m/s }\nrule dry "" whenever rain require ego.v <= 9 m/s\n'
    spec = loads(text)
    made = generate(spec, list(spec.rules))
    (tmp_path / "supervisor.h").write_text(made.header)
    (tmp_path / "supervisor.c").write_text(made.source)
    (tmp_path / "main.c").write_text(BEGINS)
    begun = []
    for unit, packed in (("supervisor", 4), ("main", 4), ("main", 1)):
        command = ["gcc", "-std=c99", f"-fpack-struct={packed}", "-c", f"{unit}.c"]
        subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
        if unit == "main":
            subprocess.run(["gcc", "supervisor.o", "main.o", "-o", "begins", "-lm"], cwd=tmp_path, check=True)
            begun.append(subprocess.run([tmp_path / "begins"], check=False).returncode)
    assert begun == [0, 4]


SETS = """
#include "supervisor.h"
static tm_context context;
int main(void) { (void)tm_init(&context); return (int)%s; }
"""


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_a_line_that_is_not_there_is_refused(tmp_path: Path) -> None:
    """Of rules alone, whose caller sets lines and zones: it crashed where a pointer was NULL and the count was not."""
    rules = [rule for rule in shipped().rules if rule.name in ("static_collision", "zone_speed_limit")]
    made = generate(shipped(), rules)
    (tmp_path / "supervisor.h").write_text(made.header)
    (tmp_path / "supervisor.c").write_text(made.source)
    setters = re.findall(
        r"^tm_status (tm_set_\w+)\(tm_context \*c, const double \*(left|points),", made.header, re.M
    )
    assert {kind for _, kind in setters} == {"left", "points"}
    level = amount("-O0", "-O1")
    subprocess.run(["gcc", "-std=c99", level, "-c", "supervisor.c"], cwd=tmp_path, check=True)
    for name, kind in setters:
        rest = {"left": "NULL, 4u, NULL, 4u, false", "points": "NULL, 4u"}[kind]
        (tmp_path / "main.c").write_text(SETS % f"{name}(&context, {rest})")
        command = ["gcc", "-std=c99", level, "supervisor.o", "main.c", "-o", "sets", "-lm"]
        subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
        assert subprocess.run([tmp_path / "sets"], check=False).returncode == 3


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_many_long_lanes_have_room(tmp_path: Path) -> None:
    """In 32 bits, 65,536 lanes of two borders of 32,768 points had no room at all, and the first one was prepared beyond it."""
    spec = loads(
        "module m\nsignal ego : state { x: m, y: m, heading: rad }\nsignal lanes : set of lane { left: polyline, right: polyline }\n"
        'rule kept "" require exists l in lanes: (footprint(ego, 4 m, 2 m) inside l)\n'
    )
    (tmp_path / "supervisor.h").write_text(generate(spec, list(spec.rules)).header)
    room = "(TM_SEGMENTS / TM_MAX_ELEMENTS) >= (2u * TM_MAX_BORDER)"
    (tmp_path / "main.c").write_text(
        f'#include "supervisor.h"\ntypedef char all_of_them[({room}) ? 1 : -1];\n'
    )
    command = ["gcc", "-std=c99", "-w", "-fsyntax-only", "-DTM_MAX_ELEMENTS=65536u", "-DTM_MAX_BORDER=32768u"]
    said = subprocess.run([*command, "main.c"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stderr


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_a_lap_without_a_point_is_refused(tmp_path: Path) -> None:
    """Its first pair of border points comes again at its end: of none, what is behind the pointers was read, and NULL crashed."""
    spec = loads(
        "module m\nsignal ego : state { x: m, y: m }\nsignal track : corridor { left: polyline, right: polyline }\n"
        'rule near "" require distance_to(ego, track) <= 3 m\n'
    )
    made = generate(spec, list(spec.rules))
    (tmp_path / "supervisor.h").write_text(made.header)
    (tmp_path / "supervisor.c").write_text(made.source)
    (tmp_path / "main.c").write_text(SETS % "tm_set_track(&context, NULL, 0u, NULL, 0u, true)")
    command = ["gcc", "-std=c99", "-O1", "supervisor.c", "main.c", "-o", "sets", "-lm"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
    assert subprocess.run([tmp_path / "sets"], check=False).returncode == 3


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
@pytest.mark.parametrize("method", [0, 1, 16, 32])
def test_shorter_numbers_of_a_processor_are_no_more_digits(method: int, tmp_path: Path) -> None:
    """GNU C says 16 for a Cortex-M55, a Cortex-A78AE and a Xeon with half precision, where a double is a double."""
    made = source()
    (tmp_path / f"{made.name}.h").write_text(made.header)
    (tmp_path / f"{made.name}.c").write_text(made.source)
    command = ["gcc", "-std=gnu99", "-E", f"-D__FLT_EVAL_METHOD__={method}", f"{made.name}.c"]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (said.returncode, "#error" in said.stderr) == (0, False), said.stderr


@pytest.mark.parametrize("name", ["gcc", "clang"])
@pytest.mark.skipif(platform.machine() != "x86_64", reason="looks for instructions of an x86")
def test_nothing_is_fused_in_a_build_of_ones_own(name: str, tmp_path: Path) -> None:
    """Both compilers fuse if nobody forbids it, gcc wherever GNU C is asked for: `v * v - w * w < 0` held of the same speed twice."""
    if shutil.which(name) is None:
        pytest.skip(f"no {name}")
    made = one_rule("friction").source
    (tmp_path / f"{made.name}.h").write_text(made.header)
    (tmp_path / f"{made.name}.c").write_text(made.source)
    command = [name, "-std=gnu99", "-O2", "-mfma", "-S", "-o", "-", f"{made.name}.c"]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert re.search(r"\bv?mul[sp]d\b", said)
    assert not re.findall(r"\bvfn?m(?:add|sub)\w*", said)


@needs_compiler
def test_two_processes_build_at_once(tmp_path: Path) -> None:
    """Neither moves what it made before both have made it: by themselves, most often one ends before the other compiles."""
    both = tmp_path / "both"
    both.mkdir()
    code = (
        "import os, sys, time; from pathlib import Path; from trackmarshal.evaluation import loads\n"
        "from trackmarshal.backends.c import build; from trackmarshal.backends.c.program import CProgram\n"
        "run, both = build.subprocess.run, Path(sys.argv[1])\n"
        "def late(command, **named):\n"
        "    done = run(command, **named)\n"
        "    if 'made' in command:\n"
        "        (both / str(os.getpid())).touch()\n"
        "        end = time.monotonic() + 120\n"
        "        while len(list(both.iterdir())) < 2:\n"
        "            assert time.monotonic() < end, 'alone'\n"
        "            time.sleep(0.01)\n"
        "    return done\n"
        "build.subprocess.run = late\n"
        "spec = loads('module m\\nsignal ego : state { v: m/s }\\nrule slow \"\" require ego.v < 9 m/s\\n')\n"
        "assert CProgram(spec, list(spec.rules)).library_for().status == 0"
    )
    env = {**os.environ, "TRACKMARSHAL_CACHE": str(tmp_path)}
    running = [subprocess.Popen([sys.executable, "-c", code, str(both)], env=env) for _ in range(2)]
    assert [process.wait() for process in running] == [0, 0]
    assert len(list(both.iterdir())) == 2
    made = list((tmp_path / "c").glob("*/*"))
    assert [path.suffix for path in made] == [".so"]


def test_ziglang_is_a_compiler(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("ziglang", reason="the extra `c` is not installed")
    for name in ("TRACKMARSHAL_CACHE", "ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr("trackmarshal.backends.c.build.shutil.which", lambda name: None)
    command = build.compiler()
    assert command is not None
    assert command[1:] == ["-m", "ziglang", "cc"]
    evaluator = Evaluator(spec(), ["turn_radius"], "reference")
    case = evaluator.read({"signals": {"plan": {"t": [0.0, 0.1], "v": [20.0, 20.0], "kappa": [0.05, 0.1]}}})
    expected = next(iter(evaluator.evaluate([case]))).rules["turn_radius"]
    (found,) = outcomes(one_rule(), [case])
    assert found["turn_radius"] == (expected.verdict, expected.margin)


@pytest.mark.parametrize(
    ("missing", "said"),
    [
        ("compiler", "no C compiler is found [E471]"),
        ("room", "[E471]"),
        ("room for what is linked", "No space left on device [E471]"),
        ("program", "cc' [E471]"),
        ("own code", "[E471]"),
        ("rule", "knows the first and the last [E470]"),
        ("input", "[E473]"),
    ],
)
def test_without_what_it_needs_numpy_evaluates_and_says_so_once(
    missing: str,
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Never silently, never twice, and with the same results."""
    if missing != "compiler" and build.compiler() is None:
        pytest.skip("no C compiler")
    if missing == "compiler":
        monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path))
        monkeypatch.setenv("CC", "no-such-compiler-here")
    if missing == "room":  # somebody else has something there
        (tmp_path / "c").write_text("")
        monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path))
    if missing in (
        "room for what is linked",
        "program",
    ):  # the disk is full only then; $CC is no program, but may be run
        (tmp_path / "cc").write_text(
            "#!/bin/sh\necho ld: final link failed: No space left on device >&2\nexit 1\n"
        )
        if missing == "program":
            (tmp_path / "cc").write_text("none")
        (tmp_path / "cc").chmod(0o755)
        monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path))
        monkeypatch.setenv("CC", str(tmp_path / "cc"))
    if missing == "own code":  # the shell is that of a cross-compiler, or the disk is mounted noexec
        (tmp_path / "cc").write_text("#!/bin/sh\necho of another machine > made\n")
        (tmp_path / "cc").chmod(0o755)
        monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path))
        monkeypatch.setenv("CC", str(tmp_path / "cc"))
    if missing == "rule":
        error = TrackmarshalError(
            "E470", "rule `x`: sample 3 of `plan`; the C generator\nknows the first and the last"
        )
        monkeypatch.setattr("trackmarshal.backends.c.program.generated", mock.Mock(side_effect=error))
    nearly_zero = 1e-70 if missing == "input" else 0.0
    track = {"left": [[-9.0, 5.0], [nearly_zero, 5.0], [9.0, 5.0]], "right": [[-9.0, -5.0], [9.0, -5.0]]}
    plan = {"t": [0.0, 0.1], "x": [0.0, 1.0], "y": [0.0, 0.0], "heading": [0.0, 0.0]}
    rules = ["static_collision"]
    by_numpy, by_c = Evaluator(spec(), rules, "numpy"), Evaluator(spec(), rules, "auto")
    raw = [{"id": i, "signals": {"plan": plan, "track": track}} for i in range(CHUNK + 1)]
    expected = [result.rules for result in by_numpy.evaluate([by_numpy.read(case) for case in raw])]
    assert [result.rules for result in by_c.evaluate([by_c.read(case) for case in raw])] == expected
    assert by_c.backend == "numpy"  # what records of runs say
    said_lines = capsys.readouterr().err.splitlines()
    assert len(said_lines) == 1
    assert said_lines[0].startswith("note: numpy evaluates instead of generated C: ")
    assert said_lines[0].endswith(said)
    asked = Evaluator(spec(), rules, "c")  # who asks for it gets it, or an error
    with pytest.raises(TrackmarshalError) as caught:
        list(asked.evaluate([asked.read(raw[0])]))
    assert f"[{caught.value.code}]" in said


def test_numpy_takes_over_a_case_without_curvatures_too() -> None:
    """Whose rules are straightened ones, that went by C alone where the others had."""
    if build.compiler() is None:
        pytest.skip("no C compiler")
    evaluator = Evaluator(spec(), ["static_collision"], "auto")

    def case(x: float, **more: list[float]) -> dict[str, object]:
        track = {"left": [[-9.0, 5.0], [x, 5.0], [9.0, 5.0]], "right": [[-9.0, -5.0], [9.0, -5.0]]}
        plan = {"t": [0.0, 0.1], "x": [0.0, 1.0], "y": [0.0, 0.0], "heading": [0.0, 0.0], **more}
        return {"signals": {"plan": plan, "track": track}}

    assert evaluator.case(case(0.0, kappa=[0.0, 0.0])).safe
    assert evaluator.backend == "c"
    assert evaluator.case(case(1e-70)).safe
    assert evaluator.backend == "numpy"


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
def test_the_emitted_build_file_asks_for_what_python_compiles_with(written: Path) -> None:
    """In an order in which nothing is taken back: a step took longer, and functions of constants were the compiler's."""
    text = (written / "CMakeLists.txt").read_text(encoding="utf-8")
    asked = " ".join(re.findall(r"^add_compile_options\((.*)\)$", text, re.M)).split()
    levels = {"-std=c99", "-O0", "-O2"}  # CMake's own
    taken = [flag for flag in (*build.EXACT, *build.FAST) if flag not in levels]
    assert set(taken) <= set(asked)
    said = []
    for flags in (asked, taken):
        command = ["gcc", "-O2", *flags, "-Q", "--help=optimizers"]
        done = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        said.append(
            {line.split()[0]: line.split()[1:] for line in done.splitlines() if line.startswith("  -f")}
        )
    assert said[0] == said[1]
    assert said[0]["-fmath-errno"] == said[0]["-ftrapping-math"] == ["[disabled]"]


@needs_compiler
@pytest.mark.acceptance
def test_the_emitted_build_file_builds(written: Path, tmp_path: Path) -> None:
    if shutil.which("cmake") is None:
        pytest.skip("cmake is not installed")
    for command in (["cmake", "-S", str(written), "-B", str(tmp_path)], ["cmake", "--build", str(tmp_path)]):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "warning" not in done.stderr
    runs_from_cycles(tmp_path / "supervisor_example", written)


SAMPLES = """module m
signal ego : state { x: m, y: m, heading: rad, v: m/s, b: bool }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
param lim : m/s = 3 m/s
course driven = ego for 1 s then plan
rule r "r"
"""


@needs_compiler
@pytest.mark.parametrize(
    "rule",
    [
        "along driven as c at last\n  require ego.v <= 1 m/s",
        "along driven as c\n  require ego.v <= 1 m/s",
        "along plan as c at last\n  require lim > 2 m/s",
        "along driven as c at last\n  whenever ego.b\n  require ego.v <= 1 m/s",
    ],
)
def test_a_rule_that_does_not_read_its_sample_leaves_nothing_unused(rule: str, tmp_path: Path) -> None:
    made = loads(f"{SAMPLES}  {rule}\n")
    code = generate(made, chosen_rules(made, None))
    (tmp_path / f"{code.name}.h").write_text(code.header)
    (tmp_path / f"{code.name}.c").write_text(code.source)
    command = [*(build.compiler() or ()), *STRICT, "-fsyntax-only", f"{code.name}.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stderr == ""
