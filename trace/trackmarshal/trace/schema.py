"""The shapes of the documents as JSON Schema 2020-12: what `requirements/schema.json` holds."""

from __future__ import annotations

import json
from typing import Any

from trackmarshal.trace.documents import DOCUMENTS
from trackmarshal.trace.shapes import Count, Date, Field, Flag, Many, Pairs, Record, Shape, Text, Word


def schema() -> dict[str, Any]:
    """The JSON Schema of every document in a requirements folder."""
    definitions: dict[str, Any] = {}
    documents = [_reference(document, definitions) for document in DOCUMENTS.values()]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Requirements of a trackmarshal project",
        "description": "One of several documents, told apart by `document`. Written from trackmarshal.trace.documents.",
        "oneOf": documents,
        "$defs": dict(sorted(definitions.items())),
    }


def text() -> str:
    """The schema as the file holds it."""
    return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


def _reference(record: Record, definitions: dict[str, Any]) -> dict[str, Any]:
    if record.name not in definitions:
        definitions[record.name] = {}  # taken, should it occur inside itself
        definitions[record.name] = {
            "type": "object",
            "description": record.description,
            "properties": {field.name: _field(field, definitions) for field in record.fields},
            "required": [field.name for field in record.fields if field.required],
            "additionalProperties": False,
        }
    return {"$ref": f"#/$defs/{record.name}"}


def _field(field: Field, definitions: dict[str, Any]) -> dict[str, Any]:
    return {"description": field.description, **_shape(field.shape, definitions)}


def _shape(shape: Shape, definitions: dict[str, Any]) -> dict[str, Any]:
    match shape:
        case Text(pattern="", said=_):
            return {"type": "string", "pattern": r"\S"}
        case Text(pattern=pattern, said=said):
            return {"type": "string", "pattern": f"^(?:{pattern})$", "$comment": said}
        case Word(choices=choices):
            return {
                "enum": list(choices),
                **(
                    {
                        "$comment": "; ".join(
                            f"{word}: {meaning}" for word, meaning in choices.items() if meaning
                        )
                    }
                    if any(choices.values())
                    else {}
                ),
            }
        case Date():
            return {"type": "string", "format": "date", "pattern": "^[0-9]{4}-[0-9]{2}-[0-9]{2}$"}
        case Count():
            return {"type": "integer", "minimum": 0}
        case Flag():
            return {"type": "boolean"}
        case Pairs():
            return {"type": "object", "additionalProperties": {"type": "string", "pattern": r"\S"}}
        case Many(of=inner, least=least):
            return {
                "type": "array",
                "items": _shape(inner, definitions),
                **({"minItems": least} if least else {}),
            }
        case Record():
            return _reference(shape, definitions)
        case _:
            raise TypeError(f"unknown shape {shape!r}")
