"""Lists of requirements to a ReqIF file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime
from typing import TYPE_CHECKING, Any

from trackmarshal.trace.exchange.content import BETWEEN, FIELDS, Document, Value, attributes
from trackmarshal.trace.exchange.refused import Refused
from trackmarshal.trace.exchange.reqif_file import REFINES, STANDARD, require
from trackmarshal.trace.exchange.xml_text import XML_CHARACTERS

if TYPE_CHECKING:
    from reqif.models.reqif_spec_object import SpecObjectAttribute

_SCHEMA = "http://www.omg.org/spec/ReqIF/20110401/reqif.xsd"
_LONGEST = "1000000"
#: What another tool calls by these names would be read as fields of ours.
_RESERVED = (*FIELDS, *STANDARD.values())


def write(documents: Sequence[Document], project: str, created: datetime, shown: str) -> bytes:
    """The documents as ReqIF in UTF-8; raises T352 for characters that XML has none of, T359."""
    require(shown)
    from reqif.models.reqif_core_content import ReqIFCoreContent
    from reqif.models.reqif_data_type import ReqIFDataTypeDefinitionString
    from reqif.models.reqif_namespace_info import ReqIFNamespaceInfo
    from reqif.models.reqif_req_if_content import ReqIFReqIFContent
    from reqif.models.reqif_reqif_header import ReqIFReqIFHeader
    from reqif.models.reqif_spec_hierarchy import ReqIFSpecHierarchy
    from reqif.models.reqif_spec_object import ReqIFSpecObject
    from reqif.models.reqif_spec_object_type import ReqIFSpecObjectType
    from reqif.models.reqif_spec_relation import ReqIFSpecRelation
    from reqif.models.reqif_spec_relation_type import ReqIFSpecRelationType
    from reqif.models.reqif_specification import ReqIFSpecification
    from reqif.models.reqif_specification_type import ReqIFSpecificationType
    from reqif.object_lookup import ReqIFObjectLookup
    from reqif.reqif_bundle import ReqIFBundle
    from reqif.unparser import ReqIFUnparser

    stamp = created.isoformat(timespec="seconds")
    said = [
        (document, one, attributes(one, _RESERVED)) for document in documents for one in document.requirements
    ]
    for document, one, values in said:
        for name, value in values.items():
            _fit(
                f"{name} {value if isinstance(value, str) else BETWEEN.join(value)}",
                f"`{name}` of `{one.text('id')}`",
                document,
            )
    for document in documents:
        _fit(
            f"{document.name}{document.table.text('title')}{document.table.text('source')}",
            "the head",
            document,
        )
    names = dict.fromkeys(
        [name for name in FIELDS if name != REFINES]
        + [name for _, _, values in said for name in values if name not in FIELDS]
    )
    of_object = {name: f"attribute-{number}" for number, name in enumerate(names)}
    of_list = {name: f"list-{name}" for name in ("document", "source")}

    def object_of(values: dict[str, Value]) -> ReqIFSpecObject:
        held = [_attribute(of_object[name], value) for name, value in values.items() if name != REFINES]
        return ReqIFSpecObject(_identifier(str(values["id"])), held, "type-requirement", last_change=stamp)

    def list_of(number: int, document: Document) -> ReqIFSpecification:
        children = [
            ReqIFSpecHierarchy(identifier=f"place-{one.text('id')}", spec_object=_identifier(one.text("id")), level=1, last_change=stamp, editable=None, is_table_internal=None, is_self_closed=False)
            for one in document.requirements
        ]  # fmt: skip
        texts = {"document": document.name, "source": str(document.table.text("source"))}
        held = [_attribute(of_list[name], text) for name, text in texts.items() if text]
        return ReqIFSpecification(
            f"list-of-requirements-{number}",
            last_change=stamp,
            long_name=str(document.table.text("title")),
            values=held,
            specification_type="type-list",
            children=children,
        )

    content = ReqIFReqIFContent(
        data_types=[ReqIFDataTypeDefinitionString("text", last_change=stamp, long_name="Text", max_length=_LONGEST)],
        spec_types=[
            ReqIFSpecObjectType("type-requirement", last_change=stamp, long_name="Requirement", attribute_definitions=[_definition(key, STANDARD.get(name, name), stamp) for name, key in of_object.items()]),
            ReqIFSpecRelationType("type-refines", last_change=stamp, long_name=REFINES),
            ReqIFSpecificationType("type-list", last_change=stamp, long_name="Requirements", spec_attributes=[_definition(key, name, stamp) for name, key in of_list.items()]),
        ],
        spec_objects=[object_of(values) for _, _, values in said],
        spec_relations=[
            ReqIFSpecRelation(f"refines-{values['id']}-{number}", "type-refines", _identifier(str(values["id"])), _identifier(target), last_change=stamp)
            for _, _, values in said for number, target in enumerate(values.get(REFINES, ()))
        ],
        specifications=[list_of(number, document) for number, document in enumerate(documents)],
    )  # fmt: skip
    _fit(project, "the project's name", None)
    header = ReqIFReqIFHeader(
        "header",
        creation_time=stamp,
        repository_id=_xml(project),
        req_if_tool_id="trackmarshal",
        req_if_version="1.0",
        source_tool_id="trackmarshal",
        title="-",
    )
    namespace = ReqIFNamespaceInfo.create_default()
    namespace.namespace, namespace.namespace_xhtml = _SCHEMA, "http://www.w3.org/1999/xhtml"
    bundle = ReqIFBundle(namespace, header, ReqIFCoreContent(content), False, ReqIFObjectLookup.empty(), [])
    text = str(ReqIFUnparser.unparse(bundle))
    # The package would write the title as it is.
    text = text.replace("<TITLE>-</TITLE>", f"<TITLE>{_xml(project)}</TITLE>", 1)
    # Readers of XML make blanks of line breaks and tabs in attributes, unless they are written as references.
    escaped = re.sub(
        r'="[^"]*"',
        lambda value: value[0].replace("\n", "&#10;").replace("\r", "&#13;").replace("\t", "&#9;"),
        text,
    )
    return escaped.encode("utf-8")


def _attribute(key: str, value: Value) -> SpecObjectAttribute:
    from reqif.models.reqif_spec_object import SpecObjectAttribute
    from reqif.models.reqif_types import SpecObjectAttributeType

    text = value if isinstance(value, str) else BETWEEN.join(value)
    return SpecObjectAttribute(SpecObjectAttributeType.STRING, key, text)


def _definition(key: str, name: str, stamp: str) -> Any:
    from reqif.models.reqif_spec_object_type import SpecAttributeDefinition
    from reqif.models.reqif_types import SpecObjectAttributeType

    return SpecAttributeDefinition(
        SpecObjectAttributeType.STRING, key, "text", last_change=stamp, long_name=name
    )


def _identifier(name: str) -> str:
    return f"requirement-{name}"


def _xml(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def _fit(text: str, where: str, document: Document | None) -> None:
    wrong = XML_CHARACTERS.search(text)
    if wrong:
        file = "" if document is None else document.table.place.file
        message = f"{where} holds U+{ord(wrong[0]):04X}, a character that XML does not have"
        raise Refused("T352", message, file, help="remove it, or export as CSV or needs.json")
