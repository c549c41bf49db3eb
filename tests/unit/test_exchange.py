"""Requirements to other tools and back: what files hold, what other tools write, what is refused, and how it is said."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import shutil
import zipfile
from datetime import UTC, datetime
from pathlib import Path

import pytest
import reqif
import xmlschema

from support.growth import grows
from trackmarshal.cli.main import main
from trackmarshal.trace import exchange
from trackmarshal.trace.exchange import Naming, Refused
from trackmarshal.trace.findings import Finding

ROOT = Path(__file__).parents[2]
GOLDEN = ROOT / "tests" / "golden" / "exchange" / "messages.txt"
NOW = datetime(2026, 1, 2, tzinfo=UTC)


def project(folder: Path) -> Path:
    """The shipped requirements as a project of their own."""
    shutil.copytree(ROOT / "requirements", folder / "requirements")
    return folder


def shipped() -> list[exchange.Document]:
    found: list[Finding] = []
    documents = exchange.of_project(ROOT, found)
    assert found == []
    assert documents
    return documents


def read(
    text: str | bytes, format: str, naming: Naming | None = None
) -> tuple[list[exchange.Document], list[str]]:
    found: list[Finding] = []
    data = text.encode() if isinstance(text, str) else text
    return exchange.read(data, format, f"file{exchange.FORMATS[format]}", naming or Naming(), found), [
        str(one) for one in found
    ]


def test_what_is_written_is_reqif(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against the schema of ReqIF, which comes with the package."""
    folder = Path(reqif.__file__).parent
    monkeypatch.chdir(folder)  # the schema includes files by paths from there
    schema = xmlschema.XMLSchema(str(folder / "reqif_schema" / "reqif.xsd"))
    file = tmp_path / "out.reqif"
    file.write_bytes(exchange.export(shipped(), "reqif", "A & <B>", NOW))
    assert [error.reason for error in schema.iter_errors(str(file))] == []


def test_needs_are_what_sphinx_needs_reads() -> None:
    data = json.loads(exchange.export(shipped(), "needs", "P", NOW))
    version = data["versions"][data["current_version"]]
    need = version["needs"]["RR-1"]
    assert version["needs_amount"] == len(version["needs"])
    assert need["id"] == "RR-1"
    assert need["type"] == "req"
    assert need["title"] == "Overall maximum speed"
    assert need["content"].startswith("The vehicle shall never")
    assert need["status"] == "approved"
    assert need["refines"] == ["S-1-A-6"]
    assert need["docname"] == "race-rules"


@pytest.mark.parametrize("format", exchange.FORMATS)
def test_a_project_goes_out_and_comes_back(
    format: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Through the commands: other files, but every field of every requirement."""
    root = project(tmp_path)
    monkeypatch.chdir(root)
    file = f"all{exchange.FORMATS[format]}"
    assert main(["export", "requirements", "--out", file]) == 0
    assert main(["import", "requirements", file, "--out", "requirements"]) == 2  # there already
    assert "E412" in capsys.readouterr().err
    assert main(["import", "requirements", file, "--out", "requirements", "--force"]) == 0
    assert exchange.of_project(root, []) == shipped()
    assert (
        "document: requirements\ntitle: Rules of conduct in a race\n"
        in (root / "requirements" / "race-rules.yaml").read_text()
    )
    assert not list((root / "requirements").glob(".*"))


def test_the_same_requirements_are_the_same_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsysbinary: pytest.CaptureFixture[bytes]
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1767312000")
    monkeypatch.chdir(project(tmp_path))
    printed = []
    for _ in range(2):
        assert main(["export", "requirements", "--format", "csv"]) == 0
        printed.append(capsysbinary.readouterr().out)
    assert printed[0] == printed[1]
    assert printed[0].startswith(b"document,document_title,document_source,id,title,")
    assert b"\r\n" in printed[0]


@pytest.mark.parametrize("said", ["²", "99999999999999", "-5", "yesterday", "1767312000.5", " "])
def test_a_day_that_is_none_is_not_today(
    said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsysbinary: pytest.CaptureFixture[bytes]
) -> None:
    """Whoever says when wants the same bytes tomorrow: another time than that would be a guess."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", said)
    monkeypatch.chdir(project(tmp_path))
    assert main(["export", "requirements", "--format", "needs"]) == 2
    out, told = capsysbinary.readouterr()
    assert out == b""
    assert b"error[T366]" in told


FOREIGN_CSV = """Key,Name,Text,Owner,Priority
AB-1,Braking,"The vehicle shall brake, always.",=Ada,3
"""
NAMING = Naming(
    {"id": "Key", "title": "Name", "statement": "Text"},
    {
        "rationale": "Taken over.",
        "status": "draft",
        "asil": "QM",
        "verification": "review; test",
        "source": "door",
    },
)
#: Of files with our names.
OURS = Naming({}, NAMING.defaults)


def test_a_table_of_somebody_else() -> None:
    documents, found = read(FOREIGN_CSV, "csv", NAMING)
    assert found == []
    one = documents[0].requirements[0]
    assert one["id"] == "AB-1"
    assert one["verification"] == ["review", "test"]
    assert one["foreign"] == {"Owner": "=Ada", "Priority": "3"}
    rows = list(csv.reader(io.StringIO(exchange.export(documents, "csv", "P", NOW).decode(), newline="")))
    assert rows[1][rows[0].index("Owner")] == "'=Ada"


@pytest.mark.parametrize("removed", [True, False])
def test_needs_that_leave_out_what_is_the_default(removed: bool) -> None:
    """As `needs_json_remove_defaults` writes them: where a project has it that needs are of ASIL D, one that says nothing is of no other one."""
    fields: dict[str, object] = {
        "asil": {"default": "D"}, "tags": {"default": []}, "completion": {"default": None}, "vmax": {"default": 5, "type": "integer"}, "doctype": {"default": ".rst"},
        "status": {"type": "string"},
    }  # fmt: skip
    needs = {
        "AB-1": {"id": "AB-1", "title": "Braking", "content": "It shall brake."},
        "AB-2": {"id": "AB-2", "title": "Stopping", "content": "It shall stop.", "asil": "B", "vmax": 7},
    }
    version = {"needs": needs, "needs_schema": {"properties": fields}, "needs_defaults_removed": removed}
    naming = Naming({}, {**NAMING.defaults, "status": "draft", "asil": "QM"})
    documents, found = read(json.dumps({"current_version": "1", "versions": {"1": version}}), "needs", naming)
    assert found == []
    one, other = documents[0].requirements
    assert (one["asil"], one.get("foreign")) == (("D", {"vmax": "json:5"}) if removed else ("QM", None))
    assert (other["asil"], other["foreign"]) == ("B", {"vmax": "json:7"})


def test_needs_of_somebody_else() -> None:
    need = {
        "id": "AB-1", "title": "Braking", "content": "It shall brake.", "status": "open", "type": "spec", "links": ["AB-2"], "links_back": ["X"],
        "tags": [], "weight": 3, "safe": False, "lineno": 7, "docname": "brakes", "sections": ["Brakes", "All"],
    }  # fmt: skip
    data = {"current_version": "", "project": "P", "versions": {"0.1": {"needs": {"AB-1": need}}}}
    naming = Naming({"status": "state"}, {**NAMING.defaults, "status": "draft"})
    documents, found = read(json.dumps(data), "needs", naming)
    assert [one.split(":")[1:][0:2] for one in found if "lineno" in one]
    assert [one for one in found if "has `state`, which is to be `status`: it is `draft` by" in one]
    assert len(found) == 3
    one = documents[0].requirements[0]
    assert documents[0].table["title"] == "Brakes"
    assert one["foreign"] == {
        "status": "open",
        "type": "spec",
        "links": 'json:["AB-2"]',
        "weight": "json:3",
        "safe": "json:false",
    }
    back = json.loads(exchange.export(documents, "needs", "P", NOW))["versions"]["1.0"]["needs"]["AB-1"]
    assert (back["type"], back["links"], back["weight"], back["safe"]) == ("spec", ["AB-2"], 3, False)


def test_a_link_of_sphinx_needs_by_its_own_name_is_a_field() -> None:
    """A list by a name that is none here was kept as text of JSON, which is no id of a requirement: `--field refines=derives` could not be."""
    need = {
        "title": "Braking",
        "content": "It shall brake.",
        "docname": "brakes",
        "derives": ["AB-1", "AB-3"],
        "team": 7,
    }
    needs = {key: {"id": key, **need} for key in ("AB-1", "AB-2", "AB-3")}
    data = json.dumps({"current_version": "1", "versions": {"1": {"needs": needs}}})
    fields = {"refines": "derives", "owner": "team"}
    documents, found = read(data, "needs", Naming(fields, NAMING.defaults))
    assert (found, exchange.check(documents)) == ([], [])
    one = documents[0].requirements[1]
    assert (one["refines"], one["owner"], "foreign" in one) == (["AB-1", "AB-3"], "7", False)


def test_links_of_sphinx_needs_lead_to_the_ids_that_are_named() -> None:
    """Its own, such as `N_1`, are no ids here, and whoever has others in a field could take over no link."""
    need = {"title": "Braking", "content": "It shall brake.", "docname": "brakes"}
    needs = {
        "N_1": {**need, "id": "N_1", "uid": "AB-1"},
        "N_2": {**need, "id": "N_2", "uid": "AB-2", "refines": ["N_1"]},
    }
    data = json.dumps({"current_version": "1", "versions": {"1": {"needs": needs}}})
    documents, found = read(data, "needs", Naming({"id": "uid"}, NAMING.defaults))
    assert (found, exchange.check(documents)) == ([], [])
    assert [(one["id"], one.get("refines")) for one in documents[0].requirements] == [
        ("AB-1", None),
        ("AB-2", ["AB-1"]),
    ]


@pytest.mark.parametrize("between", ["; ", ";", ", ", ",", "\n", ",\n"])
def test_what_tools_put_between_the_entries_of_a_list(between: str) -> None:
    """Of ids with commas between them, all together were said to be no id."""
    text = f'Key,Name,Text,refines\nAB-1,A,It shall stop.,\nAB-2,A,It shall stop.,\nAB-3,A,It shall stop.,"AB-1{between}AB-2"\n'
    documents, found = read(text, "csv", NAMING)
    assert (found, documents[0].requirements[2]["refines"]) == ([], ["AB-1", "AB-2"])


REQIF = """<?xml version="1.0" encoding="UTF-8"?>
<REQ-IF xmlns="http://www.omg.org/spec/ReqIF/20110401/reqif.xsd" xmlns:xhtml="http://www.w3.org/1999/xhtml">
  <THE-HEADER><REQ-IF-HEADER IDENTIFIER="h"><TITLE>Door</TITLE></REQ-IF-HEADER></THE-HEADER>
  <CORE-CONTENT><REQ-IF-CONTENT>
    <DATATYPES>
      <DATATYPE-DEFINITION-XHTML IDENTIFIER="dx" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="X"/>
      <DATATYPE-DEFINITION-STRING IDENTIFIER="ds" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="S" MAX-LENGTH="99"/>
      <DATATYPE-DEFINITION-ENUMERATION IDENTIFIER="de" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="E"><SPECIFIED-VALUES>
        <ENUM-VALUE IDENTIFIER="e1" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="approved"><PROPERTIES><EMBEDDED-VALUE KEY="1" OTHER-CONTENT=""/></PROPERTIES></ENUM-VALUE>
      </SPECIFIED-VALUES></DATATYPE-DEFINITION-ENUMERATION>
    </DATATYPES>
    <SPEC-TYPES>
      <SPEC-OBJECT-TYPE IDENTIFIER="t" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="T"><SPEC-ATTRIBUTES>
        <ATTRIBUTE-DEFINITION-STRING IDENTIFIER="ai" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="ReqIF.ForeignID"><TYPE><DATATYPE-DEFINITION-STRING-REF>ds</DATATYPE-DEFINITION-STRING-REF></TYPE></ATTRIBUTE-DEFINITION-STRING>
        <ATTRIBUTE-DEFINITION-XHTML IDENTIFIER="ax" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="ReqIF.Text"><TYPE><DATATYPE-DEFINITION-XHTML-REF>dx</DATATYPE-DEFINITION-XHTML-REF></TYPE></ATTRIBUTE-DEFINITION-XHTML>
        <ATTRIBUTE-DEFINITION-ENUMERATION IDENTIFIER="ae" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="status" MULTI-VALUED="false"><TYPE><DATATYPE-DEFINITION-ENUMERATION-REF>de</DATATYPE-DEFINITION-ENUMERATION-REF></TYPE></ATTRIBUTE-DEFINITION-ENUMERATION>
      </SPEC-ATTRIBUTES></SPEC-OBJECT-TYPE>
      <SPEC-RELATION-TYPE IDENTIFIER="r" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="Refines"/>
      <SPEC-RELATION-TYPE IDENTIFIER="v" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="verifies"/>
      <SPECIFICATION-TYPE IDENTIFIER="st" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="ST"/>
    </SPEC-TYPES>
    <SPEC-OBJECTS>
      <SPEC-OBJECT IDENTIFIER="o1" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="One"><TYPE><SPEC-OBJECT-TYPE-REF>t</SPEC-OBJECT-TYPE-REF></TYPE><VALUES>
        <ATTRIBUTE-VALUE-STRING THE-VALUE="AB-1"><DEFINITION><ATTRIBUTE-DEFINITION-STRING-REF>ai</ATTRIBUTE-DEFINITION-STRING-REF></DEFINITION></ATTRIBUTE-VALUE-STRING>
        <ATTRIBUTE-VALUE-XHTML><DEFINITION><ATTRIBUTE-DEFINITION-XHTML-REF>ax</ATTRIBUTE-DEFINITION-XHTML-REF></DEFINITION><THE-VALUE><xhtml:div>It shall <xhtml:b>open</xhtml:b>.<xhtml:br/>Always, if v &lt; 1.</xhtml:div></THE-VALUE></ATTRIBUTE-VALUE-XHTML>
        <ATTRIBUTE-VALUE-ENUMERATION><DEFINITION><ATTRIBUTE-DEFINITION-ENUMERATION-REF>ae</ATTRIBUTE-DEFINITION-ENUMERATION-REF></DEFINITION><VALUES><ENUM-VALUE-REF>e1</ENUM-VALUE-REF></VALUES></ATTRIBUTE-VALUE-ENUMERATION>
      </VALUES></SPEC-OBJECT>
      <SPEC-OBJECT IDENTIFIER="AB-2" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="Two" DESC="It shall close."><TYPE><SPEC-OBJECT-TYPE-REF>t</SPEC-OBJECT-TYPE-REF></TYPE><VALUES>
        <ATTRIBUTE-VALUE-ENUMERATION><DEFINITION><ATTRIBUTE-DEFINITION-ENUMERATION-REF>ae</ATTRIBUTE-DEFINITION-ENUMERATION-REF></DEFINITION><VALUES><ENUM-VALUE-REF>e1</ENUM-VALUE-REF></VALUES></ATTRIBUTE-VALUE-ENUMERATION>
      </VALUES></SPEC-OBJECT>
    </SPEC-OBJECTS>
    <SPEC-RELATIONS>
      <SPEC-RELATION IDENTIFIER="x1" LAST-CHANGE="2026-01-02T00:00:00Z"><TYPE><SPEC-RELATION-TYPE-REF>r</SPEC-RELATION-TYPE-REF></TYPE><SOURCE><SPEC-OBJECT-REF>AB-2</SPEC-OBJECT-REF></SOURCE><TARGET><SPEC-OBJECT-REF>o1</SPEC-OBJECT-REF></TARGET></SPEC-RELATION>
      <SPEC-RELATION IDENTIFIER="x2" LAST-CHANGE="2026-01-02T00:00:00Z"><TYPE><SPEC-RELATION-TYPE-REF>v</SPEC-RELATION-TYPE-REF></TYPE><SOURCE><SPEC-OBJECT-REF>o1</SPEC-OBJECT-REF></SOURCE><TARGET><SPEC-OBJECT-REF>AB-2</SPEC-OBJECT-REF></TARGET></SPEC-RELATION>
    </SPEC-RELATIONS>
    <SPECIFICATIONS>
      <SPECIFICATION IDENTIFIER="s" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="All doors"><TYPE><SPECIFICATION-TYPE-REF>st</SPECIFICATION-TYPE-REF></TYPE><CHILDREN>
        <SPEC-HIERARCHY IDENTIFIER="h1" LAST-CHANGE="2026-01-02T00:00:00Z"><OBJECT><SPEC-OBJECT-REF>AB-2</SPEC-OBJECT-REF></OBJECT><CHILDREN>
          <SPEC-HIERARCHY IDENTIFIER="h2" LAST-CHANGE="2026-01-02T00:00:00Z"><OBJECT><SPEC-OBJECT-REF>o1</SPEC-OBJECT-REF></OBJECT></SPEC-HIERARCHY>
        </CHILDREN></SPEC-HIERARCHY>
      </CHILDREN></SPECIFICATION>
    </SPECIFICATIONS>
  </REQ-IF-CONTENT></CORE-CONTENT>
</REQ-IF>
"""
DOOR = Naming({}, {key: text for key, text in NAMING.defaults.items() if key != "status"})


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_reqif_of_somebody_else(encoding: str) -> None:
    documents, found = read(REQIF.encode(encoding), "reqif", DOOR)
    assert [(one["id"], one["title"]) for one in documents[0].requirements] == [
        ("AB-2", "Two"),
        ("AB-1", "One"),
    ]
    two, one = documents[0].requirements
    assert two["refines"] == ["AB-1"]
    assert two["statement"] == "It shall close."
    assert one["statement"] == "It shall open.\nAlways, if v < 1."
    assert one["status"] == "approved"
    assert one["foreign"] == {"link verifies": "AB-2"}
    assert [re.sub(r"^file.reqif:[0-9]+: ", "", text) for text in found] == [
        "warning[T357]: `b` in formatted text is not taken over",
        "warning[T357]: what stands below what in a specification is not taken over",
    ]
    assert exchange.check(documents) == []


def test_an_attribute_that_is_there_twice() -> None:
    """Names of attributes are unique in no ReqIF: of two, the last one was taken without a word, and what is of ASIL D could be QM."""
    defined = re.findall(r"<ATTRIBUTE-DEFINITION-STRING .*</ATTRIBUTE-DEFINITION-STRING>", REQIF)[0]
    given = re.findall(r"<ATTRIBUTE-VALUE-STRING .*</ATTRIBUTE-VALUE-STRING>", REQIF)[0]
    text = REQIF
    for key, word in (("a1", "D"), ("a2", "QM")):
        of_asil = defined.replace('"ai"', f'"{key}"').replace("ReqIF.ForeignID", "asil")
        value = given.replace(">ai<", f">{key}<").replace("AB-1", word)
        text = text.replace(defined, defined + of_asil).replace(given, given + value)
    with pytest.raises(Refused) as refused:
        read(text, "reqif", DOOR)
    assert "`asil` is there twice" in str(refused.value)
    documents, _ = read(text.replace('"QM"', '"D"'), "reqif", DOOR)
    assert documents[0].requirements[1]["asil"] == "D"


def test_a_default_beside_a_column_of_nearly_its_name_is_named() -> None:
    """What is of ASIL D in a column `ASIL` was QM by `--default asil=QM`, and nothing said so."""
    text = "Key,Name,Text,ASIL,Derived From\nAB-1,A,It shall stop.,,AV\nAB-2,B,It shall wait.,D,AV\nAB-3,C,It shall go.,B,AV\n"
    naming = Naming(NAMING.fields, {**NAMING.defaults, "asil": "QM", "derived_from": "AV"})
    documents, found = read(text, "csv", naming)
    assert [re.sub(r"^file.csv:", "", one).split("\n")[0] for one in found] == [
        "2: warning[T357]: `Derived From` is not taken for `derived_from`, which is `AV` by `--default`",
        "3: warning[T357]: `ASIL` is not taken for `asil`, which is `QM` by `--default`",
    ]
    assert "`--field asil=ASIL`" in found[1]
    assert documents[0].requirements[1]["foreign"]["ASIL"] == "D"
    renamed = Naming({**NAMING.fields, "asil": "ASIL", "derived_from": "Derived From"}, naming.defaults)
    documents, found = read(text, "csv", renamed)
    assert (found, [one["asil"] for one in documents[0].requirements]) == ([], ["QM", "D", "B"])


@pytest.mark.parametrize("option", ["--default", "--field"])
def test_of_two_words_for_one_field_none_counts(
    option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of `--default asil=QM --default asil=D` the last one counted, and nothing said so."""
    (tmp_path / "r.csv").write_text("id,title\nR-1,A\n", "utf-8")
    words = ["import", "requirements", str(tmp_path / "r.csv"), "--out", str(tmp_path / "r.yaml")]
    assert main([*words, option, "asil=D", option, "asil=QM"]) == 2
    assert f"error[T360]: `{option} asil=..` is given twice" in capsys.readouterr().err


def test_a_field_by_a_name_that_is_not_there_is_no_default() -> None:
    """What is of ASIL D in a column `ASIL` was QM by `--field asil=Asil --default asil=QM`, and nothing said so."""
    text = "Key,Name,Text,ASIL\nAB-1,A,It shall stop.,D\n"
    named = {**NAMING.fields, "asil": "Asil"}
    _, found = read(text, "csv", Naming(named, NAMING.defaults))
    assert found == [
        "file.csv:2: warning[T357]: no requirement in the file has `Asil`, which is to be `asil`: it is `QM` by `--default` in all of them"
        "\n  help: there is `Key`, `Name`, `Text`, `ASIL`"
    ]
    # Where there is no default either, that is the error that it is without a name.
    without = {name: text for name, text in NAMING.defaults.items() if name != "asil"}
    (one,) = read(text, "csv", Naming(named, without))[1]
    assert "error[T120]: no requirement in the file has `asil`" in one
    # A column in which nothing stands is one all the same.
    assert (
        read(text.replace("ASIL", "Asil").replace(",D", ","), "csv", Naming(named, NAMING.defaults))[1] == []
    )


def test_relations_lead_to_the_ids_that_are_named() -> None:
    """With `--field id=UID`, as StrictDoc calls them, they led to what the file calls its objects, which no requirement is called."""
    given = re.findall(r"<ATTRIBUTE-VALUE-STRING .*</ATTRIBUTE-VALUE-STRING>", REQIF)[0]
    text = REQIF.replace("ReqIF.ForeignID", "UID").replace('"AB-2"', '"o2"').replace(">AB-2<", ">o2<")
    head, body = text.split('DESC="It shall close."')
    text = f'{head}DESC="It shall close."{body.replace("<VALUES>", "<VALUES>" + given.replace("AB-1", "AB-2"), 1)}'
    documents, found = read(text, "reqif", Naming({"id": "UID"}, DOOR.defaults))
    two, one = documents[0].requirements
    assert (two["id"], two["refines"], one["id"], one["foreign"]["link verifies"]) == (
        "AB-2",
        ["AB-1"],
        "AB-1",
        "AB-2",
    )
    assert not [text for text in found if "error" in text]
    assert exchange.check(documents) == []


def test_a_field_in_which_nothing_stands_is_there_all_the_same() -> None:
    """As sphinx-needs writes all of its fields, and ReqIF says which attributes and relations there may be; that nothing in the file has them was said."""
    need: dict[str, object] = {"id": "AB-1", "title": "A", "content": "It shall.", "docname": "d"}
    version = {"needs": {"AB-1": {**need, "state": "", "level": None, "derives": []}}}
    named = Naming({"status": "state", "asil": "level", "refines": "derives"}, NAMING.defaults)
    documents, found = read(json.dumps({"current_version": "1", "versions": {"1": version}}), "needs", named)
    one = documents[0].requirements[0]
    assert (found, one["status"], one["asil"], "refines" in one) == ([], "draft", "QM", False)
    reqif = re.sub(r"<SPEC-RELATION .*</SPEC-RELATION>", "", REQIF)
    reqif = re.sub(r"<ATTRIBUTE-VALUE-ENUMERATION>.*</ATTRIBUTE-VALUE-ENUMERATION>", "", reqif)
    for fields, told in (
        ({"status": "status", "refines": "link verifies"}, 0),
        ({"status": "Status", "refines": "link Refines"}, 2),
    ):
        _, found = read(reqif, "reqif", Naming(fields, NAMING.defaults))
        assert ["no requirement in the file has" in one for one in found].count(True) == told


def test_names_that_everybody_has_in_reqif_may_be_named() -> None:
    """As the page has them: then they were said not to be there."""
    named = Naming({"id": "ReqIF.ForeignID", "statement": "ReqIF.Text"}, DOOR.defaults)
    assert read(REQIF, "reqif", named) == read(REQIF, "reqif", DOOR)


@pytest.mark.parametrize(
    ("theirs", "title", "foreign"),
    [
        ("title", "Old", "ReqIF.Name"),
        ("ReqIF.Name", "New", "title"),
        ("ReqIF.Text", "It shall open.", "title"),
    ],
)
def test_a_name_that_everybody_has_in_reqif_is_the_field_that_it_is_named_as(
    theirs: str, title: str, foreign: str
) -> None:
    """Beside an attribute `title`, that was the title for who had named `ReqIF.Name`; and as another field than its own, a name was said not to be there."""
    defined = re.findall(r"<ATTRIBUTE-DEFINITION-STRING .*</ATTRIBUTE-DEFINITION-STRING>", REQIF)[0]
    given = re.findall(r"<ATTRIBUTE-VALUE-STRING .*</ATTRIBUTE-VALUE-STRING>", REQIF)[0]
    text = REQIF
    for key, name, word in (("a1", "title", "Old"), ("a2", "ReqIF.Name", "New")):
        text = text.replace(
            defined, defined + defined.replace('"ai"', f'"{key}"').replace("ReqIF.ForeignID", name)
        )
        text = text.replace(given, given + given.replace(">ai<", f">{key}<").replace("AB-1", word))
    naming = Naming({"title": theirs}, {**DOOR.defaults, "statement": "It shall."})
    one = read(text, "reqif", naming)[0][0].requirements[1]
    assert one["title"].startswith(title)
    assert one["foreign"][foreign] == {"title": "Old", "ReqIF.Name": "New"}[foreign]


def test_names_that_sphinx_needs_has_may_be_named() -> None:
    """As the page has them: no need was said to have a statement."""
    for name in ("content", "description"):
        needs = {"AB-1": {"id": "AB-1", "title": "A", name: "It shall open.", "docname": "doors"}}
        data = json.dumps({"current_version": "1", "versions": {"1": {"needs": needs}}})
        named = Naming({"statement": name}, NAMING.defaults)
        assert read(data, "needs", named) == read(data, "needs", OURS)
        documents, found = read(data, "needs", Naming({"title": name, "statement": "title"}, NAMING.defaults))
        assert found == []
        assert (documents[0].requirements[0]["title"], documents[0].requirements[0]["statement"]) == (
            "It shall open.",
            "A",
        )


def test_a_column_is_one_field(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of two that it was to be, the second was said to be in no requirement, with the help to name the column."""
    (tmp_path / "r.csv").write_text("id,Text\nR-1,It shall stop.\n", "utf-8")
    words = ["import", "requirements", str(tmp_path / "r.csv"), "--out", str(tmp_path / "r.yaml")]
    assert main([*words, "--field", "title=Text", "--field", "statement=Text"]) == 2
    assert "error[T360]: `Text` is to be `title` and `statement`" in capsys.readouterr().err


def test_a_default_is_named_by_its_word() -> None:
    """And not by its identifier, of which nobody knows what it says."""
    value = "<ATTRIBUTE-VALUE-ENUMERATION><DEFINITION><ATTRIBUTE-DEFINITION-ENUMERATION-REF>ae</ATTRIBUTE-DEFINITION-ENUMERATION-REF></DEFINITION><VALUES><ENUM-VALUE-REF>e1</ENUM-VALUE-REF></VALUES></ATTRIBUTE-VALUE-ENUMERATION>"
    type_ = "<TYPE><DATATYPE-DEFINITION-ENUMERATION-REF>de</DATATYPE-DEFINITION-ENUMERATION-REF></TYPE>"
    text = REQIF.replace(type_, f"{type_}<DEFAULT-VALUE>{value}</DEFAULT-VALUE>")
    assert any(
        "the default `approved` of the attribute `status` is not" in one
        for one in read(text, "reqif", DOOR)[1]
    )


@pytest.mark.parametrize(
    ("pattern", "other", "twice"),
    [
        ("<ENUM-VALUE .*</ENUM-VALUE>", ("approved", "draft"), "e1"),
        ("<ATTRIBUTE-DEFINITION-ENUM.*</ATTRIBUTE-DEFINITION-ENUMERATION>", ("status", "asil"), "ae"),
        ('<SPEC-RELATION-TYPE IDENTIFIER="r".*/>', ("Refines", "verifies"), "r"),
    ],
)
def test_an_identifier_that_is_there_twice(pattern: str, other: tuple[str, str], twice: str) -> None:
    """The last one counted: what is approved was a draft, a status an ASIL, and what refines something verified it."""
    found = re.findall(pattern, REQIF)[0]
    with pytest.raises(Refused, match=rf"T355.*`{twice}` is there twice"):
        read(REQIF.replace(found, found + found.replace(*other)), "reqif", DOOR)
    assert read(REQIF.replace(found, found + found), "reqif", DOOR)[0] == read(REQIF, "reqif", DOOR)[0]


def test_groups_of_relations_are_named() -> None:
    group = """<SPEC-RELATION-GROUPS><RELATION-GROUP IDENTIFIER="g" LAST-CHANGE="2026-01-02T00:00:00Z" LONG-NAME="All">
      <SOURCE-SPECIFICATION><SPECIFICATION-REF>s</SPECIFICATION-REF></SOURCE-SPECIFICATION><SPEC-RELATIONS><SPEC-RELATION-REF>x1</SPEC-RELATION-REF></SPEC-RELATIONS>
      <TARGET-SPECIFICATION><SPECIFICATION-REF>s</SPECIFICATION-REF></TARGET-SPECIFICATION></RELATION-GROUP></SPEC-RELATION-GROUPS>"""
    _, found = read(REQIF.replace("</SPECIFICATIONS>", f"</SPECIFICATIONS>{group}").encode(), "reqif", DOOR)
    assert [text for text in found if "relations" in text] == [
        "file.reqif: warning[T357]: what groups relations is not taken over"
    ]


@pytest.mark.parametrize("end", ["SOURCE", "TARGET"])
def test_a_relation_without_an_end_is_not_left_out(end: str) -> None:
    """The package passes over it, and a requirement refined nothing any more."""
    text = re.sub(f"<{end}>.*?</{end}>", "", REQIF, count=1)
    with pytest.raises(Refused, match=rf"^file.reqif:33: error\[T354\]: <SPEC-RELATION> has no <{end}>"):
        read(text, "reqif", DOOR)


@pytest.mark.parametrize(
    ("said", "refused"),
    [("AB-9", True), ("AB-1; AB-9", True), ("AB-1, AB-1", False), ("AB-1", False), ("", False)],
)
def test_an_attribute_beside_relations_of_its_name(said: str, refused: bool) -> None:
    """What it said went with the relations that took its place."""
    defined = re.findall(r"<ATTRIBUTE-DEFINITION-STRING .*</ATTRIBUTE-DEFINITION-STRING>", REQIF)[0]
    given = re.findall(r"<ATTRIBUTE-VALUE-STRING .*</ATTRIBUTE-VALUE-STRING>", REQIF)[0]
    text = REQIF.replace(
        defined, defined + defined.replace('"ai"', '"ar"').replace("ReqIF.ForeignID", "refines")
    )
    head, body = text.split('DESC="It shall close."')
    body = body.replace("<VALUES>", "<VALUES>" + given.replace(">ai<", ">ar<").replace("AB-1", said), 1)
    text = f'{head}DESC="It shall close."{body}'
    if not refused:
        assert read(text, "reqif", DOOR)[0][0].requirements[0]["refines"] == ["AB-1"]
        return
    with pytest.raises(
        Refused,
        match=rf"T355.*`refines` is there twice, as the attribute `{said}` and as relations to `AB-1`",
    ):
        read(text, "reqif", DOOR)


def test_types_of_objects_are_named_where_there_are_several() -> None:
    """What tools keep among requirements for information only became one, and nothing said so."""
    note = REQIF.replace(
        "</SPEC-TYPES>", '<SPEC-OBJECT-TYPE IDENTIFIER="n" LONG-NAME="Information"/></SPEC-TYPES>'
    )
    head, body = note.split('DESC="It shall close."')
    text = f'{head}DESC="It shall close."{body.replace(">t</SPEC-OBJECT-TYPE-REF>", ">n</SPEC-OBJECT-TYPE-REF>", 1)}'
    said = "warning[T357]: of which type an object is (`Information`, `T`) is not taken over"
    assert [said in one for one in read(text, "reqif", DOOR)[1]].count(True) == 1
    assert not any("of which type" in one for one in read(note, "reqif", DOOR)[1])


def test_the_original_of_what_a_tool_has_simplified_is_named() -> None:
    """A picture may be in it, which the simplified text does not have."""
    original = "<THE-ORIGINAL-VALUE><xhtml:div>It shall <xhtml:object data='x.png'/></xhtml:div></THE-ORIGINAL-VALUE>"
    found = read(REQIF.replace("</THE-VALUE>", f"</THE-VALUE>{original}"), "reqif", DOOR)[1]
    said = "the original of `ReqIF.Text`, which some tool has simplified, is not taken over"
    assert any(said in one for one in found)


@pytest.mark.parametrize(
    ("held", "named"), [("<REQ-IF-TOOL-EXTENSION><v xmlns='v'/></REQ-IF-TOOL-EXTENSION>", 1), ("", 0)]
)
def test_extensions_of_other_tools_are_named(held: str, named: int) -> None:
    text = REQIF.replace("</CORE-CONTENT>", f"</CORE-CONTENT>\n<TOOL-EXTENSIONS>{held}</TOOL-EXTENSIONS>")
    said = (
        "file.reqif:44: warning[T357]: what the other tool keeps in extensions of its own is not taken over"
    )
    assert read(text, "reqif", DOOR)[1].count(said) == named


def test_a_number_that_is_larger_than_any_is_none() -> None:
    """It was infinite, and no file could hold it any more."""
    need = '{"current_version": "1", "versions": {"1": {"needs": {"AB-1": {"id": "AB-1", "weight": 1e999}}}}}'
    with pytest.raises(Refused, match=r"T350.*`1e999` is no number"):
        read(need, "needs")


@pytest.mark.parametrize(
    "said",
    ["json:", "json:abc", "json:NaN", "json:-1e999", 'json:["\\ud800"]', "json:" + "[" * 100_000],
    ids=range(6),
)
def test_a_foreign_text_that_is_no_json_goes_out_as_a_text(said: str) -> None:
    """What is no number, half a character and what is nested too deep ended the export as an internal error; other texts came back with more around them."""
    quoted = said.replace('"', '""')
    documents, _ = read(f'Key,Name,Text,Note\nAB-1,A,It shall stop.,"{quoted}"\n', "csv", NAMING)
    out = exchange.export(documents, "needs", "P", NOW)
    assert json.loads(out)["versions"]["1.0"]["needs"]["AB-1"]["Note"] == said
    assert read(out, "needs", Naming())[0][0].requirements[0]["foreign"]["Note"] == said


FORMATTED = {
    "shall<xhtml:pre>stop\n  wait\n<xhtml:b>go\non</xhtml:b></xhtml:pre>\nand\nthen": "It shall\nstop\nwait\ngo\non\nand then open.",
    "shall:<xhtml:ul>\n <xhtml:li>stop</xhtml:li>\n <xhtml:li>wait</xhtml:li>\n</xhtml:ul>and then": "It shall:\nstop\nwait\nand then open.",
    "shall<xhtml:pre>stop <xhtml:del>now</xhtml:del>\nwait</xhtml:pre>then": "It shall\nstop\nwait\nthen open.",
    "within<xhtml:p>10 s</xhtml:p>": "It within\n10 s\nopen.",
    "at 10<xhtml:sup>-3</xhtml:sup> m/s<xhtml:sup>2</xhtml:sup>": "It at 10^-3 m/s^2 open.",
    "<xhtml:table><xhtml:tr><xhtml:td>at 5</xhtml:td><xhtml:td>0.1 s</xhtml:td></xhtml:tr></xhtml:table>": "It\nat 5 0.1 s\nopen.",
    "shall <!-- not\n --><?tool says?>always": "It shall always open.",
    "within <xhtml:del>10 <xhtml:b>long</xhtml:b> s</xhtml:del> 5 s": "It within 5 s open.",
    '<xhtml:s>never</xhtml:s><xhtml:span style="text-decoration: line-through">or <xhtml:strike>not</xhtml:strike> always</xhtml:span> shall': "It shall open.",
}  # fmt: skip


@pytest.mark.parametrize("markup", FORMATTED)
def test_formatted_text_is_what_one_reads(markup: str) -> None:
    """Words behind a list ran into its last point, cells into one number, an exponent into its base; a comment was no ReqIF."""
    text = REQIF.replace("shall <xhtml:b>open</xhtml:b>.<xhtml:br/>Always, if v &lt; 1.", f"{markup} open.")
    documents, _ = read(text.replace("<DATATYPES>", "<!-- by a tool --><DATATYPES>"), "reqif", DOOR)
    assert documents[0].requirements[1]["statement"] == FORMATTED[markup]


def test_what_is_struck_out_and_what_is_a_chapter_is_no_requirement_and_is_named() -> None:
    """DOORS has headings as objects of their own, and strikes out what a text says no longer."""
    chapter = REQIF.replace('LONG-NAME="ReqIF.Text"', 'LONG-NAME="ReqIF.ChapterName"').replace("shall <xhtml:b>open</xhtml:b>.", "<xhtml:del>Old</xhtml:del>")  # fmt: skip
    relations = chapter[chapter.index("<SPEC-RELATIONS>") : chapter.index("</SPEC-RELATIONS>")]
    documents, found = read(chapter.replace(relations, "<SPEC-RELATIONS>"), "reqif", DOOR)
    assert [one["id"] for one in documents[0].requirements] == ["AB-2"]
    said = [re.sub(r"^file.reqif:[0-9]+: ", "", text) for text in found]
    assert "warning[T357]: `Old`, which is struck out in `ReqIF.ChapterName`, is not taken over" in said
    assert any(text.startswith("warning[T357]: the chapter `It") for text in said)


def test_much_that_is_struck_out_is_named_in_one_pass() -> None:
    """Each was looked for among all that was named before: of 100 kB it took 2 s, and of twice as much four times that."""

    def named(count: int) -> None:
        struck = "".join(f"<xhtml:s>no {n}</xhtml:s>" for n in range(count))
        _, found = read(REQIF.replace("shall <xhtml:b>open</xhtml:b>.", f"{struck}shall"), "reqif", DOOR)
        assert sum("is struck out in" in one for one in found) == count

    assert grows(named, 1_500, 6_000) < 8  # as the square of it, 16


@pytest.mark.parametrize("cell", ["#NAME?", " #VALUE! ", "#REF!", "########", "Err:509"])
def test_what_a_spreadsheet_has_lost_is_no_statement(cell: str) -> None:
    """It takes `- the door shall ..` for a formula."""
    text = f"id,title,statement\nA-1,a,It shall open.\nA-2,b,{cell}\n"
    with pytest.raises(Refused) as refused:
        read(text.encode(), "csv", NAMING)
    assert (refused.value.code, refused.value.line) == ("T358", 3)
    assert read(text.replace(cell, f"It says {cell}.").encode(), "csv", NAMING)[0]


def test_lines_are_those_of_the_file_behind_a_comment() -> None:
    broken = REQIF.replace("<SPEC-OBJECT-REF>o1</SPEC-OBJECT-REF></OBJECT>", "<SPEC-OBJECT-REF>o3</SPEC-OBJECT-REF></OBJECT>")  # fmt: skip
    lines = []
    for comment in "\n\n\n", "<!-- a\n\n b\n -->":
        with pytest.raises(Refused) as refused:
            read(broken.replace("<DATATYPES>", f"{comment}<DATATYPES>"), "reqif", DOOR)
        lines.append(refused.value.line or 0)
    assert lines[0] == lines[1] > 1


@pytest.mark.parametrize(
    "text",
    [
        "id;title;statement;\r\nA-1;a;It shall open.;\r\n;;;\r\n",
        "id;title;statement;Size, in m, or none;x,y\nA-1;a;It shall open.;3;4\n",
        "\ufeff\r\nid;title;statement\r\nA-1;a;It shall open.\r\n",
        "document;id;title;statement\n;;;\nlist;A-1;a;It shall open.\n;;;\n",
    ],
)
def test_a_spreadsheet_leaves_columns_and_lines_empty(text: str) -> None:
    """And a name of a column may have a comma where semicolons divide."""
    found: list[Finding] = []
    (document,) = exchange.read(text.encode(), "csv", "file.csv", OURS, found)
    (one,) = document.requirements
    assert (found, one["id"], one["statement"]) == ([], "A-1", "It shall open.")


def test_a_new_row_on_top_says_less_of_its_list_than_the_others() -> None:
    """It has the list's name and no title, and then the list was said to have two."""
    row = "{},A,It shall stop.\n"
    text = f"document,document_title,document_source,Key,Name,Text\nl,,,{row.format('AB-2')}l,Brakes,a book,{row.format('AB-1')}"
    documents, found = read(text, "csv", NAMING)
    (one,) = documents
    assert (found, one.name, one.table["title"], one.table["source"]) == ([], "l", "Brakes", "a book")
    assert [str(r["id"]) for r in one.requirements] == ["AB-2", "AB-1"]
    with pytest.raises(Refused, match=r"T354.*two titles"):
        read(f"{text}l,Doors,,{row.format('AB-3')}", "csv", NAMING)


def test_a_new_row_says_to_which_list_it_belongs() -> None:
    """It was a list of its own, which has no name, and the help led from a file to a folder and back."""
    text = "document,id,title,statement\nlist,A-1,a,It shall open.\n,A-2,b,It shall close.\n"
    with pytest.raises(Refused, match="names no list under `document`, and others do") as refused:
        read(text, "csv", OURS)
    assert (refused.value.code, refused.value.line) == ("T354", 3)
    assert "`list`" in str(refused.value.help)


@pytest.mark.parametrize("said", ["TBD", "-", "?"])
def test_another_tools_texts_are_kept_whatever_they_say(said: str) -> None:
    """`TBD` in a column that has no field here kept the whole file out."""
    (document,), found = read(f"id,title,statement,Comment\nA-1,a,It shall open.,{said}\n", "csv", OURS)
    assert not [finding for finding in found if "T126" in finding], found
    assert document.requirements[0]["foreign"] == {"Comment": said}


def test_a_cell_below_no_name_is_not_passed_over() -> None:
    with pytest.raises(Refused, match="column 4"):
        read("id;title;statement;;\nA-1;a;It shall open.;b;\n", "csv", OURS)


@pytest.mark.parametrize("version", [["1"], {"a": 1}, None, 1])
def test_a_current_version_that_is_no_name(version: object) -> None:
    """A list was an internal error."""
    data = {"current_version": version, "versions": {"1": {"needs": {}}, "2": {"needs": {}}}}
    with pytest.raises(Refused, match="the current version"):
        read(json.dumps(data), "needs")


@pytest.mark.parametrize(
    ("head", "between", "ends"),
    [("", ",", "\n"), ("\ufeff", ";", "\r\n"), ("", "\t", "\n"), ("\ufeffsep=;\r\n", ";", "\r\n"), ("SEP=\t\n", "\t", "\n")],
)  # fmt: skip
def test_a_spreadsheet_writes_what_its_country_has_between_cells(head: str, between: str, ends: str) -> None:
    """Where numbers have commas, cells have semicolons between them; lines are those of the file."""
    rows = [
        ["id", "title", "statement", "metrics", "Size"],
        ["A-1", '"Doors, both"', "It shall open.", '"a; b"', "1,5 m"],
    ]
    rows[1] = [f'"{cell}"' if between in cell and not cell.startswith('"') else cell for cell in rows[1]]
    text = head + "".join(between.join(row) + ends for row in rows)
    found: list[Finding] = []
    (document,) = exchange.read(text.encode(), "csv", "file.csv", OURS, found)
    assert found == []
    (one,) = document.requirements
    assert (one["title"], one["metrics"], one["foreign"]) == ("Doors, both", ["a", "b"], {"Size": "1,5 m"})
    assert one.place.line == 2 + ("sep" in head.lower())


def test_a_cell_with_a_semicolon_is_one_cell_where_commas_divide() -> None:
    found: list[Finding] = []
    text = "id,title;x,statement\nA-1,a;b,It shall open.\n"
    (document,) = exchange.read(text.encode(), "csv", "file.csv", OURS, found)
    assert document.requirements[0]["foreign"] == {"title;x": "a;b"}


def test_a_column_of_another_name_is_one_error() -> None:
    """One for each field and row, and that the id `` was there twice, buried what was to be done."""
    found: list[Finding] = []
    text = "Key,Name,statement\n" + "".join(f"A-{n},a,It shall open.\n" for n in range(1, 4))
    documents = exchange.read(text.encode(), "csv", "file.csv", OURS, found)
    (one,) = [*found, *exchange.check(documents)]
    assert (one.code, one.message) == ("T120", "no requirement in the file has `id`, `title`")
    assert "there is `Key`, `Name`" in one.help
    assert "--field id=NAME" in one.help


def _messages() -> list[tuple[str, bytes]]:
    """Files that cannot be used, by the format that they should be of."""
    needs = '{"versions": {"1": {"needs": {\n"A-1": {"id": "A-1"}}}}}'
    return [
        ("csv", b""), ("csv", b"id,title\n\xff,x\n"), ("csv", b"id,id\n"), ("csv", b"id,,b\n"), ("csv", b"id,title\nA-1\n"), ("csv", b'id,title\nA-1,"x\n'),
        ("csv", b"document,document_title,id\na,x,A-1\na,y,A-2\n"), ("csv", b"id,title\nA 1,x\n"), ("csv", b"id," + b"x" * 201 + b"\nA-1,y\n"),
        ("needs", b"[1]"), ("needs", b"{}"), ("needs", b'{"versions": {"1": {}'), ("needs", b'{"versions": {"1": {}}}'), ("needs", b'{"versions": {"1": {}, "2": {}}}'),
        ("needs", needs.replace('"id": "A-1"', '"id": "A-2"').encode()), ("needs", needs.replace('{"id": "A-1"}', "3").encode()),
        ("needs", needs.replace('{"id": "A-1"}', '{"a": 1, "a": 2}').encode()), ("needs", b'{"versions": NaN}'), ("needs", b"[" * 100_000), ("needs", needs.encode()),
        ("reqif", b""), ("reqif", REQIF.encode()[:900]), ("reqif", b"<a/>"), ("reqif", b"<a>\n" * 300), ("reqif", b'<?xml version="1.0" encoding="latin-1"?><a/>'),
        ("reqif", b'<?xml version="1.0"?>\n<!DOCTYPE a [<!ENTITY b "c">]>\n<REQ-IF>&b;</REQ-IF>'), ("reqif", b"<REQ-IF>\xff</REQ-IF>"),
        ("reqif", REQIF.replace('<SPEC-OBJECT-REF>o1</SPEC-OBJECT-REF></TARGET>', "<SPEC-OBJECT-REF>o3</SPEC-OBJECT-REF></TARGET>").encode()),
        ("reqif", REQIF.replace("<SPEC-OBJECT-REF>o1</SPEC-OBJECT-REF></OBJECT>", "<SPEC-OBJECT-REF>o3</SPEC-OBJECT-REF></OBJECT>").encode()),
        ("reqif", REQIF.replace('IDENTIFIER="o1"', 'IDENTIFIER="AB-2"').encode()), ("reqif", REQIF.replace('IDENTIFIER="ai"', 'IDENTIFIER="ak"').encode()),
        ("reqif", REQIF.replace(">e1<", ">e2<", 1).encode()), ("reqif", REQIF.encode()),
    ]  # fmt: skip


def test_messages() -> None:
    """Word for word."""
    said = []
    for format, data in _messages():
        try:
            said += [
                f"# {format}: {data[:60]!r}",
                *read(data, format, NAMING if format == "needs" else DOOR)[1],
            ]
        except Refused as refused:
            said.append(str(refused))
    actual = "\n".join(said) + "\n"
    if os.environ.get("TRACKMARSHAL_UPDATE_GOLDEN") == "1":
        GOLDEN.parent.mkdir(exist_ok=True)
        GOLDEN.write_text(actual, encoding="utf-8")
    assert actual == GOLDEN.read_text(encoding="utf-8")
    for code in ("T350", "T353", "T354", "T355", "T356", "T357", "T358"):
        assert f"[{code}]" in actual


def test_links_that_lead_nowhere_and_ids_that_are_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    root = project(tmp_path)
    monkeypatch.chdir(root)
    text = "id,title,statement,rationale,refines,derived_from,status,asil,verification,source\n{},A,It shall.,B,{},{},draft,QM,test,C\n"
    for id_, parent, interface, said in [
        ("ZZ-1", "S-1-A-6", "AV-RO", ""), ("ZZ-2", "S-1-A-66", "", "`refines` of `ZZ-2` leads to `S-1-A-66`, which is not there"),
        ("RR-1", "S-1-A-6", "", "the id `RR-1` is there twice"), ("ZZ-3", "", "AV-XX", "`derived_from` of `ZZ-3` leads to `AV-XX`"),
    ]:  # fmt: skip
        Path("in.csv").write_text(text.format(id_, parent, interface))
        assert main(["import", "requirements", "in.csv", "--out", f"requirements/{id_}.yaml"]) == (
            2 if said else 0
        )
        assert said in capsys.readouterr().err
        assert Path(f"requirements/{id_}.yaml").exists() == (not said)


def test_lists_that_come_back_by_their_titles(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As StrictDoc names them: each list is one error, which says what to do, and doing that is enough."""
    root = project(tmp_path)
    monkeypatch.chdir(root)
    documents = [exchange.Document(str(one.table.text("title")), one.table) for one in shipped()]
    Path("back.csv").write_bytes(exchange.export(documents, "csv", "P", NOW))
    before = {path.name: path.read_text("utf-8") for path in Path("requirements").iterdir()}
    assert main(["import", "requirements", "back.csv", "--force"]) == 2
    err = capsys.readouterr().err
    assert err.count("error[T355]") == len(documents)
    assert "the id `RR-1` is there twice, and so are 3 more of `requirements/race-rules.yaml`" in err
    assert "rename it to what the list is called now" in err
    assert {path.name: path.read_text("utf-8") for path in Path("requirements").iterdir()} == before
    for one in shipped():
        now = re.sub(r"\W+", "-", str(one.table.text("title")))
        Path("requirements", f"{one.name}.yaml").rename(f"requirements/{now}.yaml")
    assert main(["import", "requirements", "back.csv", "--force"]) == 0
    assert "T365" not in capsys.readouterr().err


def test_what_goes_beside_the_project_has_no_ids_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whoever wanted to look at it first was told to write it over the project's file."""
    monkeypatch.chdir(project(tmp_path))
    head = "id,title,statement,rationale,refines,status,asil,verification,source\n"
    row = "RR-1,A,It shall.,B,RR-2,draft,QM,test,C\n"
    Path("in.csv").write_text(head + row)
    for out, status in (("../look.yaml", 0), ("requirements/look.yaml", 2)):
        assert main(["import", "requirements", "in.csv", "--out", out]) == status
        assert ("T355" in capsys.readouterr().err) == (status == 2)
    Path("in.csv").write_text(head + row * 2)
    assert main(["import", "requirements", "in.csv", "--out", "../more.yaml"]) == 2
    assert "error[T355]: the id `RR-1` is there twice" in capsys.readouterr().err


def test_an_id_that_is_in_the_file_twice_and_in_the_project_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(project(tmp_path))
    row = "RR-1,A,It shall.,B,S-1-A-6,draft,QM,test,C\n"
    Path("in.csv").write_text(
        "id,title,statement,rationale,refines,status,asil,verification,source\n" + row * 2
    )
    assert main(["import", "requirements", "in.csv"]) == 2
    assert sorted(re.findall(r"in.csv:(\d+): error\[T355\].*twice(.*)", capsys.readouterr().err)) == [
        ("2", ""),
        ("3", ""),
    ]


def test_a_need_that_quotes_is_read_in_one_pass() -> None:
    """As one that holds a file of XML: 16 kB of it took 8 s, and twice of it four times as long."""

    def quoting(count: int) -> None:
        need = {"content": 'say "so": {' * count}
        drafts, _ = read(json.dumps({"versions": {"1": {"needs": {"A-1": need}}}}), "needs")
        assert [one.text("id") for one in drafts[0].requirements] == ["A-1"]

    assert grows(quoting, 1_000, 4_000) < 8  # as the square of it, 16


def test_what_is_too_large_is_not_read(tmp_path: Path) -> None:
    file = tmp_path / "big.csv"
    with file.open("wb") as stream:
        stream.truncate(exchange.content.MAX_BYTES + 1)
    with pytest.raises(Refused) as refused:
        exchange.load(file, "big.csv")
    assert refused.value.code == "T351"


@pytest.mark.parametrize("more", [[], ["--format", "reqif"], ["--format", "csv"]])
def test_an_archive_is_called_one(
    more: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Most tools write `.reqifz`: it was to be named by `--format`, and then to be saved as UTF-8."""
    monkeypatch.chdir(tmp_path)
    with zipfile.ZipFile("doors.reqifz", "w") as archive:
        archive.writestr("doors.reqif", REQIF)
    assert main(["import", "requirements", "doors.reqifz", *more]) == 2
    err = capsys.readouterr().err
    assert "error[T350]: a ZIP archive" in err
    assert "import the `.reqif` in it" in err


def test_a_cell_has_an_end() -> None:
    documents, _ = read(FOREIGN_CSV, "csv", NAMING)
    documents[0].requirements[0]["foreign"]["Owner"] = "x" * 131_071
    assert exchange.export(documents, "csv", "P", NOW)
    documents[0].requirements[0]["foreign"]["Owner"] = "x" * 131_072
    with pytest.raises(Refused) as refused:
        exchange.export(documents, "csv", "P", NOW)
    assert refused.value.code == "T352"


def test_half_a_character_is_not_written() -> None:
    documents, _ = read(FOREIGN_CSV, "csv", NAMING)
    documents[0].requirements[0]["foreign"]["Owner"] = "\ud800"
    with pytest.raises(Refused) as refused:
        exchange.yaml(documents[0])
    assert refused.value.code == "T352"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["import", "requirements", "in.txt"], "error[T360]"),
        (["export", "requirements"], "error[T360]"),
        (["import", "requirements", "in.csv", "--field", "nonsense=A"], "error[T360]"),
        (["import", "requirements", "in.csv", "--map", "m.yaml"], "no such option: --map"),
        (["import", "requirements", "in.csv", "--format", "json"], "no format `json`"),
        (["import", "log", "in.csv"], "required: --map"),
        (["import", "log", "in.csv", "--map", "m.yaml", "--force"], "no such option: --force"),
        (["import", "requirements"], "required: FILE"),
        (["import", "requirements", "all.needs.json", "--out", "one.yaml"], "error[T360]"),
    ],
)  # fmt: skip
def test_arguments_that_say_too_little(
    arguments: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(project(tmp_path))
    Path("in.csv").write_text(FOREIGN_CSV)
    Path("in.txt").write_text(FOREIGN_CSV)
    Path("all.needs.json").write_bytes(exchange.export(shipped(), "needs", "P", NOW))
    assert main(arguments) == 2
    assert said in capsys.readouterr().err


def test_without_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "reqif.parser", None)
    with pytest.raises(Refused) as refused:
        exchange.export(shipped(), "reqif", "P", NOW)
    assert refused.value.code == "T359"
    assert "trackmarshal[exchange]" in str(refused.value)


@pytest.mark.parametrize(
    "text",
    [
        '{"review": "a", "review": "b"}',
        '{"review": 1}',
        '{"review": {"a": "b"}}',
        "[]",
        '[["review", "a"]]',
        "1",
        "{",
        "",
    ],
)
def test_names_with_texts_that_are_none_stay_what_they_are(text: str) -> None:
    """Nothing is dropped on the way: what has no meaning as names with texts is refused as a text."""
    from trackmarshal.trace.exchange.content import _shaped

    assert _shaped("not_verified_by", text) == text
    assert _shaped("not_verified_by", '{"review": "a", "test": ""}') == {"review": "a", "test": ""}
