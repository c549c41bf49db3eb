"""What keeps a report of another test runner from being read: title and explanation, for `trackmarshal explain CODE`."""

from __future__ import annotations

CODES: dict[str, tuple[str, str]] = {
    "T331": ("a test report that is not XML", "The file breaks XML's rules at this line, or is cut off. None of its tests counts."),
    "T332": ("a test report with a document type", "Document types and entities make a small file a huge one, and fetch other files. No test runner needs them; a report that has one is refused whole."),
    "T333": ("XML that is no test report", "The file has another root than `testsuites` or `testsuite`, or an element where no test runner is known to write one. What it says about its tests is not guessed; none of them counts."),
    "T334": ("a test report that is too large", "A report of more than 64 MB, nested more than 60 deep, with a name of more than 4,000 characters, or whose suites name requirements of all of their tests more than 5,000,000 times is taken for something else."),
    "T335": ("a test report that lacks tests", "A suite says that it has more tests, failures, errors or skipped tests than are listed in it, or that it failed, broke off or did not run, and lists none of which that is so. The file is cut off or was edited, or the run did not come to its end; none of its tests counts."),
}  # fmt: skip
