"""The document of the safety case read back: its visible texts, its numbers with their ids, its places and links; and a small project that has one."""

from __future__ import annotations

import json
import re
import shutil
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import yaml

from support.project import command
from trackmarshal.cli.assessment import assess
from trackmarshal.meaning.tool import tool
from trackmarshal.trace.gsn.building import build

WAREHOUSE = Path(__file__).parents[1] / "golden" / "trace" / "warehouse"
DAY = "2026-06-02"
#: Elements of HTML that have no end.
VOID = {"meta", "br", "hr", "img", "input", "link"}
NUMBER = re.compile(r"[0-9]+(?:[.,][0-9]+)*")


@dataclass
class Page(HTMLParser):
    """What a reader sees. numbers: id and text of those that carry an id; texts: all else, block by block; formulas apart."""

    html: str
    texts: list[str] = field(default_factory=list)
    numbers: list[tuple[str, str]] = field(default_factory=list)
    ids: list[str] = field(default_factory=list)
    targets: list[str] = field(default_factory=list)
    tags: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self._open: list[str] = []
        self._number: str | None = None
        self.feed(re.sub(r"<math.*?</math>|<svg.*?</svg>", " ", self.html, flags=re.DOTALL))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        said = dict(attrs)
        self.tags.add(tag)
        if said.get("id"):
            self.ids.append(str(said["id"]))
        if tag == "a" and said.get("href"):
            self.targets.append(str(said["href"]))
        if tag not in VOID:
            self._open.append(tag)
        self._number = said.get("data-number")

    def handle_endtag(self, tag: str) -> None:
        while self._open and self._open.pop() != tag:
            pass
        self._number = None

    def handle_data(self, data: str) -> None:
        if not data.strip() or "style" in self._open or "title" in self._open:
            return
        if self._number is not None:
            self.numbers.append((self._number, data.strip()))
        else:
            self.texts.append(" ".join(data.split()))

    @property
    def formulas(self) -> list[str]:
        return re.findall(r"<math.*?</math>", self.html, flags=re.DOTALL)

    @property
    def first(self) -> str:
        """What stands before the table of contents."""
        return self.html.partition("<nav")[0]


def made_ready(folder: Path) -> Path:
    """The warehouse, accepted, with its evidence."""
    project = folder / "warehouse"
    shutil.copytree(WAREHOUSE, project)
    status, _, err = command(
        project, "trace", "--accept-baseline", "--by", "Maria Motor", "--reason", "the first one", "--quiet"
    )
    assert status == 0, err
    return project


def html(project: Path, *arguments: str, expect: int | None = None) -> Page:
    out = project / "out" / "case"
    unsaid = (("--day", DAY), ("--format", "html"))
    given = [word for option in unsaid if option[0] not in arguments for word in option]
    status, _, err = command(project, "case", "--out", str(out), *given, *arguments)
    assert expect is None or status == expect, err
    assert status in (0, 1), err
    return Page((out / "safety-case.html").read_text("utf-8"))


def edit(project: Path, file: str, old: str, new: str) -> None:
    path = project / file
    text = path.read_text("utf-8")
    assert text.count(old) == 1, f"{old!r} is {text.count(old)} times in {file}"
    path.write_text(text.replace(old, new), "utf-8")


def graph_numbers(project: Path) -> dict[str, str]:
    """Numbers under the ids of the document, counted here from what `trace --format json` says."""
    _, out, _ = command(project, "trace", "--as-is", "--format", "json", "--day", DAY)
    said = json.loads(out)
    found = Counter[str]()
    for stage, counts in said["coverage"].items():
        for what, number in counts.items():
            found[f"stages/{stage}/{'all' if what == 'of' else what}"] = number
    for finding in said["findings"]:
        found[f"findings/{finding['level']}/all"] += 1
    documents = [
        yaml.safe_load(path.read_text("utf-8")) for path in (project / "requirements").glob("*.yaml")
    ]
    found["nodes/requirement/all"] = sum(
        len(one.get("requirements", ())) for one in documents
    )  # obsolete ones too
    for kind, name in (
        ("rule", "rules"),
        ("test", "tests"),
        ("assumption", "assumptions"),
        ("result", "test_results"),
    ):
        found[f"nodes/{kind}/all"] = said["counts"][name]
    found["nodes/test/passed"] = sum(
        1 for link in said["links"] if link["kind"] == "result" and link["source"] == "passed"
    )
    found["nodes/stage/all"] = len(said["stages"])
    for kind in ("rule", "assumption"):  # of which nobody reviews any
        number = said["counts"][f"{kind}s"]
        if number:
            found[f"unreviewed/{kind}"] = found[f"read/{kind}"] = number
    for kind, ids in _read(documents).items():
        open_ = ids - {one["id"] for document in documents for review in document.get("reviews", ()) for one in review["of"]}  # fmt: skip
        if open_:
            found[f"unreviewed/{kind}"], found[f"read/{kind}"] = len(open_), len(ids)
    return {id_: str(number) for id_, number in found.items()}


def _read(documents: Sequence[Mapping[str, Any]]) -> dict[str, set[str]]:
    """By kind, the ids of what a second person is expected to read; reviews of an older version are not told apart."""
    fields = {
        "operational design domain": "domains", "interface": "interfaces", "hazard": "hazards", "safety goal": "safety_goals", "analysis": "analyses",
        "requirement": "requirements", "design element": "elements", "tool": "tools", "malfunction": "malfunctions",
    }  # fmt: skip
    return {
        kind: {one["id"] for document in documents for one in document.get(field, ()) if one.get("status") != "obsolete"}
        for kind, field in fields.items()
    }  # fmt: skip


def corpus(project: Path, page: Page, rules: bool = True) -> str:
    """All that the project says, and the program of it: files, matrix, argument, and rules for readers where they are asked for; blanks as one.

    Of outputs in JSON, the texts; a name in backquotes is told apart in the document, so that these count as blanks.
    """
    found, day = assess(project, run=False), date.fromisoformat(DAY)
    texts = [*strings(json.loads(command(project, "trace", "--as-is", "--day", DAY, "--format", "json")[1]))]
    case = build(found.matrix(day), found.project, project)
    texts += [text for element in case.elements.values() for text in (element.id, element.text)]
    texts += [f"{finding.code} {finding.message}" for finding in case.findings]
    texts += [
        path.read_text("utf-8")
        for path in sorted(project.rglob("*"))
        if path.suffix in (".yaml", ".spec", ".json")
    ]
    texts += [
        text for text in page.texts if re.fullmatch(r"[0-9a-f]{40}|[0-9a-f]{64}|trackmarshal \d.*", text)
    ]
    if rules:
        for rule in re.findall(r"^rule (\w+)", "\n".join(texts), re.MULTILINE):
            texts.append(command(project, "show", rule, "--format", "json")[1])
    texts += [f"{test.distance} {test.within}" for test in found.facts.tests]
    commands = f"trackmarshal trace --gate --rerun trackmarshal case --day {DAY} --out DIR"
    return " ".join("\n".join([*texts, tool(), DAY, commands]).replace("`", " ").split())


def strings(value: object) -> Iterator[str]:
    """All texts in a value from JSON, and numbers as texts."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield str(name)
            yield from strings(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from strings(inner)
    else:
        yield str(value)


def is_place(project: Path, text: str) -> bool:
    """Whether a text is a place in a file of the project that is there."""
    found = re.fullmatch(r"([\w./-]+):([1-9]\d*)(?::\d+)?", text)
    if found is None or not (project / found[1]).is_file():
        return False
    return int(found[2]) <= len((project / found[1]).read_text("utf-8").splitlines())
