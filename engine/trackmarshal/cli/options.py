"""Options that several verbs share."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import TYPE_CHECKING

from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.ir.spec import Spec
    from trackmarshal.runtime.cycle import Limits


def choose_rules(parser: argparse.ArgumentParser, to: str) -> None:
    """`--rule` and `--with`: what of a spec, and with which vehicle and track; `to` says what becomes of the rules."""
    parser.add_argument(
        "--rule", action="append", metavar="R", help=f"a rule to {to} (repeatable; default: all)"
    )
    configure_with(parser)


def configure_with(parser: argparse.ArgumentParser) -> None:
    """`--with`: configuration modules, in `settings`."""
    parser.add_argument(
        "--with",
        dest="settings",
        action="append",
        default=[],
        metavar="FILE",
        help="a configuration module (a vehicle, a track)",
    )


def choose_backend(parser: argparse.ArgumentParser, default: str | None, what: str) -> None:
    """Let an evaluator be named."""
    from trackmarshal.evaluation import BACKENDS

    parser.add_argument("--backend", choices=BACKENDS, default=default, help=what)


def choose_limits(parser: argparse.ArgumentParser) -> None:
    """`--limit`: what the Supervisor holds cycles and itself to."""
    parser.add_argument(
        "--limit", action="append", default=[], metavar="NAME=VALUE",
        help="a limit of the Supervisor or a capacity (`budget=0.03`, `samples=128`; repeatable; default: the project's, those of docs/supervisor.md)",
    )  # fmt: skip


def limits_of(args: argparse.Namespace, spec: Spec) -> Limits:
    """The limits that a spec declares, with those that were chosen; raises E481 for a name or a value that is none, E403 as `limits_with`."""
    from trackmarshal.diagnostics.base import close_matches
    from trackmarshal.runtime.cycle import Limits
    from trackmarshal.supervision import limits_with

    defaults = asdict(Limits())
    chosen: dict[str, float] = {}
    for given in args.limit:
        name, _, text = given.partition("=")
        if name not in defaults:
            raise TrackmarshalError(
                "E481",
                f"there is no limit `{name}`",
                help=close_matches(name, defaults) or f"one of {', '.join(defaults)}",
            )
        if name in chosen:
            raise TrackmarshalError(
                "E481", f"the limit `{name}` is given twice", help="leave out one of both"
            )
        try:
            chosen[name] = int(text) if isinstance(defaults[name], int) else float(text)
        except ValueError as error:
            raise TrackmarshalError(
                "E481",
                f"`{text}` is no number for the limit `{name}`",
                help=f"such as {name}={defaults[name]}",
            ) from error
    return limits_with(spec, chosen)
