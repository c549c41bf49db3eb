"""The matrix page in a headless Chromium: three clicks to whatever shows something, views that can be linked, and the same answers as `trace` gives."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlencode

import pytest

from golden.trace.cases import Small
from golden.trace.test_renders import broken
from support.assessed import assessed
from support.browser import Page, browser_page, needs_browser
from support.length import amount, shared_out
from support.project import command
from support.walk import Walk
from trackmarshal import trace
from trackmarshal.trace.render.page.beside import Beside

pytestmark = needs_browser
#: The places of what is clicked: the first that is visible and says exactly this.
FIND = """(() => {
  const one = [...document.querySelectorAll(%s)].find((each) => each.textContent.trim() === %s && each.checkVisibility());
  if (!one) return null;
  one.scrollIntoView({ block: "center" });
  const box = one.getClientRects()[0];
  return [box.left + box.width / 2, box.top + box.height / 2];
})()"""
ROWS = '[...document.querySelectorAll("#rows tbody tr.row")].map((row) => row.dataset.node)'


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return assessed(tmp_path_factory.mktemp("assessed"))


@pytest.fixture(scope="module")
def pages(made: tuple[Path, Path]) -> Path:
    return made[1]


@pytest.fixture(scope="module")
def shared_browser() -> Iterator[Page]:
    with browser_page() as page:
        yield page


@pytest.fixture
def browser(shared_browser: Page) -> Iterator[Page]:
    """A page that says nothing and asks for nothing but files."""
    shared_browser.messages.clear()
    shared_browser.size(1400, 1000)
    yield shared_browser
    assert shared_browser.messages == []
    assert [
        address for address in shared_browser.requests if not address.startswith(("file:", "data:"))
    ] == []


def click(page: Page, selector: str, text: str) -> None:
    """Press what says this with the mouse, and wait for where that leads."""
    before = page.evaluate("location.href")
    found = page.evaluate(FIND % (json.dumps(selector), json.dumps(text)))
    assert found is not None, text
    page.click(*found)
    page.until(f"location.href !== {json.dumps(before)} && document.readyState === 'complete'")
    # What listens to the address has its turn.
    page.until("await new Promise((done) => setTimeout(() => setTimeout(() => done(true), 20), 20))")


def card(page: Page) -> str:
    return str(page.evaluate('document.querySelector("article.card").innerText'))


def arrives(page: Page, node: str) -> None:
    """Wait until the card of a node is shown: an address is another one before the page that stands at it is drawn."""
    page.until(f"document.querySelector('article.card')?.dataset.node === {json.dumps(node)}")


def two_clicks(page: Page, pages: Path) -> None:
    """From the first page to what is known of S-1-A-4."""
    page.open(pages / "index.html")
    click(page, "a", "Traceability matrix")
    click(page, "#rows a", "S-1-A-4 Friction limits")
    arrives(page, "requirement:S-1-A-4")


def test_the_formula_is_three_clicks_away(browser: Page, made: tuple[Path, Path]) -> None:
    project, pages = made
    two_clicks(browser, pages)
    click(browser, ".card a", "friction")
    arrives(browser, "rule:friction")
    status, out, _ = command(project, "show", "friction", "--json")
    assert status == 0
    shown = json.loads(out)
    drawn = browser.evaluate(
        '[...document.querySelectorAll(".card .clause math")].map((one) => one.outerHTML)'
    )
    formulas = [one["mathml"] for one in shown["formula"]["clauses"]]
    said = [
        browser.evaluate(
            f"(() => {{ const t = document.createElement('template'); t.innerHTML = {json.dumps(one)}; return t.innerHTML; }})()"
        )
        for one in formulas
    ]
    assert drawn[: len(said)] == said
    assert all(
        browser.evaluate(
            '[...document.querySelectorAll(".card math")].map((one) => one.getBoundingClientRect().width > 20)'
        )
    )
    assert shown["words"]["demand"][0] in card(browser)
    assert shown["spec"].splitlines()[-1] in card(browser)
    assert shown["declared"] in card(browser)


def test_a_test_is_three_clicks_away(browser: Page, made: tuple[Path, Path]) -> None:
    project, pages = made
    two_clicks(browser, pages)
    click(browser, ".card a", "braking with all the grip there is")
    arrives(browser, "test:friction: braking with all the grip there is")
    said = card(browser)
    assert "expect satisfied, margin 0 N" in said
    assert "trackmarshal test" in said
    lines = (project / "out" / "results" / "evidence.jsonl").read_text("utf-8").splitlines()
    entry = next(
        json.loads(line) for line in lines if '"friction: braking with all the grip there is"' in line
    )
    assert entry["id"] in said


def test_a_run_is_three_clicks_away(browser: Page, made: tuple[Path, Path]) -> None:
    project, pages = made
    two_clicks(browser, pages)
    lines = (project / "out" / "results" / "evidence.jsonl").read_text("utf-8").splitlines()
    run = next(
        said
        for line in lines
        if (said := json.loads(line))["kind"] == "run" and "overreach" in said["subject"]
    )
    first = min(
        rule["first_violation"]
        for rule in run["result"]["rules"]
        if rule["rule"].startswith("friction") and rule["first_violation"] is not None
    )
    click(browser, ".card a", f"at {first:g} s")
    assert (
        unquote(browser.evaluate("location.href"))
        == (pages / "runs" / "overreach.html").resolve().as_uri() + f"#t={first:g}"
    )
    assert browser.evaluate('document.querySelector("h1").textContent') == "overreach"


def test_an_assumption_is_three_clicks_away(browser: Page, pages: Path) -> None:
    two_clicks(browser, pages)
    click(browser, ".card a", "A-FRICTION")
    arrives(browser, "assumption:A-FRICTION")
    for words in ("owner", "no evidence", "W-5"):
        assert words in card(browser), words


def test_a_cell_leads_to_what_counts_in_it(browser: Page, pages: Path) -> None:
    browser.open(pages / "matrix.html")
    browser.evaluate(
        'document.querySelector(\'tr[data-node="requirement:S-1-A-4"] a.cell[title^="S-3-B"]\').click()'
    )
    browser.until('document.querySelector(".card")')
    top = browser.evaluate('document.getElementById("cell-S-3-B").getBoundingClientRect().top')
    assert 0 < top < 400


def test_the_pages_lead_to_each_other_and_have_one_verdict(browser: Page, pages: Path) -> None:
    browser.open(pages / "index.html")
    verdict = browser.evaluate('document.querySelector(".state b").textContent')
    colour = browser.evaluate('getComputedStyle(document.querySelector(".state")).backgroundColor')
    click(browser, "a", "Traceability matrix")
    assert browser.evaluate('document.querySelector(".verdict strong").textContent') == verdict
    assert browser.evaluate('getComputedStyle(document.querySelector(".verdict")).backgroundColor') == colour
    click(browser, ".topbar a", "assessment")
    assert browser.evaluate("location.pathname").endswith("index.html")


def test_filters_show_what_the_json_says(browser: Page, pages: Path) -> None:
    matrix = json.loads((pages / "matrix.json").read_text("utf-8"))
    browser.open(pages / "matrix.html")
    rows = {one["id"]: one for one in matrix["requirements"]}
    statuses = sorted({cell["status"] for one in rows.values() for cell in one["stages"].values()})
    assert len(statuses) > 2
    number = 0
    for stage in ("", *[one["id"] for one in matrix["stages"]]):
        for status in ("", *statuses):
            for asil in ("", "D", "QM"):
                # Every day one of four views: each stage, status and ASIL is in some.
                number += 1
                if number % amount(4, 1):
                    continue
                wanted = {
                    id_ for id_, one in rows.items()
                    if (not asil or one["asil"] == asil)
                    and (not (stage or status) or any((not stage or name == stage) and (not status or cell["status"] == status) for name, cell in one["stages"].items()))
                }  # fmt: skip
                shown = browser.evaluate(
                    f"(location.hash = '#stage={stage}&status={status}&asil={asil}', follow(null), {ROWS})"
                )
                assert {
                    key.removeprefix("requirement:")
                    for key in shown
                    if key.removeprefix("requirement:") in rows
                } == wanted, (stage, status, asil)
                said = browser.evaluate('document.getElementById("count").textContent')
                assert said.startswith(f"{len(shown)} of "), said


def test_what_is_demanded_no_longer_says_so(browser: Page, pages: Path) -> None:
    """It is among the rows, and not among the requirements that are counted above."""
    browser.open(pages / "matrix.html", "#kind=requirement&q=RR")
    said = browser.evaluate('[...document.querySelectorAll("#rows tbody th")].map((one) => one.innerText)')
    assert [one.split()[0] for one in said if "obsolete" in one] == ["RR-4"]


def test_search_finds_all_words_wherever_they_stand(browser: Page, pages: Path) -> None:
    walk = Walk((pages / "matrix.html").read_text("utf-8"))
    browser.open(pages / "matrix.html")
    for kind, words in (
        ("requirement", "force TYRES"),
        ("rule", "sqrt kappa"),
        ("test", "braking grip"),
        ("parameter", "devbot"),
        ("rule", "no such words"),
    ):
        wanted = set()
        for (of, id_), (title, place, _, said) in walk.nodes.items():
            table = {"rule": "rules", "test": "tests"}.get(kind)
            more = walk.of(kind, table).get(id_, "") if table else ""
            text = "\n".join(
                [of, id_, title, place, *said.values(), more["spec"] if isinstance(more, dict) else more]
            ).lower()
            if of == kind and all(word in text for word in words.lower().split()):
                wanted.add(f"{of}:{id_}")
        assert bool(wanted) == ("no such" not in words)
        hash_ = f"#kind={kind}&q={words.replace(' ', '+')}"
        assert set(browser.evaluate(f"(location.hash = {json.dumps(hash_)}, follow(null), {ROWS})")) == wanted


@pytest.mark.parametrize(
    ("source", "target"),
    shared_out([
        ("requirement", "rule"), ("rule", "requirement"), ("test", "rule"), ("parameter", "rule"), ("run", "requirement"), ("requirement", "hazard"),
        ("person", "requirement"), ("hazard", "test"), ("document", "assumption"), ("stage", "scenario"), ("requirement", "requirement"),
    ], 2),
)  # fmt: skip
def test_what_leads_where_is_what_trace_says(
    browser: Page, made: tuple[Path, Path], source: str, target: str
) -> None:
    project, pages = made
    status, out, err = command(project, "trace", "--from", source, "--to", target, "--format", "json")
    assert status == 0, err
    told: dict[str, set[str]] = {}
    for path in json.loads(out)["paths"]:
        told.setdefault(path["from"]["id"], set()).update([path["to"]["id"]] if path["to"] else [])
    browser.open(pages / "matrix.html", f"#kind={source}&to={target}")
    shown = browser.evaluate(
        f"byKind.get({source!r}).map((one) => [nodes[one].id, leads(one, {target!r}).map((other) => nodes[other].id)])"
    )
    assert {id_: set(others) for id_, others in shown} == told
    # All of them: a page begins with 200 rows.
    gaps = browser.evaluate(
        f"(location.hash = '#kind={source}&to={target}&gap=1', follow(null), document.getElementById('further').click(), {ROWS})"
    )
    assert {key.partition(":")[2] for key in gaps} == {id_ for id_, others in told.items() if not others}


def test_a_view_can_be_linked(browser: Page, pages: Path) -> None:
    """What is chosen by hand stands in the address, and the address brings it back."""
    browser.open(pages / "matrix.html")
    for name, value in (("kind", "rule"), ("to", "test"), ("asil", "D"), ("q", "speed")):
        browser.evaluate(
            f"(() => {{ const one = document.querySelector('[name={name}]'); one.value = {value!r}; one.dispatchEvent(new Event('input', {{ bubbles: true }})); }})()"
        )
    shown, address = browser.evaluate(ROWS), browser.evaluate("location.hash")
    assert 0 < len(shown) < browser.evaluate('byKind.get("rule").length')
    browser.open(pages / "matrix.html", address)
    assert browser.evaluate(ROWS) == shown
    assert browser.evaluate(
        "[...document.querySelectorAll('#view select, #view [type=search]')].map((one) => one.value)"
    ) == ["rule", "test", "", "D", "", "speed"]
    browser.evaluate("document.querySelector('#rows tr.row a').click()")
    browser.until('document.querySelector(".opened .card")')
    assert browser.evaluate(ROWS) == shown  # the card changes nothing of the view
    browser.evaluate("history.back()")
    browser.until('!document.querySelector(".card")')


def test_the_keyboard_does_it(browser: Page, pages: Path) -> None:
    browser.open(pages / "matrix.html")
    browser.evaluate("document.dispatchEvent(new KeyboardEvent('keydown', { key: '/', bubbles: true }))")
    assert browser.evaluate("document.activeElement.name") == "q"
    browser.call("Input.insertText", text="friction limits")
    assert browser.evaluate(ROWS) == ["requirement:S-1-A-4"]
    browser.evaluate("document.querySelector('#rows tr.row a').focus()")
    for kind in ("keyDown", "keyUp"):
        browser.call(
            "Input.dispatchKeyEvent",
            type=kind,
            key="Enter",
            code="Enter",
            text="\r" if kind == "keyDown" else "",
            windowsVirtualKeyCode=13,
        )
    browser.until('document.querySelector(".opened .card")')
    browser.evaluate(
        "document.activeElement.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape', bubbles: true }))"
    )
    browser.until('!document.querySelector(".card")')
    browser.until('document.activeElement.closest("tr.row")')


def test_rows_are_made_when_they_are_asked_for(browser: Page, pages: Path) -> None:
    browser.open(pages / "matrix.html", "#kind=test")
    all_ = browser.evaluate('byKind.get("test").length')
    shown = browser.evaluate(f"{ROWS}.length")
    assert shown == 200 < all_
    while not browser.evaluate('document.getElementById("further").hidden'):
        browser.evaluate('document.getElementById("further").click()')
        before, shown = shown, browser.evaluate(f"{ROWS}.length")
        assert shown > before
    assert shown == all_


def test_on_paper_all_of_the_view_is_there_and_open(browser: Page, pages: Path) -> None:
    browser.open(pages / "matrix.html", "#asil=QM")
    rows = len(browser.evaluate(ROWS))
    browser.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert rows == browser.evaluate("document.querySelectorAll('tr.opened .card').length") > 1
    assert browser.evaluate("document.querySelectorAll('main details:not([open])').length") == 0
    browser.evaluate("window.dispatchEvent(new Event('afterprint'))")
    assert browser.evaluate("document.querySelectorAll('.card').length") == 0
    assert browser.evaluate("document.querySelectorAll('main details:not([open])').length") > 1
    assert browser.pdf().startswith(b"%PDF-")


def test_on_paper_the_index_shows_what_follows(browser: Page, pages: Path) -> None:
    """It counted what follows from a finding, and did not say what that is."""
    folded = '[...document.querySelectorAll("details:not([open]) > :not(summary)")]'
    browser.open(pages / "index.html")
    browser.evaluate("document.querySelector('main').insertAdjacentHTML('beforeend', '<details><summary>1</summary><p>T230</p></details>')")  # fmt: skip
    shown = f"{folded}.filter((one) => one.checkVisibility()).length"
    assert browser.evaluate(shown) == 0
    browser.media("print")
    assert browser.evaluate(shown) == browser.evaluate(f"{folded}.length") > 0
    browser.media()


@pytest.mark.parametrize(
    "fragment",
    [
        "",
        "#at=rule:friction",
        "#kind=run&to=requirement",
        "#at=requirement:S-1-A-4",
        "#kind=parameter",
        "#statistics",
    ],
)
def test_nothing_is_wider_than_a_phone(browser: Page, pages: Path, fragment: str) -> None:
    browser.size(390, 844)
    browser.open(pages / "matrix.html", fragment)
    assert browser.evaluate("document.documentElement.scrollWidth") <= 390


@pytest.mark.parametrize(("wide", "media"), [(1400, ""), (1100, ""), (800, ""), (690, "print")])
def test_no_count_lies_beyond_its_table(browser: Page, pages: Path, wide: int, media: str) -> None:
    """How many cells are stale or failed was to be scrolled for, and lay under the next table on paper."""
    browser.size(wide, 1000)
    browser.media(media)
    browser.open(pages / "matrix.html")
    tables = '[...document.querySelectorAll(".numbers .wide")]'
    assert browser.evaluate(f"{tables}.length") > 3
    assert browser.evaluate(f"{tables}.filter((one) => one.scrollWidth > one.clientWidth).length") == 0
    browser.media()


def test_the_first_page_fits_a_phone(browser: Page, pages: Path) -> None:
    browser.size(390, 844)
    browser.open(pages / "index.html")
    assert browser.evaluate("document.documentElement.scrollWidth") <= 390


def test_without_scripts_the_cells_stand_there(pages: Path) -> None:
    with browser_page() as page:
        page.call("Emulation.setScriptExecutionDisabled", value=True)
        page.open(pages / "matrix.html")
        text = page.call("DOM.getOuterHTML", nodeId=page.call("DOM.getDocument", depth=-1)["root"]["nodeId"])[
            "outerHTML"
        ]
        page.call("DOM.enable")
        root = page.call("DOM.getDocument", depth=-1)["root"]["nodeId"]
        rows = page.call("DOM.querySelectorAll", nodeId=root, selector="noscript tbody tr")["nodeIds"]
        hidden = page.call("DOM.querySelector", nodeId=root, selector="#view[hidden]")["nodeId"]
    assert len(rows) == len(json.loads((pages / "matrix.json").read_text("utf-8"))["requirements"])
    assert hidden
    assert "S-1-A-4" in text


def test_markup_in_titles_does_nothing(browser: Page, tmp_path: Path) -> None:
    title = "</script><script>window.hit=1</script><img src=x onerror=window.hit=2><b>$\\frac{1}{2}$</b> `code` &amp;"
    small = Small.copy(tmp_path)
    small.replace("requirements/criteria.yaml", "    title: Grip\n", f"    title: {json.dumps(title)}\n")
    page = tmp_path / "page.html"
    page.write_text(trace.render(small.matrix(), "html"), "utf-8")
    browser.open(page)
    hit = next(
        key
        for key in browser.evaluate(ROWS)
        if browser.evaluate(f"nodes[numbers.get({json.dumps(key)})].title") == title
    )
    for fragment in (f"#at={hit}", "#kind=rule", "#q=frac", f"#at={title.replace('&', '%26')}"):
        browser.open(page, fragment)
        assert browser.evaluate("window.hit") is None
        assert browser.evaluate("document.querySelectorAll('main img, main b b').length") == 0
    browser.open(page, f"#at={hit}")
    assert title in card(browser)


def test_formulas_are_formulas_and_nothing_else(browser: Page, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.write_text(trace.render(broken(tmp_path).matrix(), "html"), "utf-8")
    browser.open(page)
    for source in (
        "<math><mi>x</mi><img src=q onerror=window.hit=1></math>",
        "<math onclick='window.hit=1'><mi>x</mi></math>",
        "<script>window.hit=1</script>",
    ):
        held: Any = browser.evaluate(
            f"(() => {{ const one = math({json.dumps(source)}); document.body.append(one); return document.body.lastChild.outerHTML; }})()"
        )
        assert held.startswith("<code>"), held
    assert browser.evaluate("math('<math><mi>x</mi></math>').firstChild.localName") == "math"
    assert browser.evaluate("window.hit") is None


def test_a_rule_without_a_drawing_says_why_or_how_it_is_drawn(browser: Page, tmp_path: Path) -> None:
    matrix = Small().matrix()
    drawn, other, told = sorted(node.id for node in matrix.graph.by_kind["rule"])
    formula = {"clauses": [{"kind": "require", "depth": 0, "said": "", "mathml": "<math><mi>x</mi></math>"}],
               **{name: [] for name in ("definitions", "machines", "parameters", "tables", "places", "inputs")}}  # fmt: skip
    beside = Beside(
        sheets={rule: {"spec": "rule", "formula": formula} for rule in (drawn, other, told)},
        drawings={drawn: '<svg xmlns="http://www.w3.org/2000/svg" width="7" height="3"></svg>'},
        undrawn={told: "No drawing: it is about a <b>stretch</b>."},
    )
    page = tmp_path / "page.html"
    page.write_text(trace.render(matrix, "html", beside=beside), "utf-8")
    for rule in (drawn, other, told):
        browser.open(page, "#" + urlencode({"at": f"rule:{rule}"}))
        arrives(browser, f"rule:{rule}")
        assert (browser.evaluate('document.querySelectorAll(".card img").length') == 1) == (rule == drawn)
        assert (f"trackmarshal show {rule} --draw draws it" in card(browser)) == (rule == other)
        assert ("No drawing: it is about a <b>stretch</b>." in card(browser)) == (rule == told)


def test_a_test_stands_in_the_drawing_of_its_rule(browser: Page, tmp_path: Path) -> None:
    """An image is drawn, and no script in it runs."""
    svg = '<svg xmlns="http://www.w3.org/2000/svg" width="70" height="30"><script>parent.hit=1</script><path d="M0 0L9 9" class="äö#%"/></svg>'
    matrix = Small().matrix()
    rules = {node.id for node in matrix.graph.by_kind["rule"]}
    test = next(node for node in matrix.graph.by_kind["test"] if node.id.partition(": ")[0] in rules)
    rule, _, title = test.id.partition(": ")
    page = tmp_path / "page.html"
    page.write_text(
        trace.render(
            matrix,
            "html",
            beside=Beside(
                sheets={rule: {"spec": "rule"}}, drawings={rule: svg}, tests={(rule, title): "test"}
            ),
        ),
        "utf-8",
    )
    for key in (f"rule:{rule}", f"test:{test.id}"):
        browser.open(page, "#" + urlencode({"at": key}))
        browser.until('document.querySelector(".card img").complete')
        assert browser.evaluate(
            '[document.querySelector(".card img").naturalWidth, document.querySelector(".card img").naturalHeight]'
        ) == [70, 30]
        assert browser.evaluate("window.hit") is None
