"""What a rule author reads about each mistake of meaning, word for word.

Each case is a file `semantics/NAME.spec`, or a folder `semantics/NAME` with a few modules (and a project, where there is one);
`semantics/NAME.txt` is what `trackmarshal check` says of it. After a change that is meant,
`TRACKMARSHAL_UPDATE_GOLDEN=1 pytest tests/golden` writes the texts anew; read the difference before it is committed.
"""

from __future__ import annotations

import ast
import inspect
import os
import sys
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from types import ModuleType
from typing import Any

import pytest

from trackmarshal import semantics
from trackmarshal.cli.check import examine
from trackmarshal.cli.main import main
from trackmarshal.cli.project import MARKER
from trackmarshal.diagnostics import text
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.errors import TrackmarshalError
from trackmarshal.node import Node
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.testing import cases
from trackmarshal.testing import errors as test_errors

FOLDER = Path(__file__).parent / "semantics"
CASES = sorted(path for path in FOLDER.iterdir() if path.is_dir() or path.suffix == ".spec")
UPDATE = os.environ.get("TRACKMARSHAL_UPDATE_GOLDEN") == "1"
#: Places that report what no small spec can bring about, and why.
UNREACHED = {
    "too_deep": "nesting deep enough to exhaust the stack, which tests/unit/test_semantics.py brings about",
}


#: All modules that say what specs mean, and what those of them say that hold nothing else.
SEMANTICS = [
    import_module(found.name) for found in walk_packages(semantics.__path__, f"{semantics.__name__}.")
]
DECLARED = {
    kind
    for module in (*SEMANTICS, test_errors)
    for kind in vars(module).values()
    if isinstance(kind, type) and issubclass(kind, Diagnostic) and kind.__module__ == module.__name__
}


#: Calls that made a diagnostic: module and line.
_LINES: set[tuple[str, int]] = set()


@cache
def said(path: Path) -> list[Diagnostic | TrackmarshalError]:
    """What is said of an example; from where goes into `_LINES`. Once each: all tests here ask."""
    original = Node.__init__

    def watched(self: Node, *args: Any, **kwargs: Any) -> None:
        if isinstance(self, Diagnostic):
            frame = sys._getframe(1)
            while frame is not None and frame.f_code.co_name == "fail":
                frame = frame.f_back  # type: ignore[assignment]
            _LINES.add((frame.f_globals["__name__"], frame.f_lineno))
        original(self, *args, **kwargs)

    Node.__init__ = watched  # type: ignore[method-assign]
    try:
        return _said(path)
    finally:
        Node.__init__ = original  # type: ignore[method-assign]


def _said(path: Path) -> list[Diagnostic | TrackmarshalError]:
    root = FOLDER if path.is_file() else path
    project = path if (path / MARKER).is_file() else None
    return examine(compile_paths([path], root), project)


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_the_message_is_the_one_agreed_on(path: Path) -> None:
    shown = text.render(said(path))
    expected = FOLDER / f"{path.stem}.txt"
    if UPDATE:
        expected.write_text(shown, "utf-8", newline="\n")
    assert shown == expected.read_text("utf-8")


def test_the_command_says_the_same(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(FOLDER / "unknown_requirement")
    assert main(["check", "specs"]) == 1
    expected = (FOLDER / "unknown_requirement.txt").read_text("utf-8")
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == expected + "\n1 module, 1 rule or assumption: 4 errors, 0 warnings\n"


def test_no_expected_text_is_left_over() -> None:
    assert {path.stem for path in FOLDER.glob("*.txt")} == {path.stem for path in CASES}


def test_every_error_of_meaning_has_an_example() -> None:
    seen = {type(found) for path in CASES for found in said(path)}
    assert DECLARED - seen == set()
    assert all(issubclass(kind, Node) and kind.explanation and kind.title for kind in DECLARED)


def test_every_place_that_reports_has_an_example() -> None:
    assert (
        sorted(f"{site.module}:{site.line} {site.function}" for site in _sites() if site not in _reached())
        == []
    )


class Site(Node):
    """A call in the source that makes a diagnostic: the lines it stands on, and the function it is in."""

    module: str
    line: int
    last: int
    function: str


#: Modules that make diagnostics, and the names of what makes them there.
_MAKERS: tuple[tuple[ModuleType, frozenset[str]], ...] = (
    *((module, frozenset(kind.__name__ for kind in DECLARED)) for module in SEMANTICS),
    (cases, frozenset({*(kind.__name__ for kind in DECLARED), "fail"})),
)


@cache
def _sites() -> tuple[Site, ...]:
    return tuple(site for module, makers in _MAKERS for site in _sites_of(module, makers))


def _sites_of(module: ModuleType, makers: frozenset[str]) -> Iterator[Site]:
    for function in ast.walk(ast.parse(inspect.getsource(module))):
        if not isinstance(function, ast.FunctionDef) or function.name in ("fail", *UNREACHED):
            continue
        for node in ast.walk(function):
            if isinstance(node, ast.Call) and _called(node) in makers:
                if module is not cases and _called(node) == "fail":
                    continue
                yield Site(module.__name__, node.lineno, node.end_lineno or node.lineno, function.name)


def _called(call: ast.Call) -> str:
    function = call.func
    return function.id if isinstance(function, ast.Name) else getattr(function, "attr", "")


@cache
def _reached() -> frozenset[Site]:
    """The sites from which the examples' diagnostics come."""
    for path in CASES:
        said(path)
    return frozenset(
        site for site in _sites() if any(site.module == m and site.line <= n <= site.last for m, n in _LINES)
    )
