"""`trackmarshal show`: its forms and formats, its errors, and docs/show.md, whose commands print what stands there."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from support.length import at_length
from support.supervised import everything
from trackmarshal.cli.main import main

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "show.md"
UPDATE = os.environ.get("TRACKMARSHAL_UPDATE_GOLDEN") == "1"


@pytest.fixture(autouse=True)
def _here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


def shown(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(["show", *arguments]) == 0
    return capsys.readouterr().out


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(["show", *arguments]) == 2
    return capsys.readouterr().err


def blocks(page: str) -> Iterator[tuple[str, list[tuple[str, str]]]]:
    """Each block, and the commands in it with what stands below them."""
    for block in re.findall(r"```console\n(.*?)```", page, re.DOTALL):
        parts = re.split(r"^\$ (.*)\n", block, flags=re.MULTILINE)
        yield block, list(zip(parts[1::2], parts[2::2]))


def without_places(text: str) -> str:
    """Where in its file something is declared is not what the page is about."""
    return re.sub(r"\.spec:\d+:\d+", ".spec", text)


def test_the_page_shows_what_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("sympy")
    page = PAGE.read_text("utf-8")
    made = page
    for block, commands in blocks(page):
        told = ""
        for command, _ in commands:
            verb, *arguments = command.removeprefix("trackmarshal ").split()
            assert verb == "show"
            told += f"$ {command}\n{without_places(shown(capsys, *arguments))}"
        made = made.replace(block, told)
    if UPDATE:
        PAGE.write_text(made, "utf-8", newline="\n")
    assert len(list(blocks(page))) >= 6
    assert made == PAGE.read_text("utf-8")


@pytest.mark.parametrize(
    ("form", "first"),
    [
        ("spec", 'rule turn_radius "No turn is tighter than the steering allows"'), ("formula", "∀ p ∈ plan"),
        ("english", "For every sample p of plan: the magnitude of the curvature of p is at most 1 divided by R_min (11 m)."),
    ],
)  # fmt: skip
def test_one_form_is_nothing_but_that(form: str, first: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert shown(capsys, "turn_radius", "--as", form).splitlines()[0] == first


def test_c_is_what_is_compiled(capsys: pytest.CaptureFixture[str]) -> None:
    from trackmarshal.backends.c.source import generate

    spec = everything()
    rule = spec.rule("turn_radius")
    assert rule is not None
    (code,) = generate(spec, [rule]).rules
    assert shown(capsys, "turn_radius", "--as", "c") == f"{code.text.rstrip()}\n"


class Reader(HTMLParser):
    """What a page has: elements, addresses, ids; and whether all that was opened is closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: set[str] = set()
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href", "action")]
        if tag not in ("meta", "link", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.mark.parametrize("name", ["one_move", at_length("safe_side"), at_length("drive_acceleration")])
def test_a_page_stands_by_itself_with_all_four_forms(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    made = shown(capsys, name, "--format", "html", "--spec", "specs")
    page = Reader()
    page.feed(made)
    assert page.open == []
    assert not page.addresses
    assert {"math", "pre", "table"} <= page.tags
    assert not {"script", "link", "img", "iframe"} & page.tags
    for head in ("Spec", "Formula", "In words", "C"):
        assert f"<h2>{head}</h2>" in made
    assert shown(capsys, name, "--format", "html", "--spec", "specs") == made


def test_json_has_everything(capsys: pytest.CaptureFixture[str]) -> None:
    made: dict[str, Any] = json.loads(shown(capsys, "friction", "--json"))
    assert (made["rule"], made["satisfies"], made["language"]) == ("friction", ["S-1-A-4"], "en")
    assert {one["kind"] for one in made["formula"]["clauses"]} == {"each", "require"}
    assert {"text", "mathml", "typst"} <= set(made["formula"]["clauses"][0])
    mass = next(one for one in made["formula"]["parameters"] if one["name"] == "vehicles.devbot.mass")
    assert (mass["value"], mass["unit"], mass["written"], mass["overridden"]) == (
        1160.0,
        "kg",
        "1160 kg",
        False,
    )
    assert {"signal": "plan", "field": "kappa", "unit": "1/m"} in made["formula"]["inputs"]
    assert "tm_rule_friction" in made["c"]
    assert made["words"]["demand"][0].startswith("For every sample p of plan")


def test_a_configuration_is_in_force_and_said(capsys: pytest.CaptureFixture[str]) -> None:
    made = json.loads(
        shown(capsys, "turn_radius", "--as", "formula", "--json", "--with", "specs/vehicles/compact.spec")
    )
    (radius,) = made["formula"]["parameters"]
    assert radius["overridden"]
    assert radius["value"] != 11.0
    assert "specs/vehicles/compact.spec" in radius["from"]
    assert "the spec has 11 m" in radius["from"]


def test_what_a_configuration_leaves_alone_is_not_overridden(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "brakes.spec").write_text(
        "module brakes\n\nsignal ego : state { v: m/s, t: s }\nparam hard : m/s^2 = 2 m/s^2\nparam late : s = 1 s\n\n"
        'rule stops "Stops"\n  require ego.v <= hard * (ego.t - late)\n'
    )
    (tmp_path / "tugger.spec").write_text("module tugger\n\nparam hard : m/s^2 = 1 m/s^2\n")
    given = ["--as", "formula", "--json", "--with", str(tmp_path / "tugger.spec")]
    made = json.loads(shown(capsys, "stops", *given, "--spec", str(tmp_path / "brakes.spec")))
    assert {one["name"].rpartition(".")[2]: one["overridden"] for one in made["formula"]["parameters"]} == {
        "hard": True,
        "late": False,
    }
    late = made["formula"]["parameters"][1]
    assert "overridden" not in late["from"]


def test_errors_say_what_to_do(capsys: pytest.CaptureFixture[str]) -> None:
    made = refused(capsys, "frction")
    assert "E401" in made
    assert "did you mean `friction`" in made
    made = refused(capsys, "A-REAR-VEHICLE", "--as", "english")
    assert "E404" in made
    assert "specs/supervisor/assumptions.spec" in made
    assert shown(capsys, "A-REAR-VEHICLE").startswith("A-REAR-VEHICLE: ")
    assert main(["show"]) == 2


@pytest.mark.parametrize("also", ["--json", "--as c", "--solve v", "--expand"])
@pytest.mark.parametrize("drawn", ["--draw", "--over p.a"])
def test_a_drawing_is_nothing_else(drawn: str, also: str, capsys: pytest.CaptureFixture[str]) -> None:
    said = refused(capsys, "friction", *drawn.split(), *also.split())
    assert said.endswith("leave out --as, --expand, --solve and --format\n")


def test_unknown_numbers_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("sympy")
    made = refused(capsys, "friction", "--solve", "masss")
    assert "E491" in made
    assert "did you mean `mass`" in made


def test_outside_of_a_project_a_spec_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.spec").write_text('signal ego : state { v: m/s }\nrule <slow "x"\n', "utf-8")
    monkeypatch.chdir(tmp_path)
    assert "E410" in refused(capsys, "slow")
    assert main(["show", "slow", "--spec", "a.spec"]) != 0  # it does not parse
    capsys.readouterr()
    (tmp_path / "a.spec").write_text(
        'module a\nsignal ego : state { v: m/s }\nrule slow "<b>x</b>"\n  require ego.v < 1 m/s\n', "utf-8"
    )
    assert "&lt;b&gt;x" in shown(capsys, "slow", "--spec", "a.spec", "--format", "html")
