"""docs/gsn.md: its examples run as they stand, its tables are those that the program reads.

`TRACKMARSHAL_UPDATE_GOLDEN=1 pytest tests/golden` writes what comes out anew.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
from pathlib import Path

import pytest
import yaml

from golden.test_link_page import below, wanted
from golden.trace.cases import HERE
from support.project import command
from trackmarshal.trace.documents_argument import ARGUMENT
from trackmarshal.trace.gsn.codes import CODES

PAGE = Path(__file__).parents[2] / "docs" / "gsn.md"
UPDATE = os.environ.get("TRACKMARSHAL_UPDATE_GOLDEN") == "1"
FIELDS = "## Fields\n\nAlso in `requirements/schema.json`. Fields in brackets may be left out.\n"
#: A document, or a command with what it prints, where that is shown.
_PIECE = re.compile(r"```yaml\n(?P<yaml>.*?)```|```sh\n(?P<sh>.*?)```(?:\n\n```text\n(?P<text>.*?)```)?", re.DOTALL)  # fmt: skip


def fields() -> str:
    lines = [FIELDS.rstrip()]
    for record in below(ARGUMENT):
        name = "argument" if record is ARGUMENT else f"argument: {record.name}"
        lines += ["", f"### {name}", "", record.description, "", "| field | | |", "|---|---|---|"]
        for field in record.fields:
            called = f"`{field.name}`" if field.required else f"[`{field.name}`]"
            said = wanted(field.shape).replace("a kind, as in the tables above", "a kind of things or of links ([link-graph.md](link-graph.md))")  # fmt: skip
            lines.append(f"| {called} | {said} | {field.description} |")
    return "\n".join(lines) + "\n"


def codes() -> str:
    rows = [f"| {code} | {title} |" for code, (title, _) in CODES.items()]
    return "\n".join(["| code | |", "|---|---|", *rows]) + "\n"


def test_the_tables_are_those_of_the_program() -> None:
    page = PAGE.read_text("utf-8")
    made = re.sub(r"\| code \| \|\n(\|.*\n)+", lambda _: codes(), page.partition(FIELDS)[0]) + fields()
    if UPDATE:
        PAGE.write_text(made, "utf-8")
    assert made == PAGE.read_text("utf-8")


def test_examples_print_what_they_show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = tmp_path / "project"
    shutil.copytree(HERE / "warehouse", root)
    monkeypatch.chdir(root)
    command(root, "trace", "--accept-baseline")
    page, made, end, ran = PAGE.read_text("utf-8"), "", 0, 0
    for piece in _PIECE.finditer(page):
        made += page[end : piece.start()]
        end = piece.end()
        if piece["yaml"]:
            (root / "requirements" / "argument.yaml").write_text(piece["yaml"], "utf-8")
            assert yaml.safe_load(piece["yaml"])["document"] == "argument"
            made += piece[0]
            continue
        program, *arguments = shlex.split(piece["sh"])
        assert program == "trackmarshal"
        status, out, err = command(root, *arguments)
        ran += 1
        assert status == ("error[" in err), err
        shown = out if not err or "--out" in arguments else f"{out}\n{err}"
        made += piece[0] if piece["text"] is None else f"```sh\n{piece['sh']}```\n\n```text\n{shown}```"
    made += page[end:]
    if UPDATE:
        PAGE.write_text(made, "utf-8")
    assert ran == 4
    assert made == PAGE.read_text("utf-8")
    assert list((root / "out" / "gsn").glob("*.svg"))


def test_templates_of_the_page_make_a_sound_argument(tmp_path: Path) -> None:
    root = tmp_path / "project"
    shutil.copytree(HERE / "warehouse", root)
    command(root, "trace", "--accept-baseline")
    *_, templates = re.findall(r"```yaml\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    (root / "requirements" / "argument.yaml").write_text(templates, "utf-8")
    status, out, err = command(root, "gsn", "--gate")
    assert status == 0, err
    assert "✓ G-Top: warehouse robot does what its customers were promised. [supported]" in out
