"""Everything that a person, a planner or a disk may hand in: each gives a clear error or `undefined`, never a safe verdict.

The commands run as a person runs them; status 3 and a traceback are failures whatever the input.
"""

from __future__ import annotations

import contextlib
import copy
import io
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import zipfile
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from support.length import at_length, shared_out
from support.start import new_project
from support.started import started
from trackmarshal.cli.main import main
from trackmarshal.testing.builders import BUILDERS

ROOT = Path(__file__).parents[2]
SUPERVISOR = ROOT / "specs" / "supervisor"
SHARED = ROOT.parent / "shared" / "data" / "scenarios"
BACKENDS = ("reference", "numpy", "c")
COMMAND = (sys.executable, "-m", "trackmarshal.cli.main")
GOOD_SPEC = b'module good\nsignal ego : state { v: m/s }\nrule slow "slow"\n  require ego.v < 3 m/s\n'


class Outcome(NamedTuple):
    status: int
    out: str
    err: str

    @property
    def text(self) -> str:
        return self.out + self.err


def run(*arguments: str | Path) -> Outcome:
    """The command in this process."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main([str(argument) for argument in arguments])
    return Outcome(status, out.getvalue(), err.getvalue())


def refused(outcome: Outcome, code: str, place: str = "") -> None:
    """The outcome is an error that names its code, its place and a way out."""
    assert outcome.status in (1, 2), outcome
    assert f"error[{code}]" in outcome.text, outcome.text
    assert place in outcome.text, outcome.text
    assert "help: " in outcome.text or " expected " in outcome.text, outcome.text
    for word in ("Traceback", "internal error", '"safe": true', ": safe"):
        assert word not in outcome.text


@pytest.fixture(autouse=True)
def nowhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands run outside of any project, except where a test names one."""
    monkeypatch.chdir(tmp_path)


# Spec files --------------------------------------------------------------------------------------------------


def rule(require: str) -> bytes:
    return GOOD_SPEC.replace(b"ego.v < 3 m/s", require.encode())


SPECS: dict[str, tuple[bytes, str, str]] = {
    "wrong unit": (rule("ego.v < 3 km"), "E301", "bad.spec:4:11"),
    "no unit": (rule("ego.v < 3"), "E301", "bad.spec:4:11"),
    "unknown unit": (rule("ego.v < 3 mph"), "E106", "bad.spec:4:"),
    "unknown name": (rule("ego.v < v_max"), "E201", "bad.spec:4:19"),
    "unknown field": (rule("ego.w < 3 m/s"), "E210", "bad.spec:4:11"),
    "self import": (GOOD_SPEC.replace(b"module good\n", b"module bad\nuse bad\n"), "E204", "bad.spec:2:1"),
    "missing module": (GOOD_SPEC.replace(b"good\n", b"good\nuse vehicles.nowhere\n"), "E203", "bad.spec:2:1"),
    "duplicate rule": (GOOD_SPEC + b'rule slow "again"\n  require ego.v < 4 m/s\n', "E202", "bad.spec:5:1"),
    "duplicate field": (GOOD_SPEC.replace(b"v: m/s", b"v: m/s, v: m"), "E202", "bad.spec:2:"),
    "no syntax": (rule("ego.v <"), "E102", "bad.spec:4:"),
    "empty": (b"", "E003", "bad.spec:1"),
    "blank": (b"\xef\xbb\xbf\r\n\r\n", "E003", "bad.spec:1"),
    "latin 1": (GOOD_SPEC.replace(b'"slow"', b'"l\xe4ngsam"'), "E004", "bad.spec:3"),
    "utf 16": (GOOD_SPEC.decode().encode("utf-16"), "E004", "bad.spec:1"),
    "binary": (bytes(range(256)) * 40, "E004", "bad.spec:2"),
    "control character": (GOOD_SPEC.replace(b'"slow"', b'"\x1b[2J"'), "E005", "bad.spec:3"),
    "50 MB": (b"-" * 50_000_000, "E002", "bad.spec"),
    "nested": (rule("not " * 3000 + "(ego.v < 3 m/s)"), "E104", "bad.spec:4"),
    "huge number": (rule("ego.v < 1e400 m/s"), "E306", "bad.spec:4:19"),
    "division by zero": (b"module good\nparam x : 1 = 0 / 0\n", "E306", "bad.spec:2:15"),
}  # fmt: skip


@pytest.mark.parametrize("name", shared_out(SPECS, 2))
def test_check_says_what_is_wrong_with_a_spec(name: str, tmp_path: Path) -> None:
    content, code, place = SPECS[name]
    (tmp_path / "bad.spec").write_bytes(content)
    refused(run("check", "bad.spec"), code, place)


@pytest.mark.parametrize(
    ("name", "verb"), shared_out(product(SPECS, ("test", "eval", "replay", "explain")), 7)
)
def test_no_verb_works_with_a_bad_spec(name: str, verb: str, tmp_path: Path) -> None:
    content, code, _ = SPECS[name]
    (tmp_path / "bad.spec").write_bytes(content)
    (tmp_path / "case.jsonl").write_text('{"id": 1, "signals": {"ego": {"v": 1}}}\n')
    recording = ROOT / "specs" / "scenarios" / "free_lap.tmrec.jsonl"
    arguments: dict[str, list[str | Path]] = {
        "test": ["bad.spec"],
        "eval": ["bad.spec", "--data", "case.jsonl", "--format", "jsonl"],
        "replay": [recording, "--spec", "bad.spec"],
        "explain": [recording, "--spec", "bad.spec", "--rule", "slow", "--at", "0"],
    }
    if verb in ("replay", "explain") and len(content) > 10_000_000:
        pytest.skip("the file is read the same way by every verb")
    refused(run(verb, *arguments[verb]), code)


@pytest.mark.parametrize("name", SPECS)
def test_a_file_that_is_not_understood_is_not_laid_out(name: str, tmp_path: Path) -> None:
    content, code, _ = SPECS[name]
    (tmp_path / "bad.spec").write_bytes(content)
    outcome = run("fmt", "bad.spec")
    if code < "E2":  # names and dimensions are none of the formatter's business
        refused(outcome, code)
        assert (tmp_path / "bad.spec").read_bytes() == content
    else:
        assert outcome.status == 0


def test_the_good_spec_is_good(tmp_path: Path) -> None:
    (tmp_path / "good.spec").write_bytes(GOOD_SPEC)
    assert run("check", "good.spec").status == 0


@pytest.mark.parametrize(
    "content", [GOOD_SPEC.replace(b"\n", b"\r\n"), b"\xef\xbb\xbf" + GOOD_SPEC, GOOD_SPEC.rstrip(), GOOD_SPEC.replace(b"\n", b"\r")]
)  # fmt: skip
def test_line_ends_and_byte_order_marks_are_no_mistake(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "good.spec").write_bytes(content)
    assert run("check", "good.spec").status == 0
    wrong = content.replace(b"3 m/s", b"3")
    (tmp_path / "bad.spec").write_bytes(wrong)
    refused(run("check", "bad.spec"), "E301", "bad.spec:4:11")


def test_modules_that_use_each_other(tmp_path: Path) -> None:
    for name, used in (("a", "b"), ("b", "c"), ("c", "a")):
        (tmp_path / f"{name}.spec").write_text(f"module {name}\nuse {used}\n")
    refused(run("check", "."), "E204", "a -> b -> c -> a")


def test_one_rule_in_two_modules(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / f"{name}.spec").write_bytes(GOOD_SPEC.replace(b"good", name.encode()))
    outcome = run("check", ".")
    refused(outcome, "E202", "b.spec:3:1")
    assert "a.spec:3:1" in outcome.err


def test_a_satisfies_to_nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT / "tests" / "golden" / "semantics" / "unknown_requirement")
    refused(run("check", "specs"), "E206", "specs/main.spec:6:13")


def test_paths_that_lead_to_no_spec(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "folder.spec").mkdir()
    os.symlink("loop.spec", tmp_path / "loop.spec")
    for path, code in (
        ("none.spec", "E001"),
        ("empty", "E006"),
        ("loop.spec", "E001"),
        ("none/none.spec", "E001"),
    ):
        refused(run("check", path), code, path)
        refused(run("test", path), code, path)
    refused(run("check", "."), "E001", "loop.spec")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_spec_that_may_not_be_read(tmp_path: Path) -> None:
    (tmp_path / "bad.spec").write_bytes(GOOD_SPEC)
    (tmp_path / "bad.spec").chmod(0)
    refused(run("check", "bad.spec"), "E001", "bad.spec")


def test_a_spec_without_rules_cannot_call_anything_safe(tmp_path: Path) -> None:
    (tmp_path / "bad.spec").write_text("module bad\nsignal ego : state { v: m/s }\n")
    (tmp_path / "case.jsonl").write_text('{"id": 1, "signals": {"ego": {"v": 1}}}\n')
    assert run("check", "bad.spec").status == 0
    refused(run("eval", "bad.spec", "--data", "case.jsonl", "--format", "jsonl"), "E404")


def test_outside_of_a_project(tmp_path: Path) -> None:
    for arguments in (["check"], ["test"], ["fmt"], ["trace"], ["check", "--project", "nowhere"]):
        refused(run(*arguments), "E410")


YAMLS = {
    "anchors": ("a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n", "T107"),
    "python tag": ("document: !!python/object/apply:os.system [id]\n", "T108"),
    "not YAML": ("document: [\n", "T105"),
    "two documents": ("document: requirements\n---\ndocument: requirements\n", "T106"),
    "a key twice": ("document: requirements\ndocument: requirements\n", "T109"),
    "empty": ("", "T103"),
    "latin 1": ("title: caf\udce9\n", "T104"),
    "deep": ("document: " + "[" * 2000 + "]" * 2000 + "\n", "T110"),
}


@pytest.mark.parametrize("name", YAMLS)
@pytest.mark.parametrize("verb", ["check", "trace"])
def test_requirements_that_cannot_be_read(
    name: str, verb: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    content, code = YAMLS[name]
    (tmp_path / "requirements").mkdir()
    (tmp_path / "specs").mkdir()
    (tmp_path / "specs" / "good.spec").write_bytes(GOOD_SPEC)
    v_model = "document: v-model\ntitle: small\nproject:\n  name: small\n  specs: [specs]\n"
    (tmp_path / "requirements" / "v-model.yaml").write_text(v_model)
    (tmp_path / "requirements" / "bad.yaml").write_text(content, "utf-8", "surrogateescape")
    outcome = run(verb)
    assert outcome.status == 2
    refused(outcome, code, "requirements/bad.yaml")


# Data --------------------------------------------------------------------------------------------------------


def good_case() -> dict[str, Any]:
    """A car on a wide straight road at 20 m/s, somebody far ahead, a cone at the side."""
    return {
        "id": "good",
        "signals": {
            "plan": BUILDERS["line"].build(v=20.0, length=49.0, points=50.0),
            "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 20.0, "age": 0.0},
            "objects": [
                {"id": "o1", "x": 120.0, "y": 0.0, "heading": 0.0, "v": 20.0, "length": 4.7, "width": 2.0}
            ],
            "obstacles": [{"id": "c1", "x": 20.0, "y": 5.5, "heading": 0.0, "length": 0.3, "width": 0.3}],
            "track": BUILDERS["straight_track"].build(width=12.0, length=200.0),
            "emergency": False,
        },
    }


def evaluate(
    *lines: object, backend: str = "numpy", more: tuple[str, ...] = ()
) -> tuple[int, list[dict[str, Any]]]:
    """`eval` of the Supervisor's rules: the status, and the lines that came back, which are strict JSON."""
    content = b"\n".join(
        line
        if isinstance(line, bytes)
        else line.encode()
        if isinstance(line, str)
        else json.dumps(line).encode()
        for line in lines
    )
    Path("cases.jsonl").write_bytes(content)
    arguments: list[str | Path] = [
        "eval",
        SUPERVISOR,
        "--data",
        "cases.jsonl",
        "--backend",
        backend,
        "--format",
        "jsonl",
        *more,
    ]
    outcome = run(*arguments)
    assert outcome.status in (0, 1, 2), outcome.text
    assert "Traceback" not in outcome.text
    made = [json.loads(line, parse_constant=_not_strict) for line in outcome.out.splitlines()]
    unsafe = any(line.get("safe") is False for line in made)
    assert outcome.status == (2 if any("error" in line for line in made) else 1 if unsafe else 0)
    return outcome.status, made


def _not_strict(word: str) -> None:
    raise AssertionError(f"{word} is not strict JSON")


def told(line: dict[str, Any]) -> str:
    """Why a case is not safe: its faults, the reasons of its rules, or the rules themselves."""
    assert line["safe"] is False
    undefined = [f"{n} {r['verdict']} {r.get('reason', '')}" for n, r in line["rules"].items() if r["verdict"] in ("violated", "undefined")]  # fmt: skip
    return "; ".join([*line.get("faults", []), *undefined, *line.get("constraints", [])])


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_good_case_is_safe(backend: str) -> None:
    status, lines = evaluate(good_case(), {**good_case(), "id": 2}, backend=backend)
    assert status == 0
    assert [line["safe"] for line in lines] == [True, True]


LINES: list[tuple[str | bytes, str]] = [
    ("{", "D101"), ("[1, 2", "D101"), ('{"id": 1 "x"}', "D101"), ("safe", "D101"), (b"\0\0\0", "D101"),
    (b'\xff\xfe{"id": 1}', "D101"), ("[" * 100_000, "D101"), ('{"a":' * 300_000 + "1" + "}" * 300_000, "D101"),
    ('{"id": 1, "params": {"mu": ' + "9" * 5000 + "}}", "D101"), ('{"id": 1, "id": 2}', "D101"),
    ('{"id": 1, "signals": {"ego": {"v": 1, "v": 2}}}', "D101"),
    ("[]", "D201"), ("3", "D201"), ('"x"', "D201"), ("null", "D201"), ("true", "D201"), ("NaN", "D201"),
    ('{"id": {"a": 1}}', "D201"), ('{"id": NaN}', "D201"), ('{"id": 1e999}', "D201"),
    ('{"signals": []}', "D202"), ('{"signals": null}', "D202"), ('{"params": []}', "D202"),
    ('{"signals": {"plan": []}}', "D202"), ('{"signals": {"objects": 3}}', "D202"), ('{"signals": {"objects": [1]}}', "D202"),
    ('{"signals": {"objects": {"x": 1}}}', "D202"),
    ('{"signals": {"emergency": 1}}', "D202"), ('{"signals": {"track": {"left": [1]}}}', "D202"),
    ('{"params": {"muu": 1}}', "D203"), ('{"parms": {"mu": 1}}', "D203"), ('{"tables": {"axmax": []}}', "D203"),
    ('{"places": {"pit": []}}', "D203"),
    ('{"params": {"mu": NaN}}', "D204"), ('{"params": {"mu": 1e400}}', "D204"), ('{"params": {"mu": 99}}', "D204"),
    ('{"params": {"mu": null}}', "D204"), ('{"tables": {"ax_max": []}}', "D204"),
    ('{"tables": {"ax_max": [[1, 1], [0, 1]]}}', "D204"), ('{"places": {"pit_lane": [[0, 0], [1, 1]]}}', "D204"),
]  # fmt: skip


@pytest.mark.parametrize("backend", [at_length("reference"), "numpy", "c"])
def test_lines_that_cannot_be_read(backend: str) -> None:
    """Each says so, and those between still run."""
    given = [each for line, _ in LINES for each in (good_case(), line)]
    status, lines = evaluate(*given, {**good_case(), "id": "after"}, backend=backend)
    assert status == 2
    assert [entry.get("safe") for entry in lines] == [True, None] * len(LINES) + [True]
    for place, (_, code) in enumerate(LINES):
        unreadable(lines[2 * place + 1], code, 2 * place + 2)


def unreadable(entry: dict[str, Any], code: str, line: int) -> None:
    assert (entry["error"]["code"], entry["error"]["line"]) == (code, line)
    assert entry["error"]["message"]
    assert entry["error"]["help"]


#: Every twentieth one by itself every day, each by each evaluator in `make acceptance`.
BY_ITSELF = [
    pytest.param(
        line, code, backend, id=f"{code}-{line[:30]!r}-{backend}",
        marks=[] if (3 * place + number) % 20 == 0 else [pytest.mark.acceptance],
    )
    for place, (line, code) in enumerate(LINES)
    for number, backend in enumerate(BACKENDS)
]  # fmt: skip


@pytest.mark.parametrize(("line", "code", "backend"), BY_ITSELF)
def test_a_line_that_cannot_be_read(line: str | bytes, code: str, backend: str) -> None:
    """The line says so, the others still run, the status is 2."""
    status, lines = evaluate(good_case(), line, {**good_case(), "id": "after"}, backend=backend)
    assert status == 2
    assert [entry.get("safe") for entry in lines] == [True, None, True]
    unreadable(lines[1], code, 2)


def test_a_line_that_cannot_be_read_as_text() -> None:
    Path("cases.jsonl").write_text("\n{\n")
    outcome = run("eval", SUPERVISOR, "--data", "cases.jsonl")
    assert outcome.status == 2
    refused(outcome, "D101", "cases.jsonl:2")


def test_data_that_is_not_there() -> None:
    Path("empty.jsonl").write_bytes(b"\n\n")
    Path("folder").mkdir()
    for path, code in (
        ("none.jsonl", "D102"),
        ("folder", "D102"),
        ("empty.jsonl", "D103"),
        ("/dev/null", "D102"),
    ):
        refused(run("eval", SUPERVISOR, "--data", path), code, path)


def edited(change: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
    """The good case with something done to its signals."""
    case = good_case()
    change(case["signals"])
    return case


def put(*path: str | int, to: Any) -> dict[str, Any]:
    def change(signals: dict[str, Any]) -> None:
        place: Any = signals
        for step in path[:-1]:
            place = place[step]
        place[path[-1]] = to

    return edited(change)


def eight(closed: bool, width: float = 10.0, size: float = 60.0, count: int = 120) -> dict[str, Any]:
    """A figure of eight around the origin."""
    angles = [2 * math.pi * i / count for i in range(count + (not closed))]
    centre = [(size * math.sin(a), size * math.sin(a) * math.cos(a)) for a in angles]
    headings = [math.atan2(math.cos(2 * a), math.cos(a)) for a in angles]
    sides = {
        side: [[x - d * math.sin(h), y + d * math.cos(h)] for (x, y), h in zip(centre, headings)]
        for side, d in (("left", width / 2), ("right", -width / 2))
    }
    return {**sides, "closed": closed}


TRACK = BUILDERS["straight_track"].build(width=12.0, length=200.0)
PLAN = good_case()["signals"]["plan"]
NAN, INF = math.nan, math.inf

CASES: dict[str, tuple[dict[str, Any], str]] = {
    **{f"no {name}": (edited(lambda s, n=name: s.pop(n)), f"D211 {name}") for name in good_case()["signals"]},  # type: ignore[misc]
    **{f"null {name}": (put(name, to=None), f"D211 {name}") for name in good_case()["signals"]},
    "no signals": ({"id": 1}, "D211 plan"),
    "one point": (put("plan", to={n: c[:1] for n, c in PLAN.items()}), "D213 plan"),
    "no point": (put("plan", to={n: [] for n in PLAN}), "D213 plan"),
    "unequal columns": (put("plan", "v", to=PLAN["v"][:-1]), "D212 plan"),
    "unequal time": (put("plan", "t", to=PLAN["t"][:-1]), "D212 plan"),
    "decreasing time": (put("plan", "t", to=PLAN["t"][::-1]), "D214 plan.t[1]"),
    "standing time": (put("plan", "t", 7, to=PLAN["t"][6]), "D214 plan.t[7]"),
    "null time": (put("plan", "t", to=None), "D211 plan.t"),
    **{f"NaN in {n}": (put("plan", n, 7, to=NAN), f"D215 plan.{n}[7]") for n in PLAN},
    **{f"null in {n}": (put("plan", n, 7, to=None), f"D215 plan.{n}[7]") for n in PLAN},
    **{f"infinity in {n}": (put("plan", n, 7, to=INF), f"D215 plan.{n}[7]") for n in PLAN},
    **{f"1e300 in {n}": (put("plan", n, 7, to=1e300), "") for n in PLAN},
    **{f"1e308 in ego {n}": (put("ego", n, to=1e308), "") for n in ("x", "y", "heading", "v", "age")},
    **{f"NaN in ego {n}": (put("ego", n, to=NAN), f"D215 ego.{n}") for n in ("x", "y", "heading", "v", "age")},
    **{f"NaN in object {n}": (put("objects", 0, n, to=NAN), f"D215 objects.{n}[0]") for n in good_case()["signals"]["objects"][0] if n != "id"},
    "huge object": (put("objects", 0, "x", to=1e308), ""),
    "huge integer": (put("ego", "x", to=10**400), "D215 ego.x"),
    "objects in columns, of which none is there": (put("objects", to={}), "D211 objects.x"),
    "object without a place": (edited(lambda s: s["objects"][0].pop("x")), "D211 objects.x[0]"),
    "object without a size": (put("objects", 0, "width", to=0), "D216 objects.width[0]"),
    "two objects of one id": (edited(lambda s: s["objects"].append(s["objects"][0])), "D218 objects.id[1]: `o1`"),
    "speed out of range": (put("plan", "v", 3, to=151), "D216 plan.v[3]: 151.0 m/s is outside [-10, 150]"),
    "track without left": (edited(lambda s: s["track"].pop("left")), "D211 track.left"),
    "empty track": (put("track", to={"left": [], "right": []}), "D217 track.left"),
    "track of a point": (put("track", "left", to=TRACK["left"][:1]), "D217 track.left"),
    "track of one place": (put("track", "left", to=[[0, 6]] * 9), "left border has fewer than 2 distinct points"),
    "track with NaN": (put("track", "right", 1, 0, to=NAN), "D215 track.right[1]"),
    "huge track": (put("track", "left", 0, 0, to=-1e300), "left border: point 0"),
    "track at infinity": (put("track", "left", 0, 0, to=-INF), "D215 track.left[0]"),
    "borders that cross": (put("track", to={"left": [[-20, 6], [40, -6], [200, -6]], "right": [[-20, -6], [40, 6], [200, 6]]}), "left border meets right border near"),
    "a border that crosses itself": (put("track", "left", to=[[-20, 6], [30, 6], [30, 20], [10, 20], [10, 2], [200, 2]]), "left border crosses itself near (10.000, 6.000)"),
    "a straight track said to be closed": (put("track", "closed", to=True), "left border"),
    "an open figure of eight": (put("track", to=eight(False)), "left border meets right border near"),
    "a closed figure of eight, driven across": (put("track", to=eight(True)), "static_collision"),
    "unsound parameters": ({**good_case(), "params": {"b_rear": 20}}, "b_rear <= b_front"),
}  # fmt: skip


@pytest.mark.parametrize("backend", [at_length("reference"), at_length("numpy"), "c"])
def test_cases_that_cannot_be_called_safe(backend: str) -> None:
    """One run with all of them: what is wrong with one does not touch the others. The reference, which is slow, has few good ones."""
    every = 8 if backend == "reference" else 1
    cases = [
        case
        for place, name in enumerate(CASES)
        for case in ({**CASES[name][0], "id": name}, {**good_case(), "id": "good"})[
            : 2 if place % every == 0 else 1
        ]
    ]
    status, lines = evaluate(*cases, backend=backend)
    assert status == 1
    assert [line["id"] for line in lines] == [case["id"] for case in cases]
    for line in lines:
        if line["id"] == "good":
            assert line["safe"] is True
        else:
            assert CASES[line["id"]][1] in told(line), (line["id"], told(line))


@pytest.mark.parametrize("backend", BACKENDS)
def test_what_looks_odd_and_is_fine(backend: str) -> None:
    standing = put("objects", 0, "v", to=0)
    nobody = put("objects", to=[])
    bare = edited(lambda s: (s.update(objects=[], obstacles=[]), s["ego"].pop("age", None)))
    turned = put("ego", "heading", to=2 * math.pi)
    status, lines = evaluate(standing, nobody, bare, turned, good_case(), backend=backend)
    assert status == 0
    assert [line["safe"] for line in lines] == [True] * 5


def test_a_car_inside_a_closed_figure_of_eight_is_on_the_track() -> None:
    """Such tracks are real; where they cross, both branches are road."""
    angles = [0.7 + 0.01 * i for i in range(30)]
    plan = {
        "t": [0.1 * i for i in range(30)],
        "x": [60 * math.sin(a) for a in angles],
        "y": [60 * math.sin(a) * math.cos(a) for a in angles],
        "heading": [math.atan2(math.cos(2 * a), math.cos(a)) for a in angles],
    }
    for closed, verdict in ((True, "satisfied"), (False, "undefined")):
        case = {"id": 1, "signals": {"plan": plan, "track": eight(closed)}}
        status, lines = evaluate(case, more=("--rule", "static_collision"))
        assert status == (0 if closed else 1)
        assert lines[0]["rules"]["static_collision"]["verdict"] == verdict


def test_rules_and_configurations_that_are_not_there() -> None:
    Path("cases.jsonl").write_text(json.dumps(good_case()))
    Path("odd.spec").write_text("module odd\nparam no_such_parameter : m = 1 m\n")
    Path("wide.spec").write_text("module wide\nparam width : m = 99 m\n")
    Path("time.spec").write_text("module time\nparam width : s = 1 s\n")
    for arguments, code in (
        (("--rule", "frictoin"), "E401"), (("--rule", "A-REAR-VEHICLE"), "E404"), (("--with", "none.spec"), "E001"),
        (("--with", "odd.spec"), "E402"), (("--with", "wide.spec"), "E402"), (("--with", "time.spec"), "E402"),
    ):  # fmt: skip
        refused(run("eval", SUPERVISOR, "--data", "cases.jsonl", *arguments), code)
    for unknown in (("--backend", "fortran"), ("--format", "xml"), ("--nonsense",)):
        assert run("eval", SUPERVISOR, "--data", "cases.jsonl", *unknown).status == 2


def test_unknown_verbs_codes_and_arguments() -> None:
    assert run("chekc").status == 2
    assert "did you mean `check`" in run("chekc").err
    assert run().status == 2
    refused(run("explain", "E999"), "E441")
    refused(run("explain", "nothing"), "E442")
    recording = ROOT / "specs" / "scenarios" / "free_lap.tmrec.jsonl"
    for time in ("nan", "inf", "0.05", "-1"):
        arguments = ("--rule", "friction", "--at", time, "--spec", SUPERVISOR, "--project", ROOT)
        refused(run("explain", recording, *arguments), "E442")


# Recordings ----------------------------------------------------------------------------------------------------


def replayed(name: str, content: bytes) -> Outcome:
    Path(name).write_bytes(content)
    return run("replay", name, "--spec", SUPERVISOR, "--quiet")


def zipped(*members: tuple[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return buffer.getvalue()


def bomb() -> bytes:
    """Made where it is needed: packing it takes long, even quickly."""
    return zipped(("a.scn", b"0" * 300_000_000), ("a.sas", b""))


def own_recording() -> list[bytes]:
    return (ROOT / "specs" / "scenarios" / "cut_in.tmrec.jsonl").read_bytes().splitlines(keepends=True)


def saa() -> bytes:
    path = SHARED / "modena_T1_valid.saa"
    if not path.is_file():
        pytest.skip(f"{path} is not there")
    return path.read_bytes()


@pytest.mark.parametrize(
    ("name", "content", "code"),
    [
        ("empty.saa", b"", "D122"), ("text.saa", b"hello", "D122"), ("zip.saa", zipped(), "D123"),
        ("other.saa", zipped(("readme.txt", b"hello")), "D123"), ("folder.saa", zipped(("../../evil.scn", b"x")), "D123"),
        ("bomb.saa", bomb, "D124"),
        ("unknown.bin", b"\0\1\2", "D121"), ("empty.tmrec.jsonl", b"", "D126"), ("latin.tmrec.jsonl", b"\xe9\n", "D126"),
        ("other.tmrec.jsonl", b"{}\n", "D121"), ("deep.tmrec.jsonl", b"[" * 100_000, "D140"),
        ("head.tmrec.jsonl", own_recording()[0], "D130"), ("cut.tmrec.jsonl", b"".join(own_recording())[:50_000], "D140"),
        ("twice.tmrec.jsonl", b"".join([*own_recording()[:9], own_recording()[8]]), "D130"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)  # fmt: skip
def test_recordings_that_are_none(name: str, content: bytes | Callable[[], bytes], code: str) -> None:
    outcome = replayed(name, content() if callable(content) else content)
    assert outcome.status == 2
    refused(outcome, code, name)


def test_recordings_that_are_not_there() -> None:
    Path("folder").mkdir()
    for path, code in (("none.saa", "D120"), ("folder", "D120")):
        refused(run("replay", path, "--spec", SUPERVISOR), code, path)


def test_a_truncated_recording_of_scenario_architect() -> None:
    content = saa()
    for part in (content[: len(content) // 2], content[:-30], content[100:]):
        refused(replayed("cut.saa", part), "D122", "cut.saa")


def test_a_recording_of_scenario_architect_with_other_members() -> None:
    with zipfile.ZipFile(io.BytesIO(saa())) as archive:
        members = [(name, archive.read(name)) for name in archive.namelist()]
    for change in (
        lambda name, content: (name.replace(".scn", ".txt"), content),
        lambda name, content: (name, b""),
        lambda name, content: (name, content[: len(content) // 2]),
        lambda name, content: (name, content.replace(b"0", b"x")),
    ):
        outcome = replayed("odd.saa", zipped(*(change(*member) for member in members)))
        assert outcome.status == 2, outcome.text
        assert "error[D1" in outcome.err
        assert "odd.saa" in outcome.err


def test_a_configuration_that_a_recording_names_is_not_there(tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    head = json.loads(own_recording()[0])
    head["use"] = ["nowhere.spec"]
    refused(
        replayed("moved.tmrec.jsonl", b"".join([json.dumps(head).encode() + b"\n", *own_recording()[1:]])),
        "E431",
    )


# The system ------------------------------------------------------------------------------------------------------


@pytest.fixture
def many(tmp_path: Path) -> Path:
    """Cases for which `eval` prints more than a pipe holds."""
    (tmp_path / "good.spec").write_bytes(GOOD_SPEC)
    path = tmp_path / "many.jsonl"
    path.write_text("".join(f'{{"id": {i}, "signals": {{"ego": {{"v": 1}}}}}}\n' for i in range(600)))
    return path


EVAL = (*COMMAND, "eval", "good.spec", "--format", "jsonl", "--data")


def test_ctrl_c_while_waiting_for_data(many: Path) -> None:
    with started(*EVAL, "-", stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(many.read_bytes())
        process.stdin.flush()
        assert process.stdout.readline().startswith(b'{"id": 0, "safe": true')  # it runs
        process.send_signal(signal.SIGINT)
        _, err = process.communicate()
    assert (process.returncode, err) == (130, b"interrupted\n")


def test_ctrl_c_during_a_long_replay() -> None:
    recordings = [ROOT / "specs" / "scenarios" / "cut_in.tmrec.jsonl"] * 200
    replay: list[str | Path] = ["replay", *recordings, "--spec", SUPERVISOR, "--rule", "friction"]
    with started(
        *COMMAND, *replay, "--format", "jsonl", "--project", ROOT, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith(b'{"scenario": "cut_in"')
        process.send_signal(signal.SIGINT)
        _, err = process.communicate()
    assert (process.returncode, err.splitlines()[-1]) == (130, b"interrupted")
    assert b"Traceback" not in err


def test_a_reader_that_goes_away(many: Path) -> None:
    with started(*EVAL, many, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline().startswith(b'{"id": 0, "safe": true')
        process.stdout.close()
        err = process.stderr.read()
        process.wait()
    assert (process.returncode, err) == (141, b"")


def test_a_reader_of_messages_that_goes_away(tmp_path: Path) -> None:
    (tmp_path / "bad.spec").write_bytes(GOOD_SPEC + b"".join(rule(f"ego.v < {i}")[44:] for i in range(2000)))
    with started(*COMMAND, "check", "bad.spec", stderr=subprocess.STDOUT) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith(b"error[E")
        process.stdout.close()
        process.wait()
    assert process.returncode == 141


def test_without_standard_streams(many: Path) -> None:
    results, messages = (
        (*EVAL, str(many)),
        (*COMMAND, "check", "none.spec"),
    )  # whose status is not that of a traceback
    for redirection, words in ((">&-", results), ("2>&-", messages), ("<&- >&- 2>&-", messages)):
        script = f'exec "$@" {redirection}'
        arguments = ["sh", "-c", script, "sh", *words]
        done = subprocess.run(arguments, capture_output=True, check=False)
        assert done.returncode in (0, 2), (redirection, done)
        assert b"Traceback" not in done.stderr


def test_a_terminal_that_knows_only_ascii(tmp_path: Path) -> None:
    (tmp_path / "bad.spec").write_bytes(rule("ego.v < größe").replace(b'"slow"', "\"langsam – 速い\"".encode()))  # fmt: skip
    done = subprocess.run(
        [*COMMAND, "check", "bad.spec"],
        capture_output=True,
        check=False,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )
    assert done.returncode == 1
    assert b"error[E" in done.stderr
    assert b"Traceback" not in done.stderr


def test_a_place_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    recording = ROOT / "specs" / "scenarios" / "free_lap.tmrec.jsonl"
    outcome = run("replay", recording, "--spec", SUPERVISOR, "--quiet", "--out", "file/below")
    assert outcome.status == 2
    refused(outcome, "E411", "file")


def test_the_command_itself_gives_status_and_message(tmp_path: Path) -> None:
    """What the tests above see in this process, a shell sees too."""
    (tmp_path / "bad.spec").write_bytes(rule("ego.v < 3"))
    (tmp_path / "good.spec").write_bytes(GOOD_SPEC)
    (tmp_path / "cases.jsonl").write_text("{\n")
    for arguments, status, code in (
        (("check", "bad.spec"), 1, "E301"),
        (("eval", "good.spec", "--data", "cases.jsonl"), 2, "D101"),
    ):
        done = subprocess.run([*COMMAND, *arguments], capture_output=True, check=False, text=True)
        assert done.returncode == status
        assert f"error[{code}]" in done.stdout + done.stderr
        assert "Traceback" not in done.stderr


def test_nothing_is_changed_by_evaluating(tmp_path: Path) -> None:
    case = good_case()
    before = copy.deepcopy(case)
    evaluate(case)
    assert case == before


@pytest.mark.verifies("S-1-B-5")
def test_a_cycle_without_an_emergency_trajectory_is_not_safe() -> None:
    head, first, *rest = (ROOT / "specs" / "scenarios" / "free_lap.tmrec.jsonl").read_bytes().splitlines()
    cycle = json.loads(first)
    del cycle["candidates"]["emergency"]
    use = json.loads(head)
    use["use"] = ["northfield.spec"]
    shutil.copy(ROOT / "specs" / "tracks" / "northfield.spec", "northfield.spec")
    lines = [json.dumps(use).encode(), json.dumps(cycle).encode(), *rest]
    outcome = replayed("missing.tmrec.jsonl", b"\n".join(lines) + b"\n")
    assert outcome.status == 1
    assert "every trajectory is safe" not in outcome.out
    assert "a candidate is missing at 0 s" in outcome.out


@pytest.mark.parametrize(
    ("key", "value"),
    [("specs: [specs]", 'specs: ["a\\0b"]'), ("default_spec: specs", 'default_spec: "a\\0b"')],
)
def test_a_zero_character_in_a_path_of_the_v_model(key: str, value: str, tmp_path: Path) -> None:
    new_project(tmp_path / "car")
    model = tmp_path / "car" / "requirements" / "v-model.yaml"
    text = model.read_text("utf-8")
    assert key in text
    model.write_text(text.replace(key, value), "utf-8")
    done = run("trace", "--gate", "--project", tmp_path / "car")
    assert done.status in (1, 2)
    assert "error[E001]" in done.text
