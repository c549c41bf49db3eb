"""What is known is not run again, and what was written by hand does not stay."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

from support.project import run_command
from support.start import new_project
from trackmarshal.cli import evidence, recordings, sources
from trackmarshal.cli.answers import Answers
from trackmarshal.cli.assessment import assess
from trackmarshal.records.runs import RunSummary
from trackmarshal.store import FILE
from trackmarshal.trace import requirements


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new project in a folder of its own, which is the current one, with a cache of its own."""
    root = tmp_path / "car"
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    new_project(root, tmp_path / "cache")
    monkeypatch.chdir(root)
    return root


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is run, as it is run: tests by rule and title, scenarios, faults."""
    ran: list[str] = []
    whole = sources.Sources

    class Listening(whole):  # type: ignore[misc, valid-type]
        def __init__(self, *args):  # type: ignore[no-untyped-def]
            ran.append("compiled")
            super().__init__(*args)

        def test(self, wanted, facts):  # type: ignore[no-untyped-def]
            for result in super().test(wanted, facts):
                ran.append(f"{result.rule}: {result.title}")
                yield result

        def replay(self, shown, *args):  # type: ignore[no-untyped-def]
            ran.append(shown)
            return super().replay(shown, *args)

    monkeypatch.setattr("trackmarshal.cli.assessment.Sources", Listening)
    return ran


def gate(*more: str) -> tuple[int, str]:
    status, out, err = run_command("trace", "--gate", "--verbose", *more)
    return status, out + err


def entries(root: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in (root / "out/results" / FILE).read_bytes().splitlines()]


def test_an_unchanged_project_answers_from_the_store(project: Path, made: list[str]) -> None:
    first = gate()
    assert first[0] == 0
    assert len(made) > 3
    assert made[0] == "compiled"
    held = (project / "out/results" / FILE).read_bytes()
    made.clear()
    assert gate() == first
    assert made == []
    assert (project / "out/results" / FILE).read_bytes() == held


def test_a_kept_run_is_that_of_its_own_scenario(project: Path) -> None:
    """The file is written elsewhere, and checked in: of a scenario that is replayed here, what stands in it is not asked."""
    assert gate()[0] == 0
    (run,) = (entry["result"] for entry in entries(project) if entry["kind"] == "run")
    assert isinstance(run, dict)
    later = RunSummary.from_json({**run, "created": "2999-01-01T00:00:00+00:00", "fired": not run["fired"]})
    evidence.keep(project / "docs/drive.json", "runs", [later, replace(later, scenario="docs/drive.yaml")])
    model = project / "requirements/v-model.yaml"
    drive = "{path: docs/drive.yaml, title: A drive, stage: S-4-A, expect: no_fire, origin: field, kept: docs/drive.json}"
    text = model.read_text("utf-8").replace("  scenarios:\n", f"  scenarios:\n    - {drive}\n")
    model.write_text(text, "utf-8")
    found = {one.scenario: one.fired for one in assess(project, run=False).runs}
    assert found == {run["scenario"]: run["fired"], "docs/drive.yaml": not run["fired"]}


def test_another_limit_is_no_other_rule(project: Path) -> None:
    """A test says that the parameter changed; a run knows no more than that its rule rests on something else."""
    gate()
    spec = project / "specs/speed.spec"
    text = spec.read_text("utf-8")
    spec.write_text(
        re.sub(r"(param v_event[^=]*= *)(\d+)", lambda found: f"{found[1]}{int(found[2]) + 1}", text), "utf-8"
    )
    assert spec.read_text("utf-8") != text
    _, out, _ = run_command("trace", "--as-is", "--verbose")
    assert "the parameter `speed.v_event` has changed since" in out
    assert "is stale: the rule `speed_limit`, or something that it reads, has changed since" in out


def test_another_track_is_another_run(project: Path, made: list[str]) -> None:
    """What a scenario names is not in its own file."""
    assert gate()[0] == 0
    path = project / "specs/tracks/straight.yaml"
    text = path.read_text("utf-8")
    path.write_text(text.replace("width: 10", "width: 11"), "utf-8")
    _, out, _ = run_command("trace", "--as-is", "--verbose")
    assert "a file that the scenario names has changed since" in out
    made.clear()
    gate()
    assert [name for name in made if "scenarios" in name] == ["specs/scenarios/too_fast.yaml"]
    path.write_text(text, "utf-8")
    made.clear()
    assert gate()[0] == 0
    assert made == ["compiled"]


def test_another_track_is_another_run_of_all_that_name_it(project: Path, made: list[str]) -> None:
    """Each of them, in whatever order they are read: none relies on another one having opened the file."""
    scenarios, document = project / "specs/scenarios", project / "requirements/v-model.yaml"
    text = (scenarios / "too_fast.yaml").read_text("utf-8")
    declared = document.read_text("utf-8")
    begin = declared.index("    - path: specs/scenarios/too_fast.yaml")
    one = re.match(r"    - .*\n(?:      .*\n)*", declared[begin:])[0]  # type: ignore[index]
    for name in ("again", "zealous"):
        (scenarios / f"{name}.yaml").write_text(text.replace("name: too_fast", f"name: {name}"), "utf-8")
    again, zealous = (
        one.replace("too_fast", name).replace("title: ", f"title: {name} ") for name in ("again", "zealous")
    )
    document.write_text(declared.replace(one, again + one + zealous), "utf-8")
    assert gate()[0] == 0
    path = project / "specs/tracks/straight.yaml"
    path.write_text(path.read_text("utf-8").replace("width: 10", "width: 11"), "utf-8")
    made.clear()
    gate()
    assert sorted(name for name in made if "scenarios" in name) == [
        f"specs/scenarios/{name}.yaml" for name in ("again", "too_fast", "zealous")
    ]


def test_what_changed_is_run_again_and_what_comes_back_is_known(project: Path, made: list[str]) -> None:
    gate()
    path = project / "specs/speed.spec"
    text = path.read_text("utf-8")
    titles = {name for name in made if name.startswith("speed_limit: ")}
    path.write_text(text.replace("p.v <= v_event", "p.v < v_event"), "utf-8")
    made.clear()
    gate()
    assert titles < set(made)
    assert any("scenarios" in name for name in made)
    path.write_text(text, "utf-8")
    made.clear()
    assert gate()[0] == 0
    assert made == ["compiled"]
    path.write_text("-- a comment\n" + text, "utf-8")
    made.clear()
    assert gate()[0] == 0
    assert made == ["compiled"]


def test_an_entry_says_from_what_by_what_and_where_it_was_made(project: Path) -> None:
    gate()
    for one in entries(project):
        assert str(one["tool"]).startswith("trackmarshal ")
        assert "Python" in str(one["platform"])
        assert str(one["made"])[4] == "-"
        assert isinstance(one["inputs"], dict)
        assert all(len(value) in (64, 39, 34) or " " in value for value in one["inputs"].values())
    (run,) = [one for one in entries(project) if one["kind"] == "run"][:1]
    assert isinstance(run["params"], dict)
    assert run["params"]


def test_a_result_that_was_edited_is_named_and_run_again(project: Path, made: list[str]) -> None:
    gate()
    path = project / "out/results" / FILE
    path.write_bytes(path.read_bytes().replace(b'"outcome": "passed"', b'"outcome": "failed"', 1))
    made.clear()
    status, said = gate()
    assert status == 1
    assert said.count("error[T293]") == 1
    assert len(made) == 2  # compiled, and the one test
    assert gate()[0] == 1, "it is named until somebody removes it"


def _forged(path: Path) -> None:
    """Make a failed test pass in the store, with its hash made again."""
    lines = path.read_bytes().splitlines()
    at = next(number for number, line in enumerate(lines) if b'"outcome": "failed"' in line)
    said = json.loads(lines[at].replace(b'"outcome": "failed"', b'"outcome": "passed"'))
    said.pop("id")
    said["result"]["message"] = ""
    rest = json.dumps(said, ensure_ascii=False, sort_keys=True)[1:].encode()
    lines[at] = b'{"id": "' + sha256(rest).hexdigest().encode() + b'", ' + rest
    path.write_bytes(b"\n".join(lines) + b"\n")


@pytest.mark.parametrize("kind", ["test", "run"])
@pytest.mark.parametrize("result", [{}, {"outcome": 5, "cycles": "many"}])
def test_a_result_of_another_shape_is_named_and_run_again(
    kind: str, result: dict[str, object], project: Path, made: list[str]
) -> None:
    """As one of another version of the program, whose hash is fine: it was an error without a place."""
    gate()
    path = project / "out/results" / FILE
    lines = path.read_bytes().splitlines()
    at = next(number for number, line in enumerate(lines) if json.loads(line)["kind"] == kind)
    said = {**json.loads(lines[at]), "result": result}
    said.pop("id")
    rest = json.dumps(said, ensure_ascii=False, sort_keys=True)[1:].encode()
    lines[at] = b'{"id": "' + sha256(rest).hexdigest().encode() + b'", ' + rest
    path.write_bytes(b"\n".join(lines) + b"\n")
    made.clear()
    told = f"out/results/evidence.jsonl:{at + 1}: error[T293]: an entry of the evidence store was changed or cut: it is no entry of this version"
    for more, again in (("--as-is",), 0), ((), 2):
        status, text = gate(*more)
        assert (status, text.count("error[T29"), text.count(told), len(made)) == (1, 1, 1, again), text
    assert "T230" not in text, "what came out now counts"


def test_a_forged_result_is_found_by_running_everything_again(project: Path) -> None:
    path = project / "specs/speed.spec"
    path.write_text(path.read_text("utf-8").replace("expect violated", "expect satisfied", 1), "utf-8")
    assert gate()[0] == 1
    _forged(project / "out/results" / FILE)
    forged = gate()
    assert "T293" not in forged[1]
    assert "T215" not in forged[1]
    status, said = gate("--rerun")
    assert status == 1
    assert said.count("error[T294]") == 1
    assert said.count("error[T215]") == 1
    assert "T215" in gate()[1], "what came out now is what counts"


def test_the_facts_that_are_kept_are_those_of_the_files_as_they_are(project: Path, made: list[str]) -> None:
    """A file more, a file less, another text: each is seen without anything being told of it."""
    gate()
    spec = project / "specs/more"
    spec.mkdir()
    steps: list[Callable[[], object]] = [
        lambda: (spec / "extra.spec").write_text("module extra\nuse speed\n", "utf-8"),
        (spec / "extra.spec").unlink,
        lambda: (project / "specs/speed.spec").write_text(
            (project / "specs/speed.spec").read_text("utf-8") + "\n-- x\n", "utf-8"
        ),
        lambda: (project / "requirements/requirements.yaml").write_text(
            (project / "requirements/requirements.yaml").read_text("utf-8") + "# x\n", "utf-8"
        ),
    ]
    for number, step in enumerate(steps):
        made.clear()
        step()
        gate()
        assert made[:1] == ["compiled"], number
        made.clear()
        gate()
        assert made == [], number


def test_a_spec_that_is_written_while_its_tests_are_run_leaves_no_evidence(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The facts were those of a test that fails, the result that of the text that was saved meanwhile: it was green for good once that was undone."""
    spec = project / "specs/speed.spec"
    right = spec.read_text("utf-8")
    wrong = right.replace("expect satisfied, margin 5 m/s", "expect violated")
    assert wrong != right
    spec.write_text(wrong, "utf-8")
    gate("--as-is")  # keeps the facts
    whole = sources.Sources

    def late(*args: Any) -> sources.Sources:
        spec.write_text(right, "utf-8")
        return whole(*args)

    monkeypatch.setattr("trackmarshal.cli.assessment.Sources", late)
    code, text = gate()
    assert code == 1, "on the facts of one text and the results of another"
    told = "specs/speed.spec: error[T296]: `specs/speed.spec` was written while it was read: no result is kept as evidence"
    assert told in text
    assert not (project / "out/results" / FILE).exists()
    monkeypatch.setattr("trackmarshal.cli.assessment.Sources", whole)
    spec.write_text(wrong, "utf-8")
    assert gate()[0] == 1
    spec.write_text(right, "utf-8")
    assert gate()[0] == 0


def test_a_scenario_that_is_written_behind_its_reading_leaves_no_evidence(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What was replayed is not what is hashed then."""
    scenario, whole = project / "specs/scenarios/too_fast.yaml", recordings.recorded

    def late(*args: Any) -> Any:
        found = whole(*args)
        scenario.write_text(scenario.read_text("utf-8") + "# another\n", "utf-8")
        return found

    monkeypatch.setattr("trackmarshal.cli.recordings.recorded", late)
    assert "`specs/scenarios/too_fast.yaml` was written while it was read" in gate()[1]
    assert not (project / "out/results" / FILE).exists()
    monkeypatch.setattr("trackmarshal.cli.recordings.recorded", whole)
    gate()
    (run,) = (entry for entry in entries(project) if entry["kind"] == "run")
    assert run["inputs"]["recording"] == evidence.file_hash(scenario)  # type: ignore[index]


def test_nothing_is_accepted_of_documents_that_are_written_while_they_are_read(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The requirements of before would be held against the specs of behind."""
    document, load = project / "requirements/requirements.yaml", requirements.load

    def late(*args: Any, **named: Any) -> Any:
        found = load(*args, **named)
        document.write_text(document.read_text("utf-8") + "# another\n", "utf-8")
        return found

    baseline = project / "requirements/baseline.json"
    before = baseline.read_bytes() if baseline.exists() else b""
    monkeypatch.setattr(requirements, "load", late)
    for option in ("--as-is", "--rerun"):
        assert (
            "error[T296]: `requirements/requirements.yaml` was written while it was read" in gate(option)[1]
        )
    status, _, err = run_command("trace", "--accept-baseline", "--by", "A. Tester", "--reason", "to try")
    assert status == 2
    assert "no baseline is accepted: `requirements/requirements.yaml` was written" in err
    assert (baseline.read_bytes() if baseline.exists() else b"") == before


def test_another_process_may_add_to_the_store_meanwhile(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two jobs on one folder: the store only grows."""
    gate()
    store = project / "out/results" / FILE
    line = store.read_bytes().splitlines(keepends=True)[0]
    whole = Answers.known

    def late(self: Answers, *args: Any) -> Any:
        with store.open("ab") as stream:
            stream.write(line)
        return whole(self, *args)

    monkeypatch.setattr(Answers, "known", late)
    assert gate()[0] == 0


def test_facts_that_were_changed_in_the_cache_are_not_used(
    project: Path, made: list[str], tmp_path: Path
) -> None:
    first = gate()
    (path,) = (tmp_path / "cache").glob("facts-*.json")
    path.write_bytes(path.read_bytes().replace(b'"satisfies"', b'"satisfied"', 1))
    made.clear()
    assert gate() == first
    assert made == ["compiled"]


def test_evidence_that_cannot_be_kept_names_the_way_to_read_what_is_there(project: Path) -> None:
    """A folder that may not be written, as where somebody looks at the project of another."""
    (project / "out").symlink_to(project / "nowhere" / "at all")
    status, told = gate()
    assert (status, "error[E411]: the evidence cannot be kept" in told) == (2, True)
    assert "evidence.jsonl" in told
    assert "`trackmarshal trace --as-is`" in told
    assert gate("--as-is")[0] == 1
