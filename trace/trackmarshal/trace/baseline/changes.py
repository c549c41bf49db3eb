"""What is different between a baseline and what there is now, and whether less is demanded or shown than before."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from trackmarshal.trace.baseline.change import Change
from trackmarshal.trace.baseline.content import (
    ANSWERS,
    HEADING,
    PLAIN_ARGUMENT,
    RAN,
    UNKNOWN,
    UNREVIEWED,
    WORKED_OUT,
    Content,
    Entry,
    Value,
)
from trackmarshal.trace.baseline.renaming import renamings
from trackmarshal.trace.baseline.weakening import CITING, claimed, elements, excuses, is_weaker, text

#: Fields that say nothing by themselves: what others come to, or how something is shown.
_SILENT = {
    ("param", "shown"),
    ("table", "shown"),
    ("place", "shown"),
    ("signal", "shown"),
    ("rulebook", "shown"),
    ("limit", "shown"),
    ("rule", "reads"),
    ("assumption", "reads"),
    ("external-tests", "tests"),
}

#: What entries of demands of the gate begin with.
_GATE = "gate "
#: And what they end with that ask for less.
_PARTIAL = ", partial"
#: The field that says what faults are put into.
_PUT_INTO = "replayed with"
#: Hashes of files. The gate tells what is not there where it is missed.
_FILES = ("recording", "kept run", "sha256", "evidence sha256")
#: What earlier baselines lack that are as good as ever: it is held from the next acceptance on, and nothing is said until then.
_NOT_YET = {
    ("method", "title"), ("work", "title"), ("tool", "title"), ("scenario", "rules"), ("issue", "leads_to"), ("defeater", "evidence"),
    ("external-tests", RAN), ("evidence", ANSWERS), ("section", HEADING), ("subsystem", "role"), ("stage", "shows"), *CITING,
}  # fmt: skip


#: How fields begin that say why something is adopted, or a method not used; that it is so, or not any more, is told where it counts.
_REASONS = ("adopted", "reason against ")


#: Says of entries of which rules come to something else now (`rule x`, `param y`) whether that is weaker or stronger: the engine can tell, not this
#: room. Given are the baseline's content and the names of the entries.
Tell: TypeAlias = Callable[[Content, Sequence[str]], Mapping[str, str]]
#: Kinds of entries that it is asked about, and the fields that say what they come to.
_COME_TO = {
    "rule": ("meaning",), "assumption": ("meaning",), "param": ("says",), "table": ("says",), "place": ("says",), "signal": ("says",),
}  # fmt: skip


def changes(
    before: Content, now: Content, tell: Tell | None = None, *, missed: bool = True
) -> Iterator[Change]:
    """All differences, in the order of the entries. What is gone takes with it what it is made of: the tests of a rule that is gone are not told, nor the issues of an interface, nor what is in a report.

    tell: asked once, and only where rules, or what they read, are other ones. missed: files that are gone, or empty, are told where they are missed,
    as the gate does; otherwise they are told here.
    """
    found = list(_changes(before, now, missed))
    keys = [one.key for one in found if one.field in _COME_TO.get(one.kind, ())]
    told = tell(before, keys) if keys and tell is not None else {}
    for one in found:
        of_it = one.field in _COME_TO.get(one.kind, ())
        yield replace(one, told=told.get(one.key, "")) if told and of_it else one


def _changes(before: Content, now: Content, missed: bool) -> Iterator[Change]:
    before = _raised(before, now)
    before, now = _put_into(before, now), _put_into(now, before)
    before, now = ({k: e for k, e in held.items() if e != PLAIN_ARGUMENT} for held in (before, now))
    renamed = renamings(before, now)
    listed = any(key.startswith(_GATE) for key in now)
    if listed and not any(key.startswith(_GATE) for key in before):
        yield from _narrowed(before, now)
    for key in sorted((before.keys() | now.keys()) - renamed):
        kind, _, name = key.partition(" ")
        if kind == "subsystem" and missed and not (key in before and key in now):
            continue  # each of its pairs is an interface, or has a reason, and is told; and earlier baselines hold none
        if key not in now:
            rule = name.partition(": ")[0]
            if kind == "test" and not {f"rule {rule}", f"assumption {rule}"} & now.keys():
                continue
            if kind == "issue" and f"interface {name.rpartition('.')[0]}" not in now:
                continue
            joined = {f"interface {one}" for one in (name, _turned(name))} & now.keys()
            if kind == "infeasible" and joined:
                if any(_otherwise(before[key], one, now) for one in joined):
                    yield Change(kind, name, "reason", "", "", True)
                continue
            if kind == "campaign":  # that is not named any more, or of which nothing is known
                continue
            if kind == "external-tests" and f"report {name.partition(' in ')[2]}" not in now:
                continue
            all_demanded = kind == "gate" and not listed
            yield Change(kind, name, "", "there", "", not (all_demanded or kind in ("waiver", UNREVIEWED)))
        elif key not in before:
            why = excuses(kind, now[key], bool(now[key].get("methods")))
            weaker = bool(why) or kind in ("waiver", "link-schema", "argument", UNREVIEWED)
            yield Change(kind, name, "", "", "there", weaker, told=why, unasked=bool(why))
        else:
            for one in _of(kind, name, before[key], now[key], missed):
                if (kind, one.field) == ("scenario", "rules"):
                    # A rule that is gone is told once, and one that came is a rule more wherever it is.
                    left = set(before[key]["rules"]) - set(now[key].get("rules", ()))
                    if not any(f"rule {rule}" in now for rule in left):
                        continue
                if (kind, one.field) == ("external-tests", RAN) and not _more_skipped(before[key], now[key]):
                    continue
                yield one


def _more_skipped(before: Entry, now: Entry) -> bool:
    """Whether more tests of another runner were skipped than are told to be gone."""
    return _fell(before, now, RAN) > max(0, _fell(before, now, "number"))


def _fell(before: Entry, now: Entry, field: str) -> int:
    return int(text(before.get(field, "")) or 0) - int(text(now.get(field, "")) or 0)


def _raised(before: Content, now: Content) -> Content:
    """What was accepted, but for requirements of which a cell need only be covered in part and is now to be covered: that is more."""
    found = dict(before)
    for key, entry in before.items():
        if key.startswith(_GATE) and key.endswith(_PARTIAL) and "requirements" in entry:
            whole = now.get(f"{key.removesuffix(_PARTIAL)}, covered", {}).get("requirements", ())
            kept = set(now.get(key, {}).get("requirements", ()))
            left = [
                one for one in elements(entry["requirements"]) if one in kept or not {one, "*"} & {*whole}
            ]
            if left:
                found[key] = {**entry, "requirements": left}
            else:
                del found[key]
    return found


def _put_into(content: Content, other: Content) -> Content:
    """With the contents of what faults are put into where the other one says them: where the recording is a scenario of the project, they stand with that."""
    found = dict(content)
    for key, entry in content.items():
        said = elements(entry.get(_PUT_INTO, ""))
        if key.startswith("campaign ") and _contents(other.get(key, {})) and not _contents(entry):
            path = next((one.removeprefix("recording ") for one in said if one.startswith("recording ")), "")
            if held := content.get(f"scenario {path}", {}).get("recording"):
                found[key] = {**entry, _PUT_INTO: sorted([*said, f"contents {held}"])}
    return found


def _contents(campaign: Entry) -> bool:
    return any(one.startswith("contents ") for one in elements(campaign.get(_PUT_INTO, "")))


def _narrowed(before: Content, now: Content) -> Iterator[Change]:
    """That a gate is written down where there was none: without one every cell is demanded, and what it leaves out is not any more."""
    stages = [key.partition(" ")[2] for key in before if key.startswith("stage ") and key in now]
    less = [
        stage
        for stage in stages
        if "*" not in now.get(f"{_GATE}{stage}, covered", {}).get("requirements", ())
    ]
    if less:
        yield Change("gate", "", "says", "every cell", f"less than that at {', '.join(less)}", True)


def _otherwise(pair: Entry, interface: str, now: Content) -> bool:
    """Whether an interface that came in place of a reason is not analysed either, for another reason."""
    analysed = any(key.startswith(f"issue {interface.partition(' ')[2]}.") for key in now)
    return not analysed and now[interface].get("rationale", "") != pair.get(
        "reason", now[interface].get("rationale", "")
    )


def _turned(pair: str) -> str:
    """The other name of a pair of subsystems."""
    one, _, other = pair.partition("-")
    return f"{other}-{one}"


def _of(kind: str, name: str, before: Entry, now: Entry, missed: bool) -> Iterator[Change]:
    for field in sorted(before.keys() | now.keys()):
        old, new = before.get(field, ""), now.get(field, "")
        if (kind, field) == ("evidence", "unnamed") and field not in before:
            # Earlier baselines do not hold it, and those of pages that name all have none: what came since is known by what the page was evidence of then.
            old = sorted({*elements(new)} & {*elements(before.get("requirements", ""))})
        if (kind, field) == ("evidence", ANSWERS):
            # What of it comes of a requirement or a method more, or less, is told there.
            old, new = (
                [one for one in elements(value) if _both_in(one, before, now)] for value in (old, new)
            )
        without = field in _FILES and not new
        worked = f"{field}{WORKED_OUT}"
        if (worked in before and worked in now) or (field.endswith(WORKED_OUT) and field not in before):
            continue  # what it comes to is compared, from the next acceptance on after which it is held
        field = field.removesuffix(WORKED_OUT)
        if old == new or (kind, field) in _SILENT or (without and missed):
            continue
        if field.startswith(_REASONS) and not (old and new):
            continue
        if (kind, field) in _NOT_YET and field not in before:
            continue
        if UNKNOWN in (old, new):  # of a revision, whose recordings are not read
            continue
        shown = ("", "")
        if kind in ("param", "table", "place", "signal", "rulebook", "limit") and field == "says":
            shown = (text(before.get("shown", "")), text(now.get("shown", "")))
            shown = ("", "") if shown[0] == shown[1] else shown
        elif isinstance(old, list) or isinstance(new, list):
            both = set(elements(old)) & set(elements(new))
            shown = (_quoted(set(elements(old)) - both), _quoted(set(elements(new)) - both))
        elif not _hash(old) and not _hash(new):
            shown = (text(old), text(new))
        listed = isinstance(old, list) or isinstance(new, list)
        why = claimed(kind, field, now) if set(elements(new)) - set(elements(old)) else ""
        weaker = bool(why) or is_weaker(kind, field, old, new)
        lacking = without or ((kind, field) == ("section", "contents") and not new)
        told = why or ("there is none any more" if lacking else "")
        if (kind, field) == ("test", "text") and before.get(field) == now.get(field):
            told = "what is written of it is the same, and what that stands for is not"
        yield Change(kind, name, field, *shown, weaker, listed, told, bool(why))


def _both_in(answer: str, before: Entry, now: Entry) -> bool:
    """Whether evidence was of the requirement, and answered the method, that are said to be answered, and does now."""
    requirement, _, method = answer.partition(": ")
    return all(
        requirement in one.get("requirements", ()) and method in one.get("methods", ())
        for one in (before, now)
    )


def _quoted(names: set[str]) -> str:
    return ", ".join(f"`{name}`" for name in sorted(names))


def _hash(value: Value) -> bool:
    return isinstance(value, str) and len(value) == 64 and set(value) <= set("0123456789abcdef")
