"""What `make oldest` installs: of each package that the tests use, the least version that pyproject.toml names."""

from __future__ import annotations

import re
import tomllib

from support.shared import REPOSITORY

#: Tools that no test imports, a compiler, and types; and `plot`, which the tests have in a newer version.
NOT_TRIED = {"import-linter", "mypy", "ruff", "types-PyYAML", "types-jsonschema", "ziglang"}


def test_the_oldest_are_those_that_are_named() -> None:
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["project"]
    extras = {name: wanted for name, wanted in project["optional-dependencies"].items() if name != "plot"}
    wanted = [*project["dependencies"], *(one for each in extras.values() for one in each)]
    named = dict(re.fullmatch(r"([\w-]+)(?:>=([\d.]+))?", one).groups() for one in wanted)  # type: ignore[union-attr, misc]
    lines = (REPOSITORY / "tests" / "oldest.txt").read_text("utf-8").splitlines()
    pinned = dict(line.lower().split("==") for line in lines if not line.startswith("#"))
    assert pinned.keys() == named.keys() - NOT_TRIED
    assert [name for name, version in pinned.items() if not f"{version}.".startswith(f"{named[name]}.")] == []
