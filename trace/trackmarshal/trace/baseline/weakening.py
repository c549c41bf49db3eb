"""Which differences are a weakening: less is demanded or shown than before, or that is not known."""

from __future__ import annotations

from trackmarshal.trace.baseline.content import ANSWERS, UNMARKED, Entry, Value, counted
from trackmarshal.trace.shapes import put_off

_ASILS = ("QM", "A", "B", "C", "D")

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
#: Why a report that may be missing is less, and methods that it names: nobody asks for other evidence then (T255).
_EXCUSES = "it may be missing, and other evidence is not asked for then"
#: Why methods that a document or a report is said to answer are: no link tells that it does.
_CLAIMS = "that it is evidence of this kind is for somebody to say"
#: And one requirement more that an analysis is said to be of: its document may say nothing of it.
_EXAMINES = "that it is an analysis of that, too, is for somebody to say"
#: And a recording that is said to come from a vehicle: a generated one with another name in its first line looks like one.
_RECORDED = "that it was recorded on a vehicle is for somebody to say"
#: And a page that is said to be evidence of what it does not name.
_UNNAMED = "that a page that does not name it is evidence of it is for somebody to say"
#: What earlier baselines did not hold: that it is held from now on is no weakening.
_LATER = ("evidence sha256", "put in", "named", "replayed with", "closed loop", "title", "rationale")
#: Where something comes from.
CITING = {("requirement", "source"), ("rule", "source"), ("assumption", "source"), ("param", "source")}


def is_weaker(kind: str, field: str, old: Value, new: Value) -> bool:
    """Whether less is demanded or shown; True where that is not known."""
    if (kind, field) in _FEWER or field.startswith("link "):
        return bool(set(elements(old)) - set(elements(new)))
    if (kind, field) in _MORE:
        return bool(set(elements(new)) - set(elements(old)))
    if field == "asil" and isinstance(old, str) and isinstance(new, str) and {old, new} <= set(_ASILS):
        return _ASILS.index(new) < _ASILS.index(old)
    if counted(kind, field):
        return int(text(new) or 0) < int(text(old) or 0)
    if field in _LATER and not old:
        return False
    if field == "boundary":
        return not new
    if (kind, field) in CITING:
        return not new or put_off(text(new))  # what is worded otherwise still says where it comes from
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
        return text(new) > text(old)  # without a day, as "", it never holds
    return True


def excuses(kind: str, entry: Entry, methods: bool) -> str:
    """Why evidence that is new, or that answers more `methods`, is less; empty where it is not."""
    if kind == "report" and entry.get("may be missing"):
        return _EXCUSES
    if kind == "scenario":
        return _RECORDED if entry.get("origin") == "field" else ""
    if kind == "evidence" and not methods and entry.get("unnamed"):
        return _UNNAMED
    return _CLAIMS if kind in ("evidence", "report") and methods else ""


def claimed(kind: str, field: str, now: Entry) -> str:
    """Why a field that holds more than before is less: it is claimed of evidence, and nobody has said it yet; empty where it is not."""
    # To answer the same methods for one requirement more claims as much as to answer one method more.
    if field in ("methods", ANSWERS) or (field == "requirements" and now.get("methods")):
        return excuses(kind, now, True)
    if (kind, field) == ("analysis", "link examines"):
        return _EXAMINES
    return _UNNAMED if (kind, field) == ("evidence", "unnamed") else ""


def elements(value: Value) -> list[str]:
    """Of a list, or of a text, which is one where it is not empty."""
    return [value] if isinstance(value, str) and value else list(value)


def text(value: Value) -> str:
    """As one text."""
    return value if isinstance(value, str) else ", ".join(value)
