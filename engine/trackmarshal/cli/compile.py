"""Compile rules to freestanding C: source, header, build file, an example, and a report for whoever integrates it.

trackmarshal compile specs/supervisor --target c --out build/supervisor
"""

from __future__ import annotations

import argparse
from pathlib import Path

from trackmarshal.cli.options import choose_rules
from trackmarshal.cli.output import say
from trackmarshal.cli.project import optional_project
from trackmarshal.errors import TrackmarshalError


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("spec", metavar="SPEC", help="a .spec file, or a folder of them")
    parser.add_argument("--target", choices=("c",), default="c", help="the language to compile to")
    parser.add_argument("--out", required=True, metavar="DIR", help="where the files go; made if need be")
    choose_rules(parser, "compile")
    parser.add_argument(
        "--name", default="supervisor", metavar="NAME", help="the name of the C files (default: supervisor)"
    )


def run(args: argparse.Namespace) -> int:
    from trackmarshal.backends.c.door import has_door
    from trackmarshal.backends.c.example import cmake, main_c
    from trackmarshal.backends.c.names import plain
    from trackmarshal.backends.c.report import report
    from trackmarshal.backends.c.source import generate
    from trackmarshal.evaluation import Evaluator, broken_constraints, load

    if not plain(args.name) or args.name in ("main", "glue"):
        raise TrackmarshalError(
            "E474",
            f"`{args.name}` is no name for a C file",
            help="letters, digits and _, no digit first; not `main`",
        )
    spec = load([Path(args.spec)], [Path(path) for path in args.settings], optional_project(args))
    broken = broken_constraints(spec)
    if broken:
        raise TrackmarshalError(
            "E403", broken[0], help="change the parameters in the spec or the configuration"
        )
    rules = Evaluator(spec, args.rule, "reference").rules
    source = generate(spec, rules, args.name, online=True, doored=has_door(spec))
    texts = {
        f"{args.name}.h": source.header, f"{args.name}.c": source.source, "CMakeLists.txt": cmake(source),
        "main.c": main_c(source), "report.md": report(source),
    }  # fmt: skip
    folder = Path(args.out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise TrackmarshalError(
            "E474", f"cannot write to {folder}: {error.strerror}", help="choose another folder with --out"
        ) from error
    if not args.quiet:
        say(
            f"{len(source.rules)} rules, {len(source.source.splitlines())} lines of C in {folder}: {', '.join(texts)}"
        )
    return 0
