"""docs/link-graph.md: its tables of kinds and fields are those that the program reads, its questions have the answers that it shows.

`TRACKMARSHAL_UPDATE_GOLDEN=1 pytest tests/golden` writes the tables anew.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
from pathlib import Path

import pytest
import yaml

from golden.trace.cases import HERE
from support.project import command
from trackmarshal.trace.documents_safety import ASSURANCE, DESIGN, HAZARDS, LINK_SCHEMA
from trackmarshal.trace.graph import schema
from trackmarshal.trace.graph.kinds import LINKS, NODES
from trackmarshal.trace.shapes import Count, Date, Flag, Many, Record, Shape, Text, Word

PAGE = Path(__file__).parents[2] / "docs" / "link-graph.md"
UPDATE = os.environ.get("TRACKMARSHAL_UPDATE_GOLDEN") == "1"
TABLES = "## Kinds of nodes\n"


def tables() -> str:
    """All that follows the page's own words."""
    lines = [TABLES, "| kind | |", "|---|---|", *(f"| {kind} | {what} |" for kind, what in NODES.items()), ""]
    lines += [
        "## Kinds of links",
        "",
        "`of` is the same link as its target sees it. The end that is below is in bold letters.",
        "",
    ]
    lines += ["| link | stands at | leads to | of |", "|---|---|---|---|"]
    for name, kind in LINKS.items():
        at, to = (" or ".join(ends) or "anything" for ends in (kind.sources, kind.targets))
        at, to = (at, f"**{to}**") if kind.down else (f"**{at}**", to)
        lines.append(f"| `{name}` | {at} | {to} | `{kind.converse}` |")
    lines += ["", "## Fields", "", "Also in `requirements/schema.json`. Fields in brackets may be left out."]
    for document in (LINK_SCHEMA, HAZARDS, DESIGN, ASSURANCE):
        for record in below(document):
            lines += [
                "",
                f"### {document.name}{'' if record is document else f': {record.name}'}",
                "",
                record.description,
                "",
            ]
            lines += ["| field | | |", "|---|---|---|"]
            for field in record.fields:
                name = f"`{field.name}`" if field.required else f"[`{field.name}`]"
                lines.append(f"| {name} | {wanted(field.shape)} | {field.description} |".replace("  ", " "))
    return "\n".join(lines) + "\n"


def below(record: Record, seen: list[Record] | None = None) -> list[Record]:
    """A record, and those inside of it, each once."""
    found = [] if seen is None else seen
    if record not in found:
        found.append(record)
        for field in record.fields:
            shape = field.shape.of if isinstance(field.shape, Many) else field.shape
            if isinstance(shape, Record):
                below(shape, found)
    return found


def wanted(shape: Shape) -> str:
    match shape:
        case Text(said=said):
            return said
        case Word(choices=choices) if len(choices) > 12:
            return "a kind, as in the tables above"
        case Word(choices=choices):
            return ", ".join(
                f"`{word}`" + (f" ({meaning})" if meaning else "") for word, meaning in choices.items()
            )
        case Count():
            return "a whole number"
        case Date():
            return "a day"
        case Flag():
            return "true or false"
        case Many(of=inner):
            return f"list of {wanted(inner)}"
        case Record(name=name):
            return f"*{name}*"
        case _:
            raise TypeError(shape)


def test_the_tables_are_those_of_the_program() -> None:
    page = PAGE.read_text("utf-8")
    own, _, shown = page.partition(TABLES)
    if UPDATE:
        PAGE.write_text(own + tables(), "utf-8")
        return
    assert TABLES + shown == tables()


def test_the_questions_have_these_answers(tmp_path: Path) -> None:
    root = tmp_path / "project"
    shutil.copytree(HERE / "warehouse", root)
    command(root, "trace", "--accept-baseline")
    assert command(root, "trace", "--gate")[0] == 0
    found = re.findall(r"```sh\n(.*?)```\n(?:\n```text\n(.*?)```)?", PAGE.read_text("utf-8"), re.DOTALL)
    assert len(found) == 4
    for line, expected in found:
        program, *arguments = shlex.split(line)
        assert program == "trackmarshal"
        status, out, err = command(root, *arguments)
        assert status == 0, err
        assert not expected or out == expected


def schemas() -> list[str]:
    """The schemas that the page shows: that of the warehouse, and one of methods and reviews."""
    return re.findall(r"```yaml\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)


def test_the_methods_that_are_named_are_those_of_the_program() -> None:
    rows = (
        PAGE.read_text("utf-8").partition("| method | is answered by |\n|---|---|\n")[2].partition("\n\n")[0]
    )
    named = [name for row in rows.split("\n") for name in re.findall("`([^`]*)`", row.split("|")[1])]
    own = yaml.safe_load(schema.DEFAULT.read_text("utf-8"))["methods"]
    assert sorted(named) == sorted(method["name"] for method in own)
    without = {method["name"] for method in own if "any_of" not in method}
    assert (
        f"| {', '.join(f'`{name}`' for name in sorted(without, reverse=True))} | evidence that names" in rows
    )


def test_a_project_has_methods_and_reviews_of_its_own(tmp_path: Path) -> None:
    """As the page shows them, in the warehouse: other words, other evidence, other things to be reviewed."""
    root = tmp_path / "project"
    shutil.copytree(HERE / "warehouse", root)
    (root / "requirements" / "links.yaml").write_text(schemas()[1], "utf-8")
    assert command(root, "trace", "--accept-baseline")[0] == 0
    status, out, err = command(root, "trace", "--gate", "--format", "json")
    said = json.loads(out)
    assert (status, said["verdict"]) == (0, "pass with reservations"), out + err
    assert [(one["kind"], one["id"]) for one in said["unreviewed"]] == [
        ("requirement", "SW-1"), ("rule", "slow_near_people"), ("rule", "gentle"),
    ]  # fmt: skip
    needs = root / "requirements" / "needs.yaml"
    text = needs.read_text("utf-8")
    for word, found in (("wind tunnel", ("T255", "SYS-2:wind tunnel")), ("review", ("T123", None))):
        first, second, rest = text.split("verification: [test]", 2)  # nobody has reviewed the second one
        needs.write_text(f"{first}verification: [test]{second}verification: [test, {word}]{rest}", "utf-8")
        status, out, _ = command(root, "trace", "--gate", "--format", "json")
        assert [(f["code"], f["subject"]) for f in json.loads(out)["findings"] if f["level"] != "note"] == [
            found
        ]
        assert status == 1


def test_the_schema_that_is_shown_is_that_of_the_warehouse() -> None:
    shown, _ = schemas()
    assert yaml.safe_load(shown) == yaml.safe_load(
        (HERE / "warehouse" / "requirements" / "links.yaml").read_text("utf-8")
    )


@pytest.mark.parametrize("word", ["T134", "T139", "T150", "T202", "T207"])
def test_codes_of_needs_are_named(word: str) -> None:
    assert f"({word}" in PAGE.read_text("utf-8")
