"""Which finding follows from which: in time, whatever a document lacks."""

from __future__ import annotations

import time

from trackmarshal.trace.causes import causes
from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.graph.graph import Graph


def test_a_document_in_which_every_record_lacks_something_is_told_in_time() -> None:
    """As a list of requirements that a program wrote: of 200 that each lacked five fields `trace` took 12 s, and the time grew as the square of that."""
    lacking = [
        Finding("T120", "error", "`title` is missing", Place("requirements/all.yaml", line, 5))
        for line in range(1, 3_001)
    ]
    absent = [Finding("T137", "error", "nothing of this id", None, subject=f"R-{n}") for n in range(1_000)]
    start = time.process_time()
    found = causes([*lacking, *absent], Graph({}, ()))
    assert time.process_time() - start < 2.0
    assert found == dict.fromkeys(absent, lacking[0])  # what was not read may be why things are not there


def test_what_follows_from_one_of_many_alike_follows_from_the_first() -> None:
    """Also where those that come before it follow from something themselves."""
    page = "requirements/all.yaml"
    broken = Finding("T105", "error", "not YAML", Place(page, 1))
    alike = [Finding("T120", "error", f"{n}", Place(page, n)) for n in range(2, 6)]
    later = Finding("T218", "error", "a result of no test", Place(page, 9))
    assert causes([later, *alike], Graph({}, ())) == {later: alike[0]}
    assert causes([later, *alike, broken], Graph({}, ())) == dict.fromkeys([later, *alike], broken)
