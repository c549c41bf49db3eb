"""The folder of an assessment: index.html and a page a run, each a file that needs no other to be read."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from html import escape
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias

from trackmarshal.errors import TrackmarshalError
from trackmarshal.trace import look
from trackmarshal.trace.report.overview import fault_context, index_context
from trackmarshal.trace.report.reading import Run, read_run
from trackmarshal.trace.report.run_view import run_context

#: The parts of a page before and after its date, given all that it is made of besides its record, and what draws it.
Drawing: TypeAlias = Callable[[Sequence[object], Callable[[], tuple[str, str]]], tuple[str, str]]

_TEMPLATES = Path(__file__).with_name("templates")
#: What `meta` and `checks` may hold, as it is where it is not given: templates fail on names that are not there.
_NO_META: dict[str, Any] = {
    "project": "", "created": "", "tool": "", "python": "", "spec_fingerprint": "", "command": "", "versions": {}, "notes": [],
}  # fmt: skip
_NO_CHECKS: dict[str, Any] = {
    "modules": None, "rules": None, "errors": None, "warnings": 0, "tests": None, "failed": 0, "failures": [], "uncovered": None,
    "faults": None,
}  # fmt: skip


def write_report(
    folder: Path,
    runs: Sequence[Mapping[str, Any]],
    matrix_html: str | None,
    matrix_summary: Mapping[str, Any],
    missing: Sequence[Mapping[str, Any]],
    checks: Mapping[str, Any],
    meta: Mapping[str, Any],
    faults: Sequence[Mapping[str, str]] = (),
    drawn: Drawing = lambda about, draw: draw(),
    kept: Sequence[Mapping[str, Any]] = (),
    backed: Mapping[str, Mapping[str, str]] = MappingProxyType({}),
) -> Path:
    """Write index.html and runs/NAME.html and return the path of the index; raises T291 or T292.

    runs: records of `trackmarshal.scenarios.run_record`. matrix_html: address of the matrix's page from the folder, None
    where there is none. matrix_summary: the matrix as `trace --format json` writes it; of it `coverage`, `stages` and
    `requirements` are used, where they are there. missing: findings {"code", "level", "message", "id", "cause" (the id of what it follows from), "span" (or "place", or
    "file" and "line"), "help"}. checks: {"modules", "rules", "errors", "warnings", "tests", "failed": numbers, "failures":
    [{"rule", "title", "message", "place"}], "uncovered": [rules whose boundary lacks a test], "faults": (found as expected, put in)}; what is left out is said
    not to have been done. meta: {"project", "created", "tool", "python", "spec_fingerprint", "command", "versions": {name:
    version}, "notes": [text]}; only what is given is shown. faults: rows of `trackmarshal.trace.fault_rows`. drawn: gives the
    parts of a run's page before and after its date, drawn or kept, told all that the page is made of besides its record. kept: runs of logs that are not part of the project, {"path", "title", "cycles", "fired", "day"}.
    backed: by assumption {"evidence", "owner"} where the project says otherwise than its spec. Equal input makes equal pages.
    """
    meta, checks = {**_NO_META, **meta}, {**_NO_CHECKS, **checks}
    read = [read_run(record) for record in runs]
    names = page_names([run.name for run in read])
    pages: dict[str, str] = {}
    titles = {entry["id"]: entry["title"] for entry in matrix_summary.get("requirements", [])}
    for number, run in enumerate(read):
        around = {
            "before": (read[number - 1].name, names[number - 1]) if number else None,
            "after": (read[number + 1].name, names[number + 1]) if number + 1 < len(read) else None,
            "matrix": None if matrix_html is None else f"../{matrix_html}",
        }
        draw = partial(_run_page, run, titles, {**around, "meta": meta})
        undated = {name: said for name, said in meta.items() if name != "created"}
        before, after = drawn([names[number], titles, around, undated], draw)
        pages[_address(names[number])] = before + escape(str(meta["created"])) + after
    linked = [(run, _address(name)) for run, name in zip(read, names)]
    pages["index.html"] = _page(
        "index.html.j2",
        {
            **index_context(linked, matrix_summary, missing, checks, meta, matrix_html, backed),
            **fault_context(faults),
            "kept": kept,
        },
    )
    _write(folder, pages)
    return folder / "index.html"


def page_addresses(runs: Sequence[Mapping[str, Any]]) -> list[str]:
    """The addresses of the pages of runs, from the folder: of records, as `write_report` takes them."""
    return [_address(name) for name in page_names([str(record.get("scenario", "?")) for record in runs])]


def _address(name: str) -> str:
    return f"runs/{name}.html"


def page_names(names: Sequence[str]) -> list[str]:
    """Names of files for runs: letters, digits, `-`, `_` and dots inside, all different, also without regard to case."""
    taken: set[str] = set()
    found = []
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_.-]+", "-", name).strip(".-")[:80] or "run"
        unique, number = plain, 2
        while unique.lower() in taken:
            unique, number = f"{plain}-{number}", number + 1
        taken.add(unique.lower())
        found.append(unique)
    return found


def _write(folder: Path, pages: Mapping[str, str]) -> None:
    path = folder
    try:
        for name, text in pages.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            # Lone surrogates (from odd paths) have no encoding; a page must not fail on them.
            path.write_bytes(text.encode("utf-8", "replace"))
    except OSError as error:
        raise TrackmarshalError(
            "T292", error.strerror or str(error), file=str(path), help="name another folder"
        ) from error


def _run_page(run: Run, titles: Mapping[str, str], around: Mapping[str, Any]) -> tuple[str, str]:
    """The page of a run before its date, which is the last that it says, and after it."""
    undated = {**around["meta"], "created": ""}
    page = _page("run.html.j2", {**run_context(run, titles), **around, "meta": undated})
    before, end, after = page.rpartition("</footer>")
    return before, end + after


def _page(template: str, context: Mapping[str, Any]) -> str:
    return look.environment(_TEMPLATES).get_template(template).render(**context)
