"""One difference between a baseline and what there is now, in the words in which it is told and accepted."""

from __future__ import annotations

from dataclasses import dataclass

from trackmarshal.trace.baseline.content import RAN

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
