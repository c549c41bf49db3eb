"""Tests that have another title, and files that are somewhere else, and are otherwise the same: no change."""

from __future__ import annotations

from collections.abc import Container

from trackmarshal.trace.baseline.content import ANSWERS, HEADING, WORKED_OUT, Content, Entry

#: Of kinds of entries that are called by the path of a file, the field that has the hash of what it holds.
_CALLED_BY_PATH = {"evidence": "sha256", "scenario": "recording", "section": "contents"}


def renamings(before: Content, now: Content) -> set[str]:
    """Such entries, as they were called before and now."""
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
