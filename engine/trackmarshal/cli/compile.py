"""Compile rules to freestanding C: source, header, build file, an example, and a report for whoever integrates it.

trackmarshal compile specs/supervisor --target c --out build/supervisor

With --cycles, a recording or the record of a run is written as a file that the example runs from. With --process, the Supervisor is also
written as a process of its own, with clients for it in C and in Python (docs/process.md).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli.options import choose_limits, choose_rules, limits_of
from trackmarshal.cli.output import say
from trackmarshal.cli.project import find_project, optional_project
from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import other_there

if TYPE_CHECKING:
    from trackmarshal.backends.c.source import Source
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.runtime.record.reading import Run
    from trackmarshal.scenarios.recording import Recording

#: How every header that this writes begins.
_GENERATED = b"/* Generated from a spec by trackmarshal."


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "spec",
        nargs="?",
        metavar="SPEC",
        help="a .spec file, or a folder of them (default: the one that the project replays with)",
    )
    parser.add_argument("--target", choices=("c",), default="c", help="the language to compile to")
    parser.add_argument("--out", required=True, metavar="DIR", help="where the files go; made if need be")
    choose_rules(parser, "compile")
    parser.add_argument(
        "--name", default="supervisor", metavar="NAME", help="the name of the C files (default: supervisor)"
    )
    parser.add_argument(
        "--cycles", action="append", default=[], metavar="RECORDING",
        help="write the cycles of a recording, or of a run's record, for the example; its vehicle and track are compiled in",
    )  # fmt: skip
    parser.add_argument(
        "--process", action="store_true", help="also as a process of its own, with clients; --limit is for it"
    )
    choose_limits(parser)


def run(args: argparse.Namespace) -> int:
    from trackmarshal.backends.c.example import example
    from trackmarshal.backends.c.names import plain
    from trackmarshal.backends.c.report import context_bytes, report
    from trackmarshal.backends.c.source import generate
    from trackmarshal.backends.c.supervised.contract import unfit
    from trackmarshal.cli.evaluate import declared_within
    from trackmarshal.cli.replay import default_spec
    from trackmarshal.evaluation import Evaluator, broken_constraints, load
    from trackmarshal.runtime.contract import PLAN

    if not plain(args.name) or args.name.casefold() in _TAKEN:
        raise TrackmarshalError(
            "E474",
            f"`{args.name}` is no name for a C file",
            help="letters, digits and _, no digit first; not `main` or `cycles`, nor another file that is written, a header of the system, or a target of CMake's",
        )
    project = optional_project(args)
    spec_path = Path(args.spec) if args.spec is not None else default_spec(find_project(args))
    chosen = [Path(path) for path in args.settings]
    given = [_read(path, spec_path, chosen) for path in args.cycles]
    settings = [*_used(given, project), *chosen]
    spec = load([spec_path], settings, project)
    broken = broken_constraints(spec)
    if broken:
        raise TrackmarshalError(
            "E403", broken[0], help="change the parameters in the spec or the configuration"
        )
    evaluator = Evaluator(spec, args.rule, "reference", lambda: declared_within(spec, project))
    why = unfit(spec)
    source = generate(spec, evaluator.rules, args.name, online=True, doored=not why)
    if why and given:
        problem = f"no Supervisor can be made of this spec, so it takes no cycles: {why}"
        raise TrackmarshalError("E475", problem, help="see E482, or leave out --cycles")
    if why and args.process:
        problem = f"no Supervisor can be made of this spec, so it cannot be a process: {why}"
        raise TrackmarshalError("E477", problem, help="see E482, or leave out --process")
    if why and PLAN in spec.signals:  # whoever declares one may count on `tm_step`
        print(f"note: without a Supervisor, as {why}: rules alone, by tm_check (E482)", file=sys.stderr)
    process: dict[str, str] = {}
    capacities = None
    if args.process:
        process, capacities = _process(source, args)
    elif args.limit:
        raise TrackmarshalError(
            "E481", "limits are compiled in with --process only", help="call tm_configure, or add --process"
        )
    texts = {
        f"{args.name}.h": source.header, f"{args.name}.c": source.source, **example(source, capacities), "report.md": report(source),
        **process,
    }  # fmt: skip
    texts |= {
        f"{name}.cycles": "".join(f"{line}\n" for line in _cycles(one, source, evaluator))
        for name, one in given
    }
    folder = Path(args.out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _refuse_others(folder, texts)
        for name, text in texts.items():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise TrackmarshalError(
            "E474", f"cannot write to {folder}: {error.strerror}", help="choose another folder with --out"
        ) from error
    size = context_bytes(source)
    if size is not None and size[0] > _ROOM:
        print(
            f"note: the context takes {size[0] / 2**30:,.1f} GiB with the default capacities, and is refused where Python loads it (E473): "
            "give the sets a smaller `capacity`, or windows over the run less time",
            file=sys.stderr,
        )
    if not args.quiet:
        count = len(source.rules)
        say(
            f"{count} rule{'' if count == 1 else 's'}, {len(source.source.splitlines())} lines of C in {folder}: {', '.join(texts)}"
        )
    return 0


#: As many bytes of a context as a whole Supervisor may have in Python: 1 GiB.
_ROOM = 2**30
#: Names of other files that are written; of headers of the system, which would be looked for beside them; and of what CMake, or a linker, calls so.
_WRITTEN = "main cycles glue messages mailbox desk process client client_example executing"
_HEADERS = (
    "assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdarg stdbool stddef stdint stdio stdlib string"
    " tgmath time wchar wctype alloca endian fcntl features poll sched unistd"
)
_TARGETS = "all all_build clean edit_cache help install m preinstall rebuild_cache zero_check"
_TAKEN = frozenset(" ".join([_WRITTEN, _HEADERS, _TARGETS]).split(" "))


def _refuse_others(folder: Path, names: Iterable[str]) -> None:
    """Raise E474 where a file is in the way that somebody else wrote: no header is beside it of which one can see that it was generated."""
    there = sorted(name for name in names if (folder / name).exists())
    if there and all(other_there(header, _GENERATED) for header in folder.glob("*.h")):
        raise TrackmarshalError(
            "E474", f"{there[0]} is there already, and nothing in {folder} was generated", file=str(folder / there[0]),
            help="nothing was written; choose another folder with --out",
        )  # fmt: skip


def _process(source: Source, args: argparse.Namespace) -> tuple[dict[str, str], dict[str, int]]:
    """The files of the Supervisor as a process, Python's among them, and its capacities by macro."""
    from dataclasses import asdict

    from trackmarshal.backends.c.process.emit import Emitted
    from trackmarshal.process.copies import link

    made = Emitted(source, asdict(limits_of(args, source.plan.spec)))
    return made.files | link(), made.sizes


def _read(path: str, spec_path: Path, chosen: list[Path]) -> tuple[str, Recording | Run]:
    """A recording, without the values that are chosen, or the record of a run; and the name of its file of cycles."""
    from trackmarshal.cli.record import is_record
    from trackmarshal.cli.replay import overruled
    from trackmarshal.runtime.record.reading import read
    from trackmarshal.scenarios import content, load

    if is_record(path):
        return Path(path).stem, read(content.read_record(path), path)
    return Path(path).name.partition(".")[0], overruled(load(path), spec_path, chosen)


def _used(given: list[tuple[str, Recording | Run]], project: Path | None) -> list[Path]:
    """The configuration modules that recordings name; raises E475 where they name different ones, or two have one name."""
    from trackmarshal.cli.replay import configuration
    from trackmarshal.scenarios.recording import Recording

    names = [name for name, _ in given]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise TrackmarshalError(
            "E475", f"two recordings have the name `{twice}`", help="compile once for each of them"
        )
    named = {name: configuration(one, project) for name, one in given if isinstance(one, Recording)}
    first, *others = named or [""]
    for name in others:
        if named[name] != named[first]:
            raise TrackmarshalError(
                "E475",
                f"`{first}` and `{name}` are not of the same vehicle and track",
                help="compile once for each of them",
            )
    return named.get(first, [])


def _cycles(one: Recording | Run, source: Source, evaluator: Evaluator) -> Iterator[str]:
    """The lines of a file of cycles; raises E403 where the recording's parameters break a constraint."""
    from trackmarshal.scenarios import cycle_file
    from trackmarshal.scenarios.fields import check_fit, further_names
    from trackmarshal.scenarios.overrides import known_params, known_tables
    from trackmarshal.scenarios.recording import Recording
    from trackmarshal.supervision import rulebox

    if isinstance(one, Recording):
        check_fit(one, evaluator)
        tables, _ = known_tables(one, evaluator.spec)
        settings = rulebox(evaluator, known_params(one, evaluator.spec), tables).settings
        return cycle_file.of_recording(one, source, settings, further_names(one, evaluator))
    other = one.other_spec(evaluator.spec)
    if other:
        print(f"note: {one.source}: {other}", file=sys.stderr)
    if one.went_on:
        print(f"note: {one.source}: {one.went_on}, which a file of cycles cannot say", file=sys.stderr)
    box = rulebox(evaluator, one.identity.get("params"), one.identity.get("tables"))
    return cycle_file.of_run(one, source, box.settings)
