"""A ReqIF file to lists of requirements; every object once, in the order of the specifications."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from trackmarshal.trace.exchange.content import BETWEEN, ESCAPE, Draft, Item, Naming, Value
from trackmarshal.trace.exchange.refused import Refused
from trackmarshal.trace.exchange.reqif_file import REFINES, STANDARD, named, require
from trackmarshal.trace.exchange.reqif_file.formatted import plain
from trackmarshal.trace.exchange.xml_text import checked
from trackmarshal.trace.findings import Finding, Place, warning

if TYPE_CHECKING:
    from reqif.models.reqif_spec_object import SpecObjectAttribute
    from reqif.reqif_bundle import ReqIFBundle

#: What a heading says that is an object of its own.
_CHAPTER = "ReqIF.ChapterName"
_MEANT = {theirs: ours for ours, theirs in STANDARD.items()}


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
            raise _lacking(lacking, shown)
        return list(_Reading(bundle, shown, found, naming).drafts())
    except Refused:
        raise
    except Exception as problem:  # whatever the package meets in a file that is not as it expects
        message = f"no ReqIF that can be read: {type(problem).__name__}: {problem}"
        raise Refused("T354", message, shown, help="does it follow ReqIF's schema?") from problem


def _lacking(lacking: Any, shown: str) -> Refused:
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
        self._words: dict[str, str] = {}
        for kind in content.data_types or ():
            for word in getattr(kind, "values", None) or ():
                self._called_once(self._words, word, word.long_name or word.key, kind)
        self._kinds: dict[str, str] = {}
        for kind in content.spec_types or ():
            self._called_once(self._kinds, kind, kind.long_name or kind.identifier, kind)
        self._names: dict[str, str] = {}
        for kind in content.spec_types or ():
            for definition in [
                *(getattr(kind, "attribute_definitions", None) or ()),
                *(getattr(kind, "spec_attributes", None) or ()),
            ]:
                name = definition.long_name or definition.identifier
                self._called_once(self._names, definition, name, definition)
                if isinstance(definition.default_value, str):
                    self._dropped(
                        f"the default `{self._words.get(definition.default_value) or definition.default_value}` of the attribute `{definition.long_name}`",
                        definition.xml_node,
                    )
        self._declared = {*self._names.values(), *map(_link, self._kinds.values())}
        self._objects: dict[Any, Any] = {}
        for one in content.spec_objects or ():
            if one.identifier in self._objects:
                raise self._twice(one, one)
            self._objects[one.identifier] = one
        if content.spec_relation_groups:
            self._dropped("what groups relations", None)
        self._held = {key: self._values(one.attributes) for key, one in self._objects.items()}
        for key, one in self._objects.items():
            self._named(key, one)
        self._relate()

    def _called_once(self, into: dict[str, str], one: Any, name: str, where: Any) -> None:
        """Note what is called so; raises T355 where its identifier is that of something that is called otherwise: values would be of either."""
        if into.setdefault(one.identifier, name) != name:
            raise self._twice(one, where)

    def _twice(self, one: Any, where: Any) -> Refused:
        return self._refused(
            "T355", f"`{one.identifier}` is there twice", where, "identifiers are unique in ReqIF"
        )

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
                    message = (
                        f"the specification `{title}` holds `{place.spec_object}`, which is not in the file"
                    )
                    raise self._refused("T356", message, place, "export it whole")
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
                message = f"`{name}` is there twice, as `{said[name]}` and as `{value}`"
                raise self._refused(
                    "T355", message, one, "give one of the two attributes another name, or export one of them"
                )
        return said

    def _named_values(self, held: Sequence[SpecObjectAttribute]) -> Iterator[tuple[str, Value]]:
        for one in held:
            name = self._names.get(one.definition_ref)
            if name is None:
                message = f"a value is of the attribute `{one.definition_ref}`, which is not defined"
                raise self._refused("T356", message, one, "export it whole")
            if isinstance(one.value, list):
                missing = [word for word in one.value if word not in self._words]
                if missing:
                    message = f"`{name}` is `{missing[0]}`, which is no value of its type"
                    raise self._refused("T356", message, one, "export it whole")
                yield name, BETWEEN.join(self._words[word] or word for word in one.value)
            elif one.value_stripped_xhtml is not None:
                yield name, self._formatted(name, one)
            else:
                yield name, one.value

    def _formatted(self, name: str, one: SpecObjectAttribute) -> str:
        """The text of formatted text; what formats it is named."""
        value = one.xml_node.find("THE-VALUE") if one.xml_node is not None else None
        if value is None:
            message = f"`{name}` has no value"
            raise self._refused("T354", message, one, "does the file follow ReqIF's schema?")
        # A tool that could not show all of it has kept it.
        if one.xml_node.find("THE-ORIGINAL-VALUE") is not None:
            self._dropped(f"the original of `{name}`, which some tool has simplified,", one.xml_node)
        return plain(value, name, self._dropped)

    def _relate(self) -> None:
        related: dict[str, dict[str, list[str]]] = {}
        for one in self._content.spec_relations or ():
            for end in (one.source, one.target):
                if end not in self._objects:
                    message = f"the relation `{one.identifier}` leads to `{end}`, which is not in the file"
                    raise self._refused("T356", message, one, "export it whole")
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
                    message = f"`{name}` is there twice, as the attribute `{said}` and as relations to `{BETWEEN.join(targets)}`"
                    raise self._refused(
                        "T355",
                        message,
                        self._objects[key],
                        "give the attribute another name, or export one of the two",
                    )
                self._held[key][name] = targets

    def _refused(self, code: str, message: str, one: Any, help: str) -> Refused:
        return Refused(code, message, self._shown, _line(one), help)

    def _dropped(self, what: str, node: Any) -> None:
        line = getattr(node, "sourceline", None) or 0
        if what not in self._told:
            self._told.add(what)
            self._found.append(warning("T357", f"{what} is not taken over", Place(self._shown, line)))


def _link(kind: str) -> str:
    """What relations of a type are called."""
    return REFINES if kind.lower() == REFINES else f"link {kind}"


def _line(one: Any) -> int:
    return getattr(getattr(one, "xml_node", None), "sourceline", None) or 0
