"""Whatever a requirements folder holds, reading it ends in findings, never in a traceback; and scale costs seconds."""

from __future__ import annotations

import copy
import json
import random
import tempfile
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from time import process_time
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator, FormatChecker

from golden.trace.cases import PROJECT, TODAY, Small
from support.length import amount
from trackmarshal import trace
from trackmarshal.records.runs import RuleFacts, RunSummary, TruthFacts
from trackmarshal.records.specs import Ref, SpecItem, SpecTest
from trackmarshal.records.tests import TestResult
from trackmarshal.trace import requirements, schema
from trackmarshal.trace.findings import Finding

FILES = {path.name: path.read_bytes() for path in sorted((PROJECT / "requirements").glob("*.yaml"))}
#: The documents that the small project has none of: hazards, design, people, and a schema of links.
FILES |= {
    name: (PROJECT.parent / "warehouse" / "requirements" / name).read_bytes()
    for name in ("hazards.yaml", "design.yaml", "people.yaml", "links.yaml")
}
VALIDATOR = Draft202012Validator(schema.schema(), format_checker=FormatChecker())


def folder_of(files: dict[str, bytes]) -> tempfile.TemporaryDirectory[str]:
    folder = tempfile.TemporaryDirectory()
    for name, data in files.items():
        path = Path(folder.name) / "requirements" / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(data)
    return folder


@st.composite
def damaged(draw: st.DrawFn) -> dict[str, bytes]:
    """The documents of the small project, one of them cut, spliced or peppered."""
    files = dict(FILES)
    name = draw(st.sampled_from(sorted(files)))
    data = files[name]
    for _ in range(draw(st.integers(1, 3))):
        start = draw(st.integers(0, len(data)))
        end = min(len(data), start + draw(st.integers(0, 60)))
        junk = [
            b"",
            b"[",
            b"{",
            b"]",
            b": ",
            b"- ",
            b"&a ",
            b"*a ",
            b"!!x ",
            b"'",
            b"\n",
            b"\t",
            b"\x00",
            b"\xff",
            b"---\n",
            b"? ",
            b"|\n",
            b"~",
            b"no",
            b"1",
        ]
        data = data[:start] + draw(st.sampled_from(junk) | st.binary(max_size=6)) + data[end:]
    files[name] = data
    return files


@settings(max_examples=amount(6, 60), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(damaged())
def test_damaged_files_end_in_findings(files: dict[str, bytes]) -> None:
    items, tests, results, runs = Small().parts()
    with folder_of(files) as name:
        matrix = trace.build(Path(name), items, tests, results, runs, TODAY)
        for kind in ("text", "json", "html", "sarif"):
            trace.render(matrix, kind)
    for finding in matrix.findings:
        assert finding.code in trace.CODES
        assert finding.message


VALUES: list[Any] = [
    "",
    "text",
    "S-1-A-9",
    "AV-RO",
    "D",
    "approved",
    3,
    -1,
    2.5,
    True,
    None,
    [],
    ["x"],
    [3],
    {},
    {"id": "X-1"},
    "2026-02-30",
]


def places(data: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """All paths into a document, but the top and the word that says which document it is."""
    entries = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    found: list[tuple[Any, ...]] = []
    for key, value in entries:
        if at or key != "document":
            found.append((*at, key))
            found += places(value, (*at, key))
    return found


@st.composite
def reshaped(draw: st.DrawFn) -> tuple[str, Any]:
    """A document with one value replaced, removed or added: sometimes still valid, mostly not."""
    name = draw(st.sampled_from(sorted(FILES)))
    data = json.loads(json.dumps(yaml.safe_load(FILES[name]), default=lambda day: day.isoformat()))
    *way, last = draw(st.sampled_from(places(data)))
    target = data
    for key in way:
        target = target[key]
    match draw(st.sampled_from(["replace", "replace", "remove", "add"])):
        case "replace":
            target[last] = copy.deepcopy(draw(st.sampled_from(VALUES)))
        case "remove":
            del target[last]
        case "add" if isinstance(target, dict):
            target[draw(st.sampled_from(["extra", "if_any", "at_least", "by", "refines", "sha256"]))] = draw(
                st.sampled_from(VALUES)
            )
        case _:
            target.append(copy.deepcopy(draw(st.sampled_from(VALUES))))
    return name, data


@settings(max_examples=amount(14, 120), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(reshaped())
def test_the_reader_and_the_schema_agree(case: tuple[str, Any]) -> None:
    """The reader checks shapes by itself, with places; the schema says the same to others. Which methods there are, the project says, and no schema of shapes."""
    name, data = case
    text = yaml.safe_dump(data, allow_unicode=True, sort_keys=False)
    with folder_of({**FILES, name: text.encode()}) as folder:
        found: list[Finding] = []
        requirements.load(Path(folder), found)
    found = [finding for finding in found if "is no method of verification" not in finding.message]
    errors = [error.message for error in VALIDATOR.iter_errors(data)]
    assert bool(found) == bool(errors), f"reader: {[str(f) for f in found]}; schema: {errors}"


@settings(max_examples=amount(4, 30), deadline=None)
@given(st.randoms(use_true_random=False))
def test_the_matrix_is_a_pure_function(rng: random.Random) -> None:
    """Any choice of the records, in any order, twice: the same bytes."""
    kinds: Sequence[list[Any]] = Small().parts()
    chosen = [rng.sample(part, rng.randint(0, len(part))) for part in kinds]
    items, tests, results, runs = chosen
    first = trace.build(PROJECT, items, tests, results, runs, TODAY)
    items, tests, results, runs = (rng.sample(part, len(part)) for part in chosen)
    second = trace.build(PROJECT, items, tests, results, runs, TODAY)
    for kind in trace.FORMATS:
        assert trace.render(first, kind) == trace.render(second, kind)
    assert first.passes == (trace.gate(first) == [])


def many(root: Path, number: int, parents: Any = lambda n: "S-1") -> None:
    """A project of `number` requirements, each with one metric, on a vehicle with one interface."""
    folder = root / "requirements"
    folder.mkdir()
    ids = ["S-1", *(f"R-{n}" for n in range(number))]
    lines = ["document: requirements", "title: many", "requirements:"]
    for n, id_ in enumerate(ids):
        above = f"refines: [{parents(n - 1)}]" if n else "derived_from: [AV]"
        lines += [
            f"  - id: {id_}", f"    title: Requirement {n}", f"    statement: In case {n} the vehicle shall stay within its limits.",
            "    rationale: Because something could happen otherwise.", f"    {above}", "    status: approved", "    asil: D",
            "    verification: [test]", f"    metrics: [rule_{n}]", "    source: a book",
        ]  # fmt: skip
    (folder / "all.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    model = {
        "document": "system-model", "title": "t", "subsystems": [{"id": "AV", "title": "t", "role": "vehicle", "description": "d"}],
        "interfaces": [{"id": "AV", "title": "t", "issues": [{"id": "AV.1", "text": "t", "leads_to": ["S-1"]}]}],
    }  # fmt: skip
    stage = {"title": "t", "shows": "s", "applies_to": ["*"]}
    v_model = {
        "document": "v-model", "title": "t",
        "project": {
            "name": "many", "specs": ["specs"], "default_spec": "specs",
            "scenarios": [{"path": "run.jsonl", "stage": "S-4", "expect": "ground_truth", "origin": "synthetic"}],
        },
        "stages": [
            {"id": "S-1-A", "counts": ["interface", "parent"], **stage}, {"id": "S-2-B", "counts": ["rule"], **stage},
            {"id": "S-3-B", "counts": ["test"], **stage}, {"id": "S-4", "counts": ["run"], **stage},
        ],
    }  # fmt: skip
    for name, data in (("model.yaml", model), ("v-model.yaml", v_model)):
        (folder / name).write_text(json.dumps(data), encoding="utf-8")
    (root / "run.jsonl").write_text("{}\n", encoding="utf-8")


def rules(
    number: int, run_hash: str
) -> tuple[list[SpecItem], list[SpecTest], list[TestResult], list[RunSummary]]:
    ids = ["S-1", *(f"R-{n}" for n in range(number))]
    items = [
        SpecItem("rule", f"rule_{n}", "t", (Ref(id_, n + 1, 5),), (), "a.spec", n + 1, 1, "f")
        for n, id_ in enumerate(ids)
    ]
    kinds = (("on", "satisfied", True), ("in", "satisfied", False), ("out", "violated", False))
    tests = [
        SpecTest(item.name, title, expects, edge, "a.spec", item.line, 1)
        for item in items
        for title, expects, edge in kinds
    ]
    results = [TestResult(t.rule, t.title, "passed", "f", "", "a.spec", t.line) for t in tests]
    facts = tuple(
        RuleFacts(item.name, "f", {"driving": {"satisfied": 9, "violated": 1}}, 1.0, 1) for item in items
    )
    run = RunSummary(
        "run.jsonl", run_hash, "s", 10, facts, {"all": TruthFacts(True)}, True, "2026-01-01T00:00:00+00:00"
    )
    return items, tests, results, [run]


@pytest.mark.acceptance
def test_thousands_of_requirements(tmp_path: Path, record_property: pytest.Function) -> None:
    from hashlib import sha256

    number = amount(3_000, 10_000)
    many(tmp_path, number)
    parts = rules(number, sha256(b"{}\n").hexdigest())
    start = process_time()
    matrix = trace.build(tmp_path, *parts, date(2026, 1, 1))
    took = process_time() - start
    record_property("seconds", round(took, 2))  # type: ignore[operator]
    print(f"{number} requirements, {3 * number} tests: {took:.2f} s")
    assert [f.code for f in matrix.findings] == ["T220"]  # there is no baseline
    assert len(matrix.rows) == number + 1
    assert matrix.coverage["S-3-B"]["covered"] == number + 1
    assert matrix.coverage["S-4"]["covered"] == number + 1


#: More than Python lets functions call each other.
DEEP = amount(2000, 5000)


def test_a_ring_of_thousands(tmp_path: Path) -> None:
    """Requirements that refine each other in a ring: one finding with the path, and no recursion anywhere."""
    many(tmp_path, DEEP, parents=lambda n: f"R-{(n + 1) % DEEP}")
    matrix = trace.build(tmp_path, [], [], [], [], TODAY)
    rings = [f for f in matrix.findings if f.code == "T138"]
    assert [f.message for f in rings] == [
        f"requirements refine each other in a circle: R-0 -> R-1 -> R-2 -> R-3 -> ({DEEP - 6} more) -> R-{DEEP - 2} -> R-{DEEP - 1} -> R-0"
    ]
    assert len(matrix.rows) == DEEP + 1
    trace.render(matrix, "text")


def test_a_chain_of_thousands(tmp_path: Path) -> None:
    """A deep chain is no ring: what is open at its end shows at its top."""
    many(tmp_path, DEEP, parents=lambda n: f"R-{n - 1}" if n else "S-1")
    items, tests, results, _ = rules(DEEP, "")
    failed = [
        TestResult(r.rule, r.title, "failed", "f", "", r.file, r.line) if r.rule == f"rule_{DEEP}" else r
        for r in results
    ]
    matrix = trace.build(tmp_path, items, tests, failed, [], TODAY)
    assert not [f for f in matrix.findings if f.code == "T138"]
    assert {row.cells["S-3-B"].status for row in matrix.rows} == {"failed"}
