"""Which changes were accepted: an acceptance is a text, in the words of the version of the program that it was given to."""

from __future__ import annotations

import re
from collections.abc import Iterable

from trackmarshal.trace.baseline.change import SAYING, Change
from trackmarshal.trace.baseline.weakening import is_weaker

_QUOTED = re.compile("`([^`]*)`")
#: What a field that has an order was changed to: an ASIL, a count, a day.
_LAST = re.compile(r" to ([A-D]|QM|[0-9]+|[0-9]{4}-[0-9]{2}-[0-9]{2})(?: \(|$)")


def accepted(change: Change, texts: Iterable[str]) -> bool:
    """Whether texts of acceptances say what a change says. Several may have led to it, one after the other, in the words of earlier versions of the program."""
    own = [text for text in texts if text.startswith((f"{change.key}: ", f"{change.key} is "))]
    if any(_is(text.removeprefix(change.key), " is gone") for text in own):
        return bool(change.field) or bool(change.before)  # it may be there again
    if not change.field:
        return any(_is(text.removeprefix(change.key), " is new") for text in own)
    rests = [text.removeprefix(f"{change.key}: ") for text in own]
    names = "|".join(re.escape(name) for name in {change.field, change.what} - {""})
    if change.listed:
        parts = [rest for rest in rests if re.match(f"in its (?:{names}) ", rest)]
        left = {
            name for part in parts if " left" in part for name in _QUOTED.findall(part.partition(" left")[0])
        }
        came = {name for part in parts for name in _QUOTED.findall(part.rpartition(" left")[2])}
        fewer = {
            one for one in _QUOTED.findall(change.before) if is_weaker(change.kind, change.field, [one], [])
        }
        more = {
            one
            for one in _QUOTED.findall(change.after)
            if change.told or is_weaker(change.kind, change.field, [], [one])
        }
        return bool(parts) and fewer <= left and more <= came
    last = change.after or "nothing"
    for rest in rests:
        said = re.match(f"its (?:{names}) changed", rest)
        if said is None and change.field in SAYING:
            said = re.match("it says something else|it (?=was )", rest)
        if said is None:
            continue
        if not rest[said.end() :].startswith((" from ", "was ")):
            return True  # of a text, of which there is no more to say
        if _ends(rest, f" to {last}") or _ends(rest, f" is {last}"):
            return True
        # Something that was accepted as even less may be more again.
        ordered = [value for value in _LAST.findall(rest) if value.isdigit() == last.isdigit()]
        if any(not is_weaker(change.kind, change.field, value, change.after) for value in ordered):
            return True
    return False


def _is(text: str, said: str) -> bool:
    """Whether a text is this one, whatever was told beside it."""
    return text == said or text.startswith(f"{said} (")


def _ends(text: str, end: str) -> bool:
    return text.endswith(end) or f"{end} (" in text
