"""`trackmarshal VERB`: finds the verb's module, runs it, and turns outcomes into exit statuses."""

from __future__ import annotations

import argparse
import atexit
import codecs
import gc
import importlib
import io
import os
import signal
import sys
from typing import Any, TextIO

from trackmarshal.errors import TrackmarshalError

#: Verbs and what they do; each is a module of this package with `configure(parser)` and `run(args) -> int`.
VERBS = {
    "init": "a new project that is green from the start",
    "new": "the next rule, requirement, rulebook or scenario of a project",
    "watch": "check and test on every save",
    "check": "parse, resolve names, check dimensions and links",
    "fmt": "the one layout",
    "test": "run the tests written in specs, with rule coverage",
    "eval": "evaluate rules on given data",
    "choose": "which of several candidates a rulebook prefers, and why",
    "replay": "run the Supervisor's rules over a recording",
    "check-planner": "what does not fit the contract in a planner's cycles, with a mapping",
    "compile": "generated C99 with its header and a report",
    "serve": "run a Supervisor as a process of its own",
    "explain": "what an error code means; why a rule said what it said",
    "show": "one rule as spec, formula, in words and as C; where its limits are",
    "diff": "what an edit of specs changes on recordings",
    "trace": "traceability matrix and coverage",
    "gsn": "the argument as goal structure: pictures, gsn2x, JSON, text",
    "case": "the safety case as a document, HTML and PDF",
    "assess": "all of it: check, test, replay, evidence, matrix, report",
    "scenario": "generate a recording from its declaration",
    "import": "a vehicle's log as a recording, with what the rules say of it; requirements from another tool",
    "export": "requirements for another tool",
    "bench": "the benchmarks",
}
#: Formats that are JSON.
JSON = ("json", "jsonl", "sarif")
OK, FINDINGS, UNUSABLE, INTERNAL = 0, 1, 2, 3

# What there is at the end of a process is gone with its memory: unless it is set aside, Python first goes through all of it for garbage.
atexit.register(gc.freeze)


def main(argv: list[str] | None = None) -> int:
    """Run the command; 0 all well, 1 findings, 2 unusable input or arguments, 3 internal error.

    Findings are what somebody has to look at: an error in a spec, a declared expectation that is not met (a test, a ground truth, a
    recorded decision, a demand of the V-model) and, where nothing is expected of it, something unsafe. With `--exit-zero` they give 0.
    """
    arguments = sys.argv[1:] if argv is None else argv
    # What numpy has for large matrices would wait for work in threads of its own, a tenth of a second of CPU at each start.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if sys.stderr is None:  # closed: `print` would take standard output for it, which may be a report
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 (to the end)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # text that the terminal's encoding lacks is escaped
            stream.reconfigure(errors="backslashreplace")
    try:
        status = _guarded(arguments)
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
        return status
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of our output went away before it was told how this ends: nobody may take that for a pass.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                os.dup2(nowhere, stream.fileno())
        return 128 + signal.SIGPIPE if hasattr(signal, "SIGPIPE") else FINDINGS


def _guarded(arguments: list[str]) -> int:
    """Run the verb; everything that is reported to the user becomes text and an exit status."""
    try:
        return _dispatch(arguments)
    except SystemExit as stop:
        return UNUSABLE if stop.code not in (0, None) else OK
    except BrokenPipeError:
        raise
    except OSError as error:
        from trackmarshal.cli.output import print_problem

        help_ = "check the path, its permissions and the space left"
        print_problem(TrackmarshalError("E411", error.strerror or str(error), file=_path(error), help=help_))
        return UNUSABLE
    except MemoryError:
        print("error[E411]: not enough memory for this input", file=sys.stderr)
        return UNUSABLE
    except TrackmarshalError as error:
        from trackmarshal.cli.output import print_problem

        print_problem(error)
        return UNUSABLE
    except RecursionError:
        print("error[E104]: the input is nested too deeply", file=sys.stderr)
        return UNUSABLE
    except Exception as error:
        if os.environ.get("TRACKMARSHAL_DEBUG"):
            raise
        from trackmarshal.cli.output import say

        say(f"internal error: {type(error).__name__}: {error}", file=sys.stderr)
        print(
            "  This is a defect of trackmarshal. Set TRACKMARSHAL_DEBUG=1 for the details and report it.",
            file=sys.stderr,
        )
        return INTERNAL


def _path(error: OSError) -> str | None:
    """Which file an error of the system is about."""
    return (
        None
        if error.filename is None
        else os.fsdecode(error.filename)
        if isinstance(error.filename, (str, bytes))
        else str(error.filename)
    )


class _Once(argparse.Action):
    """An option that has one value. Of two that differ, argparse takes the last one: with `--data` twice, nobody evaluates the first file."""

    _given: object = None

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option_string: str | None = None
    ) -> None:  # fmt: skip
        if option_string is not None and self._given not in (None, values):
            raise argparse.ArgumentError(self, f"given twice, as {self._given} and as {values}")
        self._given = values
        setattr(namespace, self.dest, values)


class _Parser(argparse.ArgumentParser):
    """A parser, also of the verbs of a verb, that takes an option for one value only once."""

    def __init__(self, **how: Any) -> None:
        super().__init__(**how)
        for name in (None, "store"):
            self.register("action", name, _Once)


def _dispatch(arguments: list[str]) -> int:
    before, verb, after = _at_the_verb(arguments)
    if verb not in VERBS:
        return _overview(verb, before)
    module = importlib.import_module(f"trackmarshal.cli.{_module(verb)}")
    parser = _Parser(
        prog=f"trackmarshal {verb}",
        description=module.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    _common(parser)
    module.configure(parser)
    args, left = parser.parse_known_args([*before, *after])
    if (
        left
    ):  # of a verb whose argument is something else, people add the spec as they do with `check` and `test`
        spec = next((word for word in left if word.endswith(".spec")), "")
        help_ = f"; a spec is named by --spec {spec}" if spec and "[--spec " in parser.format_usage() else ""
        parser.error(f"unrecognized arguments: {' '.join(left)}{help_}")
    if getattr(args, "format", None) in JSON:
        _in_json(sys.stdout)
    status: int = module.run(args)
    return OK if status == FINDINGS and args.exit_zero else status


def _in_json(stream: TextIO | None) -> None:
    """Have a stream write JSON, which is UTF-8 wherever it is read: in another encoding, all but ASCII as JSON escapes it."""
    if isinstance(stream, io.TextIOWrapper) and codecs.lookup(stream.encoding).name != "utf-8":
        codecs.register_error("json", _escaped)
        stream.reconfigure(encoding="ascii", errors="json")


def _escaped(error: UnicodeError) -> tuple[str, int]:
    import json

    if not isinstance(error, UnicodeEncodeError):
        raise error
    return json.dumps(error.object[error.start : error.end])[1:-1], error.end


def _common(parser: argparse.ArgumentParser) -> None:
    """The options of every verb, which may stand before it too."""
    parser.add_argument(
        "--project", metavar="DIR", help="the project to work on (default: the one this folder is in)"
    )
    parser.add_argument("--quiet", action="store_true", help="no progress, only results")
    parser.add_argument(
        "--exit-zero", action="store_true", help="exit 0 where there are findings; not for unusable input"
    )


def _at_the_verb(arguments: list[str]) -> tuple[list[str], str | None, list[str]]:
    """What stands before the verb, the verb, and what follows it; an option's value is no verb."""
    place = 0
    while place < len(arguments) and arguments[place].startswith("-"):
        # argparse takes `--proj` for `--project` too
        place += 2 if arguments[place].startswith("--p") and "=" not in arguments[place] else 1
    if place >= len(arguments):
        return arguments, None, []
    return arguments[:place], arguments[place], arguments[place + 1 :]


def _module(verb: str) -> str:
    named = {
        "eval": "evaluate",
        "test": "run_tests",
        "import": "importing",
        "export": "exporting",
        "check-planner": "check_planner",
    }
    return named.get(verb, verb)


def _overview(verb: str | None, arguments: list[str]) -> int:
    if "--version" in arguments:
        from trackmarshal import __version__

        print(f"trackmarshal {__version__}")
        return OK
    lines = ["usage: trackmarshal VERB ...", ""]
    lines += [f"  {name:<13} {text}" for name, text in VERBS.items()]
    lines += ["", "`trackmarshal VERB --help` says more."]
    if verb is None:
        print("\n".join(lines))
        return OK if "--help" in arguments or "-h" in arguments else UNUSABLE
    from trackmarshal.diagnostics.base import close_matches

    hint = close_matches(verb, VERBS)
    from trackmarshal.cli.output import say

    say(f"error: unknown verb `{verb}`" + (f"; {hint}" if hint else ""), file=sys.stderr)
    print("\n".join(lines), file=sys.stderr)
    return UNUSABLE


if __name__ == "__main__":
    sys.exit(main())
