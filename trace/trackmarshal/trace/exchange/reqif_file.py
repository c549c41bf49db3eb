"""Requirements as ReqIF 1.2, through the package `reqif` (the extra `trackmarshal[exchange]`), which is imported late.

A list of requirements is a specification, a requirement an object of the type `Requirement`, and what it refines a relation of the type `refines`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from datetime import datetime
from importlib import import_module
from typing import TYPE_CHECKING, Any

from trackmarshal.trace.exchange.content import (
    BETWEEN,
    ESCAPE,
    FIELDS,
    Document,
    Draft,
    Item,
    Naming,
    Value,
    attributes,
)
from trackmarshal.trace.exchange.refused import Refused
from trackmarshal.trace.exchange.xml_text import XML_CHARACTERS, checked
from trackmarshal.trace.findings import Finding, Place, warning

if TYPE_CHECKING:
    from reqif.models.reqif_spec_object import ReqIFSpecObject, SpecObjectAttribute
    from reqif.reqif_bundle import ReqIFBundle

#: Names that ReqIF's implementation guide gives to what everybody has.
STANDARD = {"id": "ReqIF.ForeignID", "title": "ReqIF.Name", "statement": "ReqIF.Text"}
#: And what a heading says that is an object of its own.
_CHAPTER = "ReqIF.ChapterName"
_MEANT = {theirs: ours for ours, theirs in STANDARD.items()}
_RESERVED = (*FIELDS, *_MEANT)
_SCHEMA = "http://www.omg.org/spec/ReqIF/20110401/reqif.xsd"
_REFINES = "refines"
#: Elements that are lines of their own.
_BLOCKS = frozenset({
    "div", "p", "li", "tr", "h1", "h2", "h3", "h4", "h5", "h6", "ul", "ol", "dl", "dt", "dd", "table", "caption", "blockquote", "pre", "hr", "address",
})  # fmt: skip
#: Elements whose text is shown as no longer said.
_STRUCK = frozenset({"del", "s", "strike"})
#: What stands before the text of an element that means something else without it: 10^-3, and two cells that are no number together.
_BEFORE = {"sup": "^", "sub": "_", "td": " ", "th": " "}
_LONGEST = "1000000"


def require(shown: str) -> None:
    """Raise T359 where the package is not installed."""
    try:
        import_module("reqif.parser")
    except ImportError:
        raise Refused(
            "T359",
            "ReqIF is read and written by the package `reqif`, which is not installed",
            shown,
            help="pip install 'trackmarshal[exchange]'",
        ) from None


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
        [name for name in FIELDS if name != _REFINES]
        + [name for _, _, values in said for name in values if name not in FIELDS]
    )
    of_object = {name: f"attribute-{number}" for number, name in enumerate(names)}
    of_list = {name: f"list-{name}" for name in ("document", "source")}

    def object_of(values: dict[str, Value]) -> ReqIFSpecObject:
        held = [_attribute(of_object[name], value) for name, value in values.items() if name != _REFINES]
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
            ReqIFSpecRelationType("type-refines", last_change=stamp, long_name=_REFINES),
            ReqIFSpecificationType("type-list", last_change=stamp, long_name="Requirements", spec_attributes=[_definition(key, name, stamp) for name, key in of_list.items()]),
        ],
        spec_objects=[object_of(values) for _, _, values in said],
        spec_relations=[
            ReqIFSpecRelation(f"refines-{values['id']}-{number}", "type-refines", _identifier(str(values["id"])), _identifier(target), last_change=stamp)
            for _, _, values in said for number, target in enumerate(values.get(_REFINES, ()))
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
    text = text.replace(
        "<TITLE>-</TITLE>", f"<TITLE>{_xml(project)}</TITLE>", 1
    )  # which the package would write as it is
    # Readers of XML make blanks of line breaks and tabs in attributes, unless they are written as references.
    escaped = re.sub(
        r'="[^"]*"',
        lambda value: value[0].replace("\n", "&#10;").replace("\r", "&#13;").replace("\t", "&#9;"),
        text,
    )
    return escaped.encode("utf-8")


def read(data: bytes, shown: str, found: list[Finding], naming: Naming) -> list[Draft]:
    """The specifications of a ReqIF file, with links to requirements by the ids that `naming` has; raises T350, T353, T354, T356, T359, and names what is not taken over in `found` (T357)."""
    text = checked(data, shown)
    require(shown)
    from reqif.parser import ReqIFParser

    extension = re.search(r"<(?:[\w.-]+:)?REQ-IF-TOOL-EXTENSION[\s/>]", text)
    if extension:
        line = text.count("\n", 0, extension.start()) + 1
        message = "what the other tool keeps in extensions of its own is not taken over"
        found.append(warning("T357", message, Place(shown, line)))
    try:
        bundle = ReqIFParser.parse_from_string(text)
        for lacking in bundle.exceptions:  # the package leaves out what it is about, and says so nowhere else
            raise _incomplete(lacking, shown)
        return list(_Reading(bundle, shown, found, naming).drafts())
    except Refused:
        raise
    except Exception as problem:  # whatever the package meets in a file that is not as it expects
        raise Refused(
            "T354",
            f"no ReqIF that can be read: {type(problem).__name__}: {problem}",
            shown,
            help="does it follow ReqIF's schema?",
        ) from problem


def named(naming: Naming) -> Naming:
    """The names of fields without those that are read so anyway, such as `ReqIF.Text`."""
    fields = {ours: theirs for ours, theirs in naming.fields.items() if STANDARD.get(ours) != theirs}
    return Naming(fields, naming.defaults)


def _incomplete(lacking: Any, shown: str) -> Refused:
    """An element that lacks one that each of its kind has, such as a relation an end."""
    message = f"<{lacking.xml_node.tag}> has no <{lacking.tag}>"
    return Refused("T354", message, shown, _line(lacking), "does the file follow ReqIF's schema?")


class _Reading:
    """One file; every object once, in the order of the specifications."""

    def __init__(self, bundle: ReqIFBundle, shown: str, found: list[Finding], naming: Naming) -> None:
        self._shown, self._found = shown, found
        self._asked = {theirs: ours for ours, theirs in naming.fields.items()}  #: fields by names of the file
        self._called = named(naming).fields.get("id", "id")
        self._told: set[str] = set()  #: what is not taken over, each once
        self._first: dict[str, Any] = {}  #: by type of objects, the first requirement of it
        content = bundle.core_content.req_if_content if bundle.core_content else None
        if content is None:
            raise Refused("T354", "no ReqIF: it has no content", shown, 1, "export it again")
        self._content: Any = content
        self._title = bundle.req_if_header.title if bundle.req_if_header else None
        self._words = {
            word.identifier: word.long_name or word.key for kind in content.data_types or () for word in getattr(kind, "values", None) or ()
        }  # fmt: skip
        self._kinds: dict[str, str] = {
            kind.identifier: kind.long_name or kind.identifier for kind in content.spec_types or ()
        }
        self._names: dict[str, str] = {}
        for kind in content.spec_types or ():
            for definition in [
                *(getattr(kind, "attribute_definitions", None) or ()),
                *(getattr(kind, "spec_attributes", None) or ()),
            ]:
                self._names[definition.identifier] = definition.long_name or definition.identifier
                if isinstance(definition.default_value, str):
                    self._dropped(
                        f"the default `{self._words.get(definition.default_value) or definition.default_value}` of the attribute `{definition.long_name}`",
                        definition.xml_node,
                    )
        self._declared = {*self._names.values(), *map(_link, self._kinds.values())}
        self._objects: dict[Any, Any] = {}
        for one in content.spec_objects or ():
            if one.identifier in self._objects:
                raise Refused(
                    "T355",
                    f"`{one.identifier}` is there twice",
                    shown,
                    _line(one),
                    "identifiers are unique in ReqIF",
                )
            self._objects[one.identifier] = one
        if content.spec_relation_groups:
            self._dropped("what groups relations", None)
        self._held = {key: self._values(one.attributes) for key, one in self._objects.items()}
        for key, one in self._objects.items():
            self._named(key, one)
        self._relate()

    def drafts(self) -> Iterator[Draft]:
        seen: set[str] = set()
        for number, one in enumerate(self._content.specifications or ()):
            head = self._values(one.values or ())
            title = one.long_name or self._title or "Requirements"
            draft = Draft(
                str(head.pop("document", "") or one.long_name or f"list-{number + 1}"),
                title,
                str(head.pop("source", "")),
            )
            for name in head:
                self._dropped(f"`{name}` of the specification `{title}`", one.xml_node)
            for place in self._places(one.children or ()):
                if place.spec_object not in self._objects:
                    raise Refused(
                        "T356",
                        f"the specification `{title}` holds `{place.spec_object}`, which is not in the file",
                        self._shown,
                        _line(place),
                        "export it whole",
                    )
                if place.spec_object in seen:
                    self._dropped(f"a second place of `{place.spec_object}`", place.xml_node)
                    continue
                seen.add(place.spec_object)
                if self._is_chapter(place.spec_object):
                    continue
                draft.items.append(self._item(place.spec_object))
            yield draft
        rest = [key for key in self._objects if key not in seen and not self._is_chapter(key)]
        if rest:
            yield Draft("others", self._title or "Requirements", "", [self._item(key) for key in rest])
        if len(self._first) > 1:  # what is there for information only, and what is demanded
            named = ", ".join(f"`{kind}`" for kind in self._first)
            self._dropped(f"of which type an object is ({named})", list(self._first.values())[1].xml_node)

    def _places(self, children: Any) -> Iterator[Any]:
        for place in children:
            yield place
            if place.children:
                self._dropped("what stands below what in a specification", place.xml_node)
                yield from self._places(place.children)

    def _is_chapter(self, key: str) -> bool:
        """Whether an object is no requirement but a heading above some, as DOORS has them; what it says is named."""
        held = self._held[key]
        if not held.get(_CHAPTER) or held.get("statement"):
            return False
        self._dropped(f"the chapter `{held[_CHAPTER]}`", self._objects[key].xml_node)
        return True

    def _item(self, key: str) -> Item:
        kind = self._objects[key].spec_object_type
        self._first.setdefault(self._kinds.get(kind, kind), self._objects[key])
        return Item(self._held[key], _line(self._objects[key]))

    def _named(self, key: str, one: Any) -> None:
        """Names that ReqIF gives to everybody's attributes, as ours, unless they are asked for as another field; where there is no such attribute, what
        the object itself has. What is asked for and only declared is there, and empty."""
        held = {self._ours(name, self._held[key]): value for name, value in self._held[key].items()}
        held.setdefault("id", key)
        if one.long_name:
            held.setdefault("title", one.long_name)
        if one.description:
            held.setdefault("ReqIF.Description" if "statement" in held else "statement", one.description)
        for name in self._asked:
            if name in self._declared:
                held.setdefault(name, "")
        self._held[key] = held

    def _ours(self, name: str, held: Collection[str]) -> str:
        """What an attribute is called here: where two are one of our fields, the one that is asked for is it."""
        ours = _MEANT.get(name)
        if ours is not None and self._asked.get(name, ours) == ours:
            return ours if name in self._asked or ours not in held else name
        theirs = STANDARD.get(name)
        beside = theirs is not None and theirs in held and self._asked.get(theirs) == name
        return ESCAPE + name if beside else name

    def _values(self, held: Sequence[SpecObjectAttribute]) -> dict[str, Value]:
        said: dict[str, Value] = {}
        for one, (name, value) in zip(held, self._named_values(held)):
            if said.setdefault(name, value) != value:
                raise Refused(
                    "T355",
                    f"`{name}` is there twice, as `{said[name]}` and as `{value}`",
                    self._shown,
                    _line(one),
                    "give one of the two attributes another name, or export one of them",
                )
        return said

    def _named_values(self, held: Sequence[SpecObjectAttribute]) -> Iterator[tuple[str, Value]]:
        for one in held:
            name = self._names.get(one.definition_ref)
            if name is None:
                raise Refused(
                    "T356",
                    f"a value is of the attribute `{one.definition_ref}`, which is not defined",
                    self._shown,
                    _line(one),
                    "export it whole",
                )
            if isinstance(one.value, list):
                missing = [word for word in one.value if word not in self._words]
                if missing:
                    raise Refused(
                        "T356",
                        f"`{name}` is `{missing[0]}`, which is no value of its type",
                        self._shown,
                        _line(one),
                        "export it whole",
                    )
                yield name, BETWEEN.join(self._words[word] or word for word in one.value)
            elif one.value_stripped_xhtml is not None:
                yield name, self._plain(name, one)
            else:
                yield name, one.value

    def _plain(self, name: str, one: SpecObjectAttribute) -> str:
        """The text of formatted text; what formats it is named."""
        value = one.xml_node.find("THE-VALUE") if one.xml_node is not None else None
        if value is None:
            raise Refused(
                "T354",
                f"`{name}` has no value",
                self._shown,
                _line(one),
                "does the file follow ReqIF's schema?",
            )
        if (
            one.xml_node.find("THE-ORIGINAL-VALUE") is not None
        ):  # a tool that could not show all of it has kept it
            self._dropped(f"the original of `{name}`, which some tool has simplified,", one.xml_node)
        said = struck = ""
        inside = 0  # in how many elements that strike out
        verbatim = 0  # in how many whose lines stand as they are
        for event, node in _walk(value):
            tag = str(node.tag).rsplit("}", 1)[-1]
            begins = event == "start"
            if strikes := tag in _STRUCK or "line-through" in (node.get("style") or ""):
                inside += 1 if begins else -1
            if inside or strikes:  # that a text holds no more is no part of what it says
                struck += (node.text or "") if begins else (node.tail or "") if inside else ""
                if inside:
                    continue
                self._dropped(f"`{' '.join(struck.split())}`, which is struck out in `{name}`,", node)
                struck = ""
                behind = node.tail or ""
                behind = behind if verbatim else re.sub(r"[ \t\r\n]+", " ", behind)
                said += behind.removeprefix(" ") if said.endswith((" ", "\n")) else behind
                continue
            if begins and tag not in _BLOCKS and tag not in ("br", "span", "THE-VALUE"):
                self._dropped(f"`{tag}` in formatted text", node)
            if tag in _BLOCKS:
                said = said.rstrip(" ")
            if (tag == "br" and begins) or (tag in _BLOCKS and not said.endswith("\n")):
                said += "\n"
            if begins:
                said += _BEFORE.get(tag, "")
            if tag == "pre":
                verbatim += 1 if begins else -1
            text = (node.text if begins else node.tail) or ""
            said += text if verbatim else re.sub(r"[ \t\r\n]+", " ", text)
        return "\n".join(line.strip() for line in said.strip().split("\n"))

    def _relate(self) -> None:
        related: dict[str, dict[str, list[str]]] = {}
        for one in self._content.spec_relations or ():
            for end in (one.source, one.target):
                if end not in self._objects:
                    raise Refused(
                        "T356",
                        f"the relation `{one.identifier}` leads to `{end}`, which is not in the file",
                        self._shown,
                        _line(one),
                        "export it whole",
                    )
            if one.values:
                self._dropped(f"what the relation `{one.identifier}` says beside its ends", one.xml_node)
            kind = self._kinds.get(one.relation_type_ref, one.relation_type_ref)
            name = _link(kind)
            target = self._held[one.target]
            id_ = str(target.get(self._called) or target["id"])
            related.setdefault(one.source, {}).setdefault(name, []).append(id_)
        for key, links in related.items():
            for name, targets in links.items():
                said = str(self._held[key].get(name, ""))
                if set(re.split(r"[;,\s]+", said)) - {"", *targets}:
                    raise Refused(
                        "T355",
                        f"`{name}` is there twice, as the attribute `{said}` and as relations to `{BETWEEN.join(targets)}`",
                        self._shown,
                        _line(self._objects[key]),
                        "give the attribute another name, or export one of the two",
                    )
                self._held[key][name] = targets

    def _dropped(self, what: str, node: Any) -> None:
        line = getattr(node, "sourceline", None) or 0
        if what not in self._told:
            self._told.add(what)
            self._found.append(warning("T357", f"{what} is not taken over", Place(self._shown, line)))


def _link(kind: str) -> str:
    """What relations of a type are called."""
    return _REFINES if kind.lower() == _REFINES else f"link {kind}"


def _walk(node: Any) -> Iterator[tuple[str, Any]]:
    """An element's children, each at its start and at its end; the element itself at its start."""
    yield "start", node
    for child in node:
        yield from _walk(child)
        yield "end", child


def _line(one: Any) -> int:
    return getattr(getattr(one, "xml_node", None), "sourceline", None) or 0


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


__all__ = ["ESCAPE", "STANDARD", "named", "read", "require", "write"]
