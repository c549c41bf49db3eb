"""What is different between a baseline and what there is now, and whether less is demanded or shown than before."""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from trackmarshal.trace.baseline.content import (
    ANSWERS,
    HEADING,
    PLAIN_ARGUMENT,
    RAN,
    UNKNOWN,
    UNMARKED,
    UNREVIEWED,
    WORKED_OUT,
    Content,
    Entry,
    Value,
    counted,
)
from trackmarshal.trace.shapes import put_off

ASILS = ("QM", "A", "B", "C", "D")

#: Fields of which an element less is a weakening, and one more is none.
_FEWER = {
    ("requirement", "derived_from"), ("requirement", "refines"), ("requirement", "verification"), ("requirement", "metrics"),
    ("requirement", "assumptions"), ("interface", "leads_to"), ("interface", "flows"), ("project", "specs"), ("project", "campaigns"), ("project", "sources"), ("project", "denials"), ("stage", "applies_to"),
    ("gate", "requirements"), ("scenario", "by"), ("scenario", "requirements"), ("scenario", "with"), ("evidence", "requirements"),
    ("rule", "satisfies"), ("assumption", "satisfies"), ("evidence", "methods"), ("report", "methods"), ("scenario", "rules"),
    ("issue", "leads_to"),
}  # fmt: skip
#: Fields of which an element more is a weakening: each is one more thing that is excused.
_MORE = {
    ("requirement", "not_verified_by"), ("waiver", "stages"), ("waiver", "requirements"), ("waiver", "codes"), ("waiver", "subjects"),
    ("evidence", "unnamed"), ("external-tests", UNMARKED),
}  # fmt: skip
#: Fields that let something off as long as they are there: that a stage asks only where there is anything, that a report need not be there.
_LENIENT = {("stage", "only if there is any"), ("report", "may be missing")}
#: What hazards are rated as: a letter with a number, of which more is worse.
_CLASSES = ("severity", "exposure", "controllability")
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
#: Why a report that may be missing is less, and methods that it names: nobody asks for other evidence then (T255).
_EXCUSES = "it may be missing, and other evidence is not asked for then"
#: Why methods that a document or a report is said to answer are: no link tells that it does.
_CLAIMS = "that it is evidence of this kind is for somebody to say"
#: And one requirement more that an analysis is said to be of: its document may say nothing of it.
_EXAMINES = "that it is an analysis of that, too, is for somebody to say"
_EXAMINED = ("analysis", "link examines")
#: And a recording that is said to come from a vehicle: a generated one with another name in its first line looks like one.
_RECORDED = "that it was recorded on a vehicle is for somebody to say"
#: And a page that is said to be evidence of what it does not name.
_UNNAMED = "that a page that does not name it is evidence of it is for somebody to say"
#: Fields that hold all that an entry says.
SAYING = ("meaning", "says", "text")
#: What other fields are called.
_FIELDS = {
    "sha256": "contents",
    "recording": "contents",
    "of versions": "reviewed versions",
    "evidence sha256": "evidence",
    "named": "files that it names",
    "unnamed": "requirements that its text does not name",
    RAN: "number of those that were not skipped",
}

#: Hashes of files. The gate tells what is not there where it is missed.
_FILES = ("recording", "kept run", "sha256", "evidence sha256")
#: What earlier baselines did not hold: that it is held from now on is no weakening.
_LATER = ("evidence sha256", "put in", "named", "replayed with", "closed loop", "title", "rationale")
#: Where something comes from.
_CITING = {("requirement", "source"), ("rule", "source"), ("assumption", "source"), ("param", "source")}
#: And what those lack that are as good as ever: it is held from the next acceptance on, and nothing is said until then.
_NOT_YET = {
    ("method", "title"), ("work", "title"), ("tool", "title"), ("scenario", "rules"), ("issue", "leads_to"), ("defeater", "evidence"),
    ("external-tests", RAN), ("evidence", ANSWERS), ("section", HEADING), ("subsystem", "role"), ("stage", "shows"), *_CITING,
}  # fmt: skip


#: How fields begin that say why something is adopted, or a method not used; that it is so, or not any more, is told where it counts.
_REASONS = ("adopted", "reason against ")
_QUOTED = re.compile("`([^`]*)`")
#: What a field that has an order was changed to: an ASIL, a count, a day.
_LAST = re.compile(r" to ([A-D]|QM|[0-9]+|[0-9]{4}-[0-9]{2}-[0-9]{2})(?: \(|$)")


@dataclass(frozen=True, slots=True)
class Change:
    """One difference. field is "" for an entry that is gone or new; before and after are as people read them, of lists what is in one alone."""

    kind: str
    name: str
    field: str
    before: str
    after: str
    weaker: bool  #: or not known to be none
    listed: bool = False
    #: Of what rules come to: whether it got weaker or stronger, by what was recorded; of what is new, or not there: why that is less.
    told: str = ""
    unasked: bool = (
        False  #: earlier versions of the program asked for no name, so that older acceptances have none
    )

    @property
    def key(self) -> str:
        """The entry that it is about."""
        return f"{self.kind} {self.name}".rstrip()

    @property
    def what(self) -> str:
        """The field, as people call it; empty where it is all that the entry says."""
        return "" if self.field in SAYING else _FIELDS.get(self.field, self.field)

    def __str__(self) -> str:
        return f"{self._said()} ({self.told})" if self.told else self._said()

    def _said(self) -> str:
        if not self.field:
            return f"{self.key} is {'gone' if self.before else 'new'}"
        if not self.what:
            was = f"{self.before or 'nothing'}, and is {self.after or 'nothing'}"
            return (
                f"{self.key}: it was {was}"
                if self.before or self.after
                else f"{self.key}: it says something else"
            )
        if not (self.before or self.after):
            return f"{self.key}: its {self.what} changed"
        if self.listed:
            parts = [f"{self.before} left" * bool(self.before), f"{self.after} came" * bool(self.after)]
            return f"{self.key}: in its {self.what} {' and '.join(part for part in parts if part)}"
        return f"{self.key}: its {self.what} changed from {self.before or 'nothing'} to {self.after or 'nothing'}"


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
    renamed = _renamed(before, now)
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
            why = _excuses(kind, now[key], bool(now[key].get("methods")))
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
    return int(_text(before.get(field, "")) or 0) - int(_text(now.get(field, "")) or 0)


def _raised(before: Content, now: Content) -> Content:
    """What was accepted, but for requirements of which a cell need only be covered in part and is now to be covered: that is more."""
    found = dict(before)
    for key, entry in before.items():
        if key.startswith(_GATE) and key.endswith(_PARTIAL) and "requirements" in entry:
            whole = now.get(f"{key.removesuffix(_PARTIAL)}, covered", {}).get("requirements", ())
            kept = set(now.get(key, {}).get("requirements", ()))
            left = [
                one for one in _elements(entry["requirements"]) if one in kept or not {one, "*"} & {*whole}
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
        said = _elements(entry.get(_PUT_INTO, ""))
        if key.startswith("campaign ") and _contents(other.get(key, {})) and not _contents(entry):
            path = next((one.removeprefix("recording ") for one in said if one.startswith("recording ")), "")
            if held := content.get(f"scenario {path}", {}).get("recording"):
                found[key] = {**entry, _PUT_INTO: sorted([*said, f"contents {held}"])}
    return found


def _contents(campaign: Entry) -> bool:
    return any(one.startswith("contents ") for one in _elements(campaign.get(_PUT_INTO, "")))


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


def _renamed(before: Content, now: Content) -> set[str]:
    """Tests that have another title, and files that are somewhere else, and are otherwise the same: as they were called before and now."""
    new: dict[tuple[str, ...], str] = {}
    # What tests come to is held from the next acceptance on: until then, they are the same where they are written in the same way.
    worked = f"text{WORKED_OUT}"
    without = {"text" if any(worked in entry for entry in before.values()) else worked}
    without |= {field for field in (ANSWERS, HEADING) if not any(field in entry for entry in before.values())}
    for key, entry in now.items():
        said = None if key in before else _but_for_its_name(key, entry, without)
        if said is not None:
            new.setdefault(said, key)
    found = set()
    for key, entry in before.items():
        said = None if key in now else _but_for_its_name(key, entry, without)
        same = None if said is None else new.pop(said, None)
        if same is not None:
            found |= {key, same}
    return found


#: Of kinds of entries that are called by the path of a file, the field that has the hash of what it holds.
_CALLED_BY_PATH = {"evidence": "sha256", "scenario": "recording", "section": "contents"}


def _but_for_its_name(key: str, entry: Entry, without: Container[str]) -> tuple[str, ...] | None:
    """What an entry says but for its title, or for where its file is; None where that is no small thing. without: fields that do not count."""
    kind, _, name = key.partition(" ")
    entry = {field: said for field, said in entry.items() if field not in without}
    if kind == "test":
        return (kind, name.partition(": ")[0], str(entry))
    if not entry.get(_CALLED_BY_PATH.get(kind, "")):
        return None
    apart = {"evidence": " at ", "section": "#"}.get(kind)
    return (kind, name.rpartition(apart)[2] if apart else "", str(entry))


def _of(kind: str, name: str, before: Entry, now: Entry, missed: bool) -> Iterator[Change]:
    for field in sorted(before.keys() | now.keys()):
        old, new = before.get(field, ""), now.get(field, "")
        if (kind, field) == ("evidence", "unnamed") and field not in before:
            # Earlier baselines do not hold it, and those of pages that name all have none: what came since is known by what the page was evidence of then.
            old = sorted({*_elements(new)} & {*_elements(before.get("requirements", ""))})
        if (kind, field) == ("evidence", ANSWERS):
            # What of it comes of a requirement or a method more, or less, is told there.
            old, new = (
                [one for one in _elements(value) if _both_in(one, before, now)] for value in (old, new)
            )
        without = field in _FILES and not new
        worked = f"{field}{WORKED_OUT}"
        if (worked in before and worked in now) or (field.endswith(WORKED_OUT) and field not in before):
            continue  # what it comes to is compared, from the next acceptance on after which it is held
        field = field.removesuffix(WORKED_OUT)
        if old == new or (kind, field) in _SILENT or (without and missed):
            continue
        if (field.startswith(_REASONS) and not (old and new)) or (
            (kind, field) in _NOT_YET and field not in before
        ):
            continue
        if UNKNOWN in (old, new):  # of a revision, whose recordings are not read
            continue
        shown = ("", "")
        if kind in ("param", "table", "place", "signal", "rulebook", "limit") and field == "says":
            shown = (_text(before.get("shown", "")), _text(now.get("shown", "")))
            shown = ("", "") if shown[0] == shown[1] else shown
        elif isinstance(old, list) or isinstance(new, list):
            both = set(_elements(old)) & set(_elements(new))
            shown = (_quoted(set(_elements(old)) - both), _quoted(set(_elements(new)) - both))
        elif not _hash(old) and not _hash(new):
            shown = (_text(old), _text(new))
        listed = isinstance(old, list) or isinstance(new, list)
        more = bool(set(_elements(new)) - set(_elements(old)))
        # To answer the same methods for one requirement more claims as much as to answer one method more.
        added = more and (
            field in ("methods", ANSWERS) or (field == "requirements" and bool(now.get("methods")))
        )
        why = (
            _excuses(kind, now, added)
            if added
            else _EXAMINES
            if more and (kind, field) == _EXAMINED
            else _UNNAMED
            if more and (kind, field) == ("evidence", "unnamed")
            else ""
        )
        weaker = bool(why) or _weaker(kind, field, old, new)
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
            one for one in _QUOTED.findall(change.before) if _weaker(change.kind, change.field, [one], [])
        }
        more = {
            one
            for one in _QUOTED.findall(change.after)
            if change.told or _weaker(change.kind, change.field, [], [one])
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
        if any(not _weaker(change.kind, change.field, value, change.after) for value in ordered):
            return True
    return False


def _is(text: str, said: str) -> bool:
    """Whether a text is this one, whatever was told beside it."""
    return text == said or text.startswith(f"{said} (")


def _ends(text: str, end: str) -> bool:
    return text.endswith(end) or f"{end} (" in text


def _excuses(kind: str, entry: Entry, methods: bool) -> str:
    """Why evidence that is new, or that answers more `methods`, is less; empty where it is not."""
    if kind == "report" and entry.get("may be missing"):
        return _EXCUSES
    if kind == "scenario":
        return _RECORDED if entry.get("origin") == "field" else ""
    if kind == "evidence" and not methods and entry.get("unnamed"):
        return _UNNAMED
    return _CLAIMS if kind in ("evidence", "report") and methods else ""


def _weaker(kind: str, field: str, old: Value, new: Value) -> bool:
    """Whether less is demanded or shown; True where that is not known."""
    if (kind, field) in _FEWER or field.startswith("link "):
        return bool(set(_elements(old)) - set(_elements(new)))
    if (kind, field) in _MORE:
        return bool(set(_elements(new)) - set(_elements(old)))
    if field == "asil" and isinstance(old, str) and isinstance(new, str) and {old, new} <= set(ASILS):
        return ASILS.index(new) < ASILS.index(old)
    if counted(kind, field):
        return int(_text(new) or 0) < int(_text(old) or 0)
    if field in _LATER and not old:
        return False
    if field == "boundary":
        return not new
    if (kind, field) in _CITING:
        return not new or put_off(_text(new))  # what is worded otherwise still says where it comes from
    if (kind, field) in _LENIENT:
        return bool(new)
    if (
        kind == "hazard"
        and field in _CLASSES
        and isinstance(old, str)
        and isinstance(new, str)
        and old[:1] == new[:1] != ""
    ):
        return new < old
    if (kind, field) == ("waiver", "expires"):
        return _text(new) > _text(old)
    return True


def _elements(value: Value) -> list[str]:
    return [value] if isinstance(value, str) and value else list(value)


def _quoted(names: set[str]) -> str:
    return ", ".join(f"`{name}`" for name in sorted(names))


def _hash(value: Value) -> bool:
    return isinstance(value, str) and len(value) == 64 and set(value) <= set("0123456789abcdef")


def _text(value: Value) -> str:
    return value if isinstance(value, str) else ", ".join(value)
