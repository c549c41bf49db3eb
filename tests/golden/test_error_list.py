"""docs/errors.md: every code with its meaning, and an example where the goldens hold one.

The page is made from the catalogue that `trackmarshal explain CODE` prints. `TRACKMARSHAL_UPDATE_GOLDEN=1 pytest tests/golden`
writes it anew.
"""

from __future__ import annotations

import os
import re
import textwrap
from collections.abc import Iterable
from pathlib import Path

import pytest

from trackmarshal.cli.catalogue import catalogue
from trackmarshal.cli.main import main
from trackmarshal.runtime.door.cases import KEYS
from trackmarshal.trace.documents import DOCUMENTS

GOLDEN = Path(__file__).parent
PAGE = GOLDEN.parents[1] / "docs" / "errors.md"
UPDATE = os.environ.get("TRACKMARSHAL_UPDATE_GOLDEN") == "1"
#: First letters of codes, and what they are about.
GROUPS = (
    ("E0", "Reading specs"),
    ("E1", "Syntax"),
    ("E2", "Names and clauses"),
    ("E3", "Dimensions and values"),
    ("W", "Warnings"),
    ("E4", "Tests, projects and commands"),
    ("E5", "Elements that come and go"),
    ("D1", "Recordings and data files"),
    ("D2", "Cases: the input contract"),
    ("T1", "Requirements"),
    ("T2", "Links, coverage and evidence"),
    ("T3", "The link graph, the baseline, other test runners and tools"),
    ("T4", "The argument as goal structure, and the safety case"),
)
HEAD = """# Errors

Every message has a code that stays the same from release to release. `trackmarshal explain CODE` prints what stands here. The exit
status is 1 where something was found, 2 where an input or an argument cannot be used; with `--exit-zero`, 0 instead of 1.

"""


def page() -> str:
    codes = catalogue()
    examples = _examples()
    parts = [HEAD]
    for prefix, title in GROUPS:
        parts.append(f"## {title}\n\n")
        for code in [code for code in codes if code.startswith(prefix)]:
            name, explanation = codes.pop(code)
            wrapped = textwrap.fill(explanation, 132, break_long_words=False, break_on_hyphens=False)
            parts.append(f"### {code}: {name}\n\n{wrapped}\n\n")
            if code in examples:
                parts.append(f"```text\n{examples[code]}```\n\n")
    assert not codes, f"codes of no group: {list(codes)}"
    return "".join(parts).rstrip() + "\n"


def _examples() -> dict[str, str]:
    """The shortest message of each code in the goldens of specs, with a help if any has one."""
    found: dict[str, str] = {}
    for path in sorted([*(GOLDEN / "syntax").glob("*.txt"), *(GOLDEN / "semantics").glob("*.txt")]):
        for message in re.split(r"\n(?=(?:error|warning)\[)", path.read_text("utf-8")):
            match = re.match(r"(?:error|warning)\[(\w+)\]", message)
            if match is not None:
                shown = message.rstrip("\n") + "\n"
                best = found.get(match[1])
                if best is None or _order(shown) < _order(best):
                    found[match[1]] = shown
    return found


def _order(message: str) -> tuple[bool, int, str]:
    return "= help: " not in message, len(message), message


def test_the_page_is_up_to_date() -> None:
    made = page()
    if UPDATE:
        PAGE.write_text(made, "utf-8", newline="\n")
    assert made == PAGE.read_text("utf-8")


@pytest.mark.parametrize("code", catalogue())
def test_explain_knows_every_code(code: str, capsys: pytest.CaptureFixture[str]) -> None:
    title, explanation = catalogue()[code]
    assert main(["explain", code.lower()]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith(f"{code}: {title}\n")
    assert " ".join(printed.split()).endswith(" ".join(explanation.split()))
    assert title[0].islower() or title.split()[0].isupper() or title.startswith(("YAML", "JSON"))
    assert explanation.endswith((".", "}"))


@pytest.mark.parametrize(("code", "all_"), [("T113", DOCUMENTS), ("D201", KEYS)])
def test_what_lists_all_lists_all(code: str, all_: Iterable[str]) -> None:
    assert set(all_) <= set(re.findall(r"[a-z-]+", catalogue()[code][1]))


def test_records_are_said_to_be_written_by_what_writes_them() -> None:
    """The results folder has none: results are in the evidence store, and what `replay --out` writes is in the folder that is named."""
    assert not re.search(r"results folder|`(test|replay|assess)`", catalogue()["T290"][1])
