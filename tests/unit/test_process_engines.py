"""A process that another engine built of the same spec is another program; what is written otherwise and compiled alike is none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from trackmarshal.backends.c import rendering
from trackmarshal.backends.c.process import emit
from trackmarshal.backends.c.source import Source, generate
from trackmarshal.evaluation import loads
from trackmarshal.process.client import Client
from trackmarshal.process.messages import Layout, LinkError
from trackmarshal.process.serving import emitted
from trackmarshal.process.supervisor import RemoteSupervisor
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.frame import NO_SETTINGS

#: With a rule of which `compile` writes a monitor beside the process.
TEXT = """
module m
use supervisor.interface
param most : m/s = 90 m/s
constrain most >= 1 m/s because "it is to drive"
rule fast along plan as p
  require always p.v <= most
"""
SPEC = loads(TEXT)
RULES = [rule for rule in SPEC.rules if rule.formula is not None]
LIMITS = Limits.of(SPEC)


class Silent:
    """A channel with nobody at its other end."""

    def send(self, box: str, message: bytearray) -> bool:
        return True

    def receive(self, seconds: float) -> bytes | None:
        return None

    def close(self) -> None: ...


def source(**more: Any) -> Source:
    return generate(SPEC, RULES, doored=True, **more)


def layout(made: Source) -> Layout:
    return Layout(emitted(made, LIMITS, NO_SETTINGS).description)


def spoken_for(theirs: Layout) -> None:
    """Raise LinkError where a process of these messages is refused."""
    RemoteSupervisor(SPEC, RULES, Client(theirs, Silent()), LIMITS).close()


def test_a_process_whose_rules_an_older_engine_wrote_is_refused() -> None:
    """Their formulas are the same, so that the fingerprint of the spec is; what comes of them need not be."""
    made = source()
    theirs = layout(replace(made, source=made.source + "static int tm_older(void) { return 1; }\n"))
    with pytest.raises(LinkError, match="built by another version of trackmarshal"):
        spoken_for(theirs)


def test_so_is_one_that_takes_cycles_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:

    def older(name: str, context: Mapping[str, Any], folder: Path) -> str:
        return rendering.render(name, context, folder) + (
            "static int older;\n" if name == "desk.c.j2" else ""
        )

    with monkeypatch.context() as patched:
        patched.setattr(emit, "render", older)
        theirs = layout(source())
    with pytest.raises(LinkError, match="built by another version of trackmarshal"):
        spoken_for(theirs)


def test_so_is_one_that_does_not_say_which_engine_built_it() -> None:
    said = {name: value for name, value in layout(source()).said.items() if name != "engine"}
    with pytest.raises(LinkError, match="built by another version of trackmarshal"):
        spoken_for(Layout({**said, "layout": "0123456789abcdef"}))


def test_words_in_comments_and_names_of_files_do_not_count() -> None:
    made = source(name="guard")
    spoken_for(layout(replace(made, source=f"/* In other words. */{made.source}")))


def test_nor_does_where_the_spec_stands() -> None:
    """Nor where in it a constraint does, which C says when the constraint is broken."""
    moved = loads(TEXT.replace("constrain", "\n-- So that it drives at all.\nconstrain"))
    spoken_for(layout(generate(moved, list(moved.rules), doored=True)))


def test_a_process_that_compile_wrote_is_the_one_that_serve_starts() -> None:
    made = source(online=True)
    assert made.monitors
    assert layout(made).fingerprint == layout(source()).fingerprint
    spoken_for(layout(made))
