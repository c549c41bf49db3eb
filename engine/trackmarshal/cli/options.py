"""Options that several verbs share."""

from __future__ import annotations

import argparse


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
