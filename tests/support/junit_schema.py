"""The schema of JUnit XML as Jenkins publishes it (`junit-10.xsd` of its xUnit plugin), as a table, and a document held against it.

Beyond it, a test has `file`, `line` and `properties`, as pytest, GoogleTest and others write them, and readers expect them.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

_ANY = re.compile(r"(?s).*")
_COUNT = re.compile("[0-9]+")
_TIME = re.compile(r"(([0-9]{0,3},)*[0-9]{3}|[0-9]{0,3})*(\.[0-9]{0,3})?")
_SAYS = (
    "skipped",
    "error",
    "failure",
    "rerunFailure",
    "rerunError",
    "flakyFailure",
    "flakyError",
    "system-out",
    "system-err",
)
_MESSAGE = {"message": (False, _ANY), "type": (False, _ANY)}
_COUNTS = {"tests": (True, _COUNT), "failures": (True, _COUNT), "errors": (True, _COUNT)}
#: By element: what may be in it, its attributes (whether they are needed, and what they look like), and whether it may hold text.
SCHEMA = {
    "testsuites": (("testsuite",), {"name": (False, _ANY), "time": (False, _TIME), **{k: (False, v) for k, (_, v) in _COUNTS.items()}}, False),
    "testsuite": (
        ("testsuite", "properties", "testcase", "system-out", "system-err"),
        {"name": (True, _ANY), **_COUNTS, "skipped": (False, _COUNT), "time": (False, _TIME),
         **dict.fromkeys(("group", "timestamp", "hostname", "id", "package", "file", "log", "url", "version"), (False, _ANY))},
        False,
    ),
    "properties": (("property",), {}, False),
    "property": ((), {"name": (True, _ANY), "value": (True, _ANY)}, False),
    "testcase": (
        ("properties", *_SAYS),
        {"name": (True, _ANY), "time": (False, _TIME), "classname": (False, _ANY), "group": (False, _ANY), "file": (False, _ANY),
         "line": (False, _COUNT)},
        False,
    ),
    **dict.fromkeys(("skipped", "error", "failure"), ((), _MESSAGE, True)),
    **dict.fromkeys(("system-out", "system-err"), ((), {}, True)),
}  # fmt: skip


def wrong(text: str) -> list[str]:
    """What does not fit the schema, or the counts of what is there; raises for what is no XML."""
    root = ET.fromstring(text)
    found = [] if root.tag == "testsuites" else [f"the root is {root.tag}"]
    for element in root.iter():
        if element.tag not in SCHEMA:
            found.append(f"unknown <{element.tag}>")
            continue
        inner, attributes, mixed = SCHEMA[element.tag]
        found += [f"<{child.tag}> in <{element.tag}>" for child in element if child.tag not in inner]
        found += [
            f"<{element.tag}> has no {n}"
            for n, (needed, _) in attributes.items()
            if needed and n not in element.attrib
        ]
        for name, value in element.attrib.items():
            if name not in attributes or not attributes[name][1].fullmatch(value):
                found.append(f"<{element.tag} {name}={value!r}>")
        if not mixed and any(
            (part or "").strip() for part in (element.text, *(child.tail for child in element))
        ):
            found.append(f"text in <{element.tag}>")
        if element.tag in ("testsuites", "testsuite"):
            for attribute, path in (
                ("tests", ".//testcase"),
                ("failures", ".//failure"),
                ("errors", ".//error"),
                ("skipped", ".//skipped"),
            ):
                if attribute in element.attrib and int(element.attrib[attribute]) != len(
                    element.findall(path)
                ):
                    found.append(f"{attribute} of <{element.tag}> is not what it holds")
    return found
