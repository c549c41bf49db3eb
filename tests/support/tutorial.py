"""A page whose files are written and whose commands are run, in their order, in one folder."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from support.project import run_command

_BLOCK = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_STATUS = re.compile(r"\s+# exit status (\d)$")
_DAY = re.compile(r"\d{4}-\d{2}-\d{2}")


@dataclass(frozen=True)
class Ran:
    """The commands of one block: what they printed, with what the page shows below it; and exit statuses with those it says."""

    commands: str
    said: str
    #: None where the page shows nothing.
    shown: str | None
    statuses: tuple[int, ...]
    wanted: tuple[int, ...]


def run(page: str) -> Iterator[Ran]:
    """Do what the page says in the current folder."""
    blocks = [match.groups() for match in _BLOCK.finditer(page)]
    for (language, info, text), after in zip(blocks, [*blocks[1:], ("", "", "")]):
        if language == "sh":
            said, statuses, wanted = "", [], []
            for line in text.splitlines():
                status = _STATUS.search(line)
                wanted.append(int(status[1]) if status else 0)
                out, code = _command(shlex.split(_STATUS.sub("", line)))
                said += out
                statuses.append(code)
            yield Ran(text, said, after[2] if after[0] == "text" else None, tuple(statuses), tuple(wanted))
        elif info:
            _write(*info.split(maxsplit=1), text)
        else:
            assert language == "text", f"a block that is nothing: {language}"


def _command(words: list[str]) -> tuple[str, int]:
    if words[0] == "cd":
        os.chdir(words[1])
        return "", 0
    if words[0] == "trackmarshal":
        status, out, err = run_command(*words[1:])
        return out + err, status
    done = subprocess.run(words, check=False, capture_output=True, text=True)
    return done.stdout + done.stderr, done.returncode


def _write(name: str, *how: str) -> None:
    """A file as a whole, what is appended to it, or lines that follow one of its lines."""
    *where, text = how
    path = Path(name)
    if not where:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
    elif where == ["append"]:
        path.write_text(f"{path.read_text('utf-8')}\n{text}", "utf-8")
    else:
        lines = path.read_text("utf-8").splitlines(keepends=True)
        (place,) = (number for number, line in enumerate(lines) if line.strip() == where[0])
        path.write_text("".join([*lines[: place + 1], text, *lines[place + 1 :]]), "utf-8")


def same(said: str, shown: str) -> bool:
    """Whether what was printed is what is shown: days aside, and `...` is any lines."""
    parts = [re.escape(_DAY.sub("DAY", part)) for part in re.split(r"^\.\.\.\n", shown, flags=re.MULTILINE)]
    return re.fullmatch(r"(?:.*\n)*?".join(parts), _DAY.sub("DAY", said)) is not None
