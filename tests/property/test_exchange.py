"""Lists of requirements go out in every format and come back equal: fields, links, Unicode, line breaks, what another tool said."""

from __future__ import annotations

import csv
import io
import json
from datetime import UTC, datetime

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from support.length import amount
from trackmarshal.trace import exchange, tree
from trackmarshal.trace.documents import REQUIREMENT, REQUIREMENTS
from trackmarshal.trace.exchange import Document, Naming, Refused
from trackmarshal.trace.findings import Finding
from trackmarshal.trace.shapes import says_nothing
from trackmarshal.trace.values import Reader, Table

NOW = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
XML = st.characters(
    codec="utf-8", exclude_characters="".join(map(chr, [*range(9), 11, 12, *range(14, 32), 0xFFFE, 0xFFFF]))
)
ANY = st.characters(codec="utf-8")


def texts(characters: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    awkward = ["=1+1", "'=x", "'", "-5", "@a", "a: b", "a # b", "- a", "null", "1.5", "2026-01-02", "yes", "%x", "&a", "*a", "json:[1]", 'a "b" c', "a  b", "a\n  b\n\nc",
               "a \nb", "a\r\nb", "a\rb", "a\tb", "<b>&amp;</b>", "a; b", "x\u2028y", "x\x85y", "\u202eabc", "{a}", "word " * 60, "]]>", "\\n", "a,b;c"]  # fmt: skip
    # A text of `TBA` alone says nothing, and is refused: generated ones are taken from the sources, too, where that word stands.
    return (st.text(characters, min_size=1, max_size=60) | st.sampled_from(awkward)).filter(
        lambda text: text.strip() != "" and not says_nothing(text)
    )


@st.composite
def projects(draw: st.DrawFn, characters: st.SearchStrategy[str] = XML) -> list[Document]:
    ids = draw(
        st.lists(
            st.from_regex(r"[A-Z][A-Za-z0-9]{0,3}(-[A-Za-z0-9]{1,3}){1,2}", fullmatch=True),
            unique=True,
            max_size=5,
        )
    )
    cuts = sorted(draw(st.lists(st.integers(0, len(ids)), max_size=2)))
    text, names = (
        texts(characters),
        st.sampled_from(["speed_limit", "friction", "γ-rule", "no", "null", "A-FRICTION"]),
    )
    goals = st.lists(st.sampled_from(["SG-1", "DE-2"]), min_size=1)
    foreign = st.dictionaries(text.filter(lambda name: name == name.strip()), text, min_size=1, max_size=3) | st.sampled_from(
        [{"title": "x", "ReqIF.Text": "y", "foreign:title": "z", "type": "req", "docname": "d", "content": "c", "document": "e", "link a": "f", "id_back": "g"}, {"type": "spec"}]
    )  # fmt: skip

    def requirement(id_: str) -> dict[str, object]:
        one: dict[str, object] = {
            "id": id_, "title": draw(text), "statement": draw(text), "rationale": draw(text), "status": draw(st.sampled_from(["draft", "approved", "obsolete"])),
            "asil": draw(st.sampled_from(["QM", "A", "B(D)"])), "verification": draw(st.lists(st.sampled_from(["test", "fault injection", "field run"]), min_size=1)),
            "source": draw(text),
        }  # fmt: skip
        more = {
            "derived_from": st.lists(st.sampled_from(["AV", "AV-RO"]), min_size=1), "refines": st.lists(st.sampled_from(ids), min_size=1, max_size=3),
            "owner": text, "achieves": goals, "allocated_to": goals, "verified_by": goals, "independence": goals, "adopted": text, "metrics": st.lists(names, min_size=1), "assumptions": st.lists(names, min_size=1), "foreign": foreign,
            "not_verified_by": st.dictionaries(st.sampled_from(["review", "analysis"]), text, min_size=1),
        }  # fmt: skip
        for name, values in more.items():
            if draw(st.booleans()):
                one[name] = draw(values)
        return one

    documents = []
    for number, (begin, end) in enumerate(zip([0, *cuts], [*cuts, len(ids)])):
        data: dict[str, object] = {"document": "requirements", "title": draw(text)}
        if draw(st.booleans()):
            data["source"] = draw(text)
        data["requirements"] = [requirement(id_) for id_ in ids[begin:end]]
        documents.append(Document(f"sub/list {number}é", table(data)))
    return documents


def table(data: object) -> Table:
    """Through the project's own reader: what is generated is what a project can say."""
    found: list[Finding] = []
    made = Reader("requirements/x.yaml", found).table(node(data), REQUIREMENTS, "the document")
    assert not found, found
    assert made is not None
    return made


def node(data: object) -> tree.Node:
    if isinstance(data, dict):
        made = tree.Mapping(1, 1)
        for key, value in data.items():
            made.keys[key], made.entries[key] = tree.Scalar(key, False, 1, 1), node(value)
        return made
    if isinstance(data, list):
        listing = tree.Listing(1, 1)
        listing.items = [node(item) for item in data]
        return listing
    return tree.Scalar(str(data), False, 1, 1)


def back(documents: list[Document], format: str) -> list[Document]:
    found: list[Finding] = []
    data = exchange.export(documents, format, 'P & "<x>"', NOW)
    made = exchange.read(data, format, "file", Naming(), found)
    assert found == []
    return made


@pytest.mark.parametrize("format", exchange.FORMATS)
@given(data=st.data())
@settings(max_examples=amount(6, 25), deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_what_goes_out_comes_back(format: str, data: st.DataObject) -> None:
    documents = data.draw(projects(XML if format == "reqif" else ANY))
    assert back(documents, format) == documents
    assert back(back(documents, format), format) == documents


@given(documents=projects(ANY))
@settings(max_examples=amount(6, 25), deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_yaml_says_the_same(documents: list[Document]) -> None:
    for document in documents:
        text = exchange.yaml(document)
        found: list[Finding] = []
        read = tree.parse(text.encode(), "x", found)
        assert read is not None
        assert Reader("x", found).table(read, REQUIREMENTS, "the document") == document.table
        assert found == []


@given(documents=projects())
@settings(max_examples=amount(4, 15), deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_no_cell_is_a_formula_and_every_row_is_whole(documents: list[Document]) -> None:
    rows = list(
        csv.reader(io.StringIO(exchange.export(documents, "csv", "P", NOW).decode(), newline=""), strict=True)
    )
    assert len({len(row) for row in rows}) == 1
    assert not [cell for row in rows for cell in row if cell.startswith(("=", "+", "-", "@", "\t", "\r"))]


@given(
    documents=projects(),
    character=st.sampled_from("\x00\x01\x0b\x1f\ufffe\uffff"),
    field=st.sampled_from(["title", "statement", "foreign"]),
)
@settings(max_examples=amount(4, 15), deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_what_xml_has_no_character_for_is_refused(
    documents: list[Document], character: str, field: str
) -> None:
    everything = [one for document in documents for one in document.requirements]
    if not everything:
        return
    everything[-1][field] = {f"a{character}b": "c"} if field == "foreign" else f"a{character}b"
    with pytest.raises(Refused) as refused:
        exchange.export(documents, "reqif", "P", NOW)
    assert refused.value.code == "T352"
    assert f"U+{ord(character):04X}" in refused.value.message


@pytest.mark.parametrize("format", exchange.FORMATS)
@given(data=st.data())
@settings(max_examples=amount(6, 25), deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_a_broken_file_is_refused_or_read(format: str, data: st.DataObject) -> None:
    """Cut anywhere, or with any byte changed: an error with a code, or a list of requirements, never anything else."""
    whole = exchange.export(data.draw(projects()), format, "P", NOW)
    place = data.draw(st.integers(0, len(whole) - 1))
    broken = (
        whole[:place]
        if data.draw(st.booleans())
        else whole[:place] + bytes([data.draw(st.integers(0, 255))]) + whole[place + 1 :]
    )
    found: list[Finding] = []
    try:
        exchange.read(broken, format, "file", Naming(), found)
    except Refused as refused:
        assert refused.code.startswith("T35")
        assert refused.file == "file"


def test_every_field_is_generated() -> None:
    generated = {
        "id",
        "title",
        "statement",
        "rationale",
        "status",
        "asil",
        "verification",
        "source",
        "derived_from",
        "refines",
        "adopted",
        "metrics",
        "assumptions",
        "foreign",
        "owner",
        "achieves",
        "allocated_to",
        "verified_by",
        "not_verified_by",
        "independence",
    }
    assert {field.name for field in REQUIREMENT.fields} == generated
    assert json.loads(exchange.export([], "needs", "P", NOW))["versions"]["1.0"]["needs_amount"] == 0
