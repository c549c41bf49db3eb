"""What whoever replays a recording gives for all of its cycles, because these do not have it: a number, and why."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from typing import TYPE_CHECKING

from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.scenarios.recording import Recording

CODES = {
    "E437": (
        "what is given cannot be, or is given without a reason",
        "`--given plan.grip=0.9 --because \"a dry track, and a tenth less\"` stands for an input that a recording does not have, in the unit that the spec declares, in every "
        "cycle. Runs show it with its reason. What a recording has itself cannot be given, and a record of a run has what the Supervisor had, and is run again with all rules that it had: of one that `--rule` names alone, its decisions say nothing.",
    ),
}  # fmt: skip


def choose_given(parser: argparse.ArgumentParser) -> None:
    """The options `--given` and `--because`."""
    parser.add_argument(
        "--given", action="append", default=[], metavar="NAME=NUMBER", help="an input that recordings lack, such as plan.grip=0.9"
    )  # fmt: skip
    parser.add_argument("--because", metavar="TEXT", default="", help="the reason for what is given")


def refuse_given(args: argparse.Namespace, record: str) -> None:
    """Raise E437 where something is given to the record of a run, which has what its Supervisor had."""
    if args.given or args.because:
        raise TrackmarshalError(
            "E437",
            "a record of a run has the inputs of that run",
            file=record,
            help="leave out `--given` and `--because`",
        )


def with_given(recording: Recording, given: list[str], because: str) -> Recording:
    """The recording with what it lacks; raises E437."""
    from trackmarshal.scenarios import inputs

    if not given:
        if because:
            raise _refused(
                recording, "there is a reason for nothing", "name the input: `--given plan.grip=0.9`"
            )
        return recording
    if not because.strip():
        raise _refused(recording, f"`{given[0]}` is given without a reason", 'say why: `--because "..."`')
    found: dict[str, float] = {}
    for text in given:
        name, _, number = text.partition("=")
        problem = inputs.not_to_be_given(name)
        if not problem and name in inputs.recorded(recording):
            problem = f"`{name}` is in the recording"
        if not problem and name in found:
            problem = f"`{name}` is given twice"
        try:
            found[name] = float(number)
        except ValueError:
            found[name] = math.nan
        if not problem and not math.isfinite(found[name]):
            problem = f"`{number}` is no finite number"
        if problem:
            raise _refused(recording, problem, "write `--given plan.grip=0.9`")
    reasons = {**recording.because, **dict.fromkeys(found, because)}
    return inputs.filled(replace(recording, given={**recording.given, **found}, because=reasons))


def _refused(recording: Recording, message: str, help_: str) -> TrackmarshalError:
    return TrackmarshalError("E437", message, file=recording.source, help=help_)
