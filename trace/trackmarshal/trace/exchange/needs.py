"""Requirements as sphinx-needs keeps them: needs.json, by version and id, links as lists of ids."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from datetime import datetime
from typing import Any, NoReturn

from trackmarshal.json_text import named_twice
from trackmarshal.trace.exchange.content import (
    ESCAPE,
    FIELDS,
    Document,
    Draft,
    Item,
    Naming,
    Value,
    attributes,
)
from trackmarshal.trace.exchange.refused import Refused, decoded
from trackmarshal.trace.findings import Finding, Place, warning

#: What sphinx-needs itself works out for a need; it is not of the requirement.
INTERNAL = frozenset({
    "arch", "collapse", "constraints_error", "constraints_passed", "constraints_results", "content_id", "content_node", "docname", "doctype",
    "external_css", "external_url", "has_dead_links", "has_forbidden_dead_links", "hide", "hide_status", "hide_tags", "id_complete", "id_parent",
    "is_external", "is_import", "is_modified", "is_need", "is_part", "jinja_content", "layout", "lineno", "lineno_content", "modifications", "parts",
    "post_template", "pre_template", "section_name", "sections", "signature", "style", "target_id", "template", "type_color", "type_name",
    "type_prefix", "type_style",
})  # fmt: skip
_RESERVED = (*FIELDS, *INTERNAL, "content", "description")
_TYPE = "req"
_RAW = "json:"
_BACK = "_back"  # of links the other way, which follow from the links


def write(documents: Sequence[Document], project: str, created: datetime) -> bytes:
    """The documents as one version of needs.json. What is no text in foreign attributes is what it was when it was imported."""
    needs: dict[str, Any] = {}
    for document in documents:
        for one in document.requirements:
            said: dict[str, Any] = dict(attributes(one, _RESERVED, _BACK))
            for name in [name for name in said if name not in FIELDS]:
                said[name] = _value(said[name])
            type_ = said.pop("type", None)
            if type_ == _TYPE:  # said in so many words by whoever wrote the requirement
                said["foreign:type"], type_ = type_, None
            content = said.pop("statement")
            needs[said["id"]] = {
                **said, "type": type_ or _TYPE, "type_name": "Requirement", "content": content,
                "docname": document.name, "sections": [str(document.table.text("title"))], "is_need": True,
            }  # fmt: skip
    stamp = created.isoformat(timespec="seconds")
    listed = [
        {"docname": one.name, "title": one.table.text("title"), "source": one.table.text("source")}
        for one in documents
    ]
    version = {
        "created": stamp, "creator": {"program": "trackmarshal"}, "filters": {}, "filters_amount": 0,
        "documents": listed, "needs": needs, "needs_amount": len(needs),
    }  # fmt: skip
    data = {"created": stamp, "current_version": "1.0", "project": project, "versions": {"1.0": version}}
    return (json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode("utf-8")


def read(data: bytes, shown: str, found: list[Finding], naming: Naming) -> list[Draft]:
    """The needs of the current version, a document for each `docname`; what `naming` takes for a field is read as one; raises T350 for what is no JSON, T354 for what is no needs.json, T355."""
    text = decoded(data, shown)
    whole = _parsed(text, shown)
    version = _version(whole, shown)
    lines = _lines(text)
    titles = {
        str(one.get("docname", "")): one for one in version.get("documents", ()) if isinstance(one, dict)
    } if isinstance(version.get("documents", ()), list) else {}  # fmt: skip
    drafts = {
        name: Draft(name, str(one.get("title") or name), str(one.get("source") or ""))
        for name, one in titles.items()
    }
    dropped: dict[str, str] = {}
    left_out = _left_out(version)
    for key, need in version["needs"].items():
        line = lines.get(key, 0)
        if not isinstance(need, dict):
            raise Refused(
                "T354", f"the need `{key}` is no object", shown, line, "export it again with sphinx-needs"
            )
        if need.get("id", key) != key:
            message = f"the need `{key}` says that its id is `{need['id']}`"
            raise Refused("T354", message, shown, line, "export it again with sphinx-needs")
        for name in need:
            if (
                _is_internal(name)
                and name not in ("docname", "sections", "type_name", "is_need")
                and _says(need[name])
                and need[name] is not False
            ):
                dropped.setdefault(name, key)
        name = str(need.get("docname") or "")
        sections = need.get("sections") or [name or whole.get("project") or "Requirements"]
        draft = drafts.setdefault(
            name, Draft(name, str(sections[0] if isinstance(sections, list) else sections))
        )
        draft.items.append(
            Item(
                _attributes(key, {**need, **{n: v for n, v in left_out.items() if n not in need}}, naming),
                line,
            )
        )
    _lead_to_ids([item for draft in drafts.values() for item in draft.items], naming)
    for name, key in sorted(dropped.items()):
        message = f"`{name}` of needs is not taken over, first of `{key}`: sphinx-needs works it out, or shows the need with it"
        found.append(warning("T357", message, Place(shown, lines.get(key, 0))))
    return list(drafts.values())


def _lead_to_ids(items: Sequence[Item], naming: Naming) -> None:
    """Links lead to needs by their keys; where requirements are called by another field, they lead to what that says."""
    ids = {str(item.attributes["id"]): item.attributes.get(naming.fields.get("id", "id")) for item in items}
    links = naming.fields.get("refines", "refines")
    for item in items:
        targets = item.attributes.get(links)
        if isinstance(targets, list):
            item.attributes[links] = [str(ids.get(target) or target) for target in targets]


def _left_out(version: dict[str, Any]) -> dict[str, Any]:
    """What needs say that say nothing of it: sphinx-needs leaves out what is a field's default, and says in the schema which that is."""
    schema = version.get("needs_schema")
    fields = (
        schema.get("properties")
        if isinstance(schema, dict) and version.get("needs_defaults_removed")
        else None
    )
    if not isinstance(fields, dict):
        return {}
    return {
        name: field["default"]
        for name, field in fields.items()
        if isinstance(field, dict) and "default" in field and not _is_internal(name)
    }


def _attributes(key: str, need: dict[str, Any], naming: Naming) -> dict[str, Value]:
    said: dict[str, Value] = {"id": key}
    asked = frozenset(naming.fields.values())
    for name, value in need.items():
        if _is_internal(name) or name == "id":
            continue
        if name not in asked and (not _says(value) or (name == "type" and value == _TYPE)):
            continue
        # Before version 2, sphinx-needs wrote `description` for `content`.
        text = (
            name not in asked
            and "statement" not in need
            and "statement" not in naming.fields
            and (name == "content" or (name == "description" and "content" not in need))
        )
        named = "statement" if text else name
        if named in FIELDS or name in asked:
            texts = isinstance(value, list) and all(isinstance(entry, str) for entry in value)
            said[named] = value if isinstance(value, str) or texts else json.dumps(value, ensure_ascii=False)
            if not _says(value):
                said[named] = ""  # it is there, and empty
        else:
            plain = isinstance(value, str) and _value(value) is value
            said[named] = value if plain else _RAW + json.dumps(value, ensure_ascii=False)
    return said


def _is_internal(name: str) -> bool:
    return name in INTERNAL or (name.endswith(_BACK) and not name.startswith(ESCAPE))


def _value(text: str) -> Any:
    """What a foreign value stands for; the text itself where that is nothing that a file of JSON can hold."""
    if not text.startswith(_RAW):
        return text
    try:
        value = json.loads(text[len(_RAW) :])
        json.dumps(value, ensure_ascii=False, allow_nan=False).encode()
    except (ValueError, RecursionError):
        return text
    return value


def _says(value: Any) -> bool:
    return value is not None and value not in ([], {}) and (not isinstance(value, str) or bool(value.strip()))


def _parsed(text: str, shown: str) -> dict[str, Any]:
    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        made = dict(pairs)
        if len(made) < len(pairs):
            twice = named_twice(name for name, _ in pairs)
            lines = [
                text.count("\n", 0, at.start()) + 1
                for at in re.finditer(re.escape(json.dumps(twice, ensure_ascii=False)) + r"\s*:", text)
            ]
            raise Refused(
                "T355", f"`{twice}` is there twice", shown, lines[-1] if lines else 0, "keep one of them"
            )
        return made

    def no_number(word: str) -> NoReturn:
        raise Refused("T350", f"`{word}` is no number of JSON", shown, help="write null, or a text")

    def number(word: str) -> float:
        value = float(word)
        return value if math.isfinite(value) else no_number(word)

    try:
        data = json.loads(text, object_pairs_hook=once, parse_constant=no_number, parse_float=number)
    except json.JSONDecodeError as problem:
        raise Refused(
            "T350", f"not JSON: {problem.msg}", shown, problem.lineno, "is the file whole?"
        ) from None
    except (RecursionError, ValueError) as problem:
        reason = "nested too deeply" if isinstance(problem, RecursionError) else str(problem)
        raise Refused(
            "T350", f"not JSON that can be read: {reason}", shown, help="is this a file of needs?"
        ) from None
    if not isinstance(data, dict):
        raise Refused(
            "T354",
            "no needs.json: it is no object",
            shown,
            1,
            "sphinx-needs writes it with the builder `needs`",
        )
    return data


def _version(whole: dict[str, Any], shown: str) -> dict[str, Any]:
    versions = whole.get("versions")
    if not isinstance(versions, dict) or not versions:
        raise Refused(
            "T354",
            "no needs.json: it has no `versions`",
            shown,
            1,
            "sphinx-needs writes it with the builder `needs`",
        )
    name = whole.get("current_version", "")
    if not isinstance(name, str) or name not in versions:
        if len(versions) > 1:
            raise Refused(
                "T354",
                f"the current version `{name}` is none of those in the file: {', '.join(versions)}",
                shown,
                1,
                "set `current_version` to one of them",
            )
        name = next(iter(versions))
    version = versions[name]
    if not isinstance(version, dict) or not isinstance(version.get("needs"), dict):
        raise Refused(
            "T354",
            f"the version `{name}` has no `needs` by their ids",
            shown,
            1,
            "export it again with sphinx-needs",
        )
    return version


def _lines(text: str) -> dict[str, int]:
    """By key of an object in the file, the line where it stands first."""
    lines: dict[str, int] = {}
    line, before = 1, 0
    # Every text is passed as a whole: whoever looks for one from each quotation mark in it reads the rest of it as often.
    for match in re.finditer(r'"((?:[^"\\\n]|\\.)*)"(\s*:\s*\{)?', text):
        if not match[2]:
            continue
        line += text.count("\n", before, match.start())
        before = match.start()
        try:
            lines.setdefault(json.loads(f'"{match[1]}"'), line)
        except ValueError:
            continue
    return lines
