"""Files that are new: all of them are written, or none, and nothing that is there is touched."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from jinja2 import Environment

_TEMPLATES = Path(__file__).parent / "templates"


def render(template: str, **values: object) -> str:
    """A template of this package, with values in place of its names; one that is missing is a defect, and raises."""
    return _environment().get_template(template).render(values)


def write_new(root: Path, texts: Mapping[str, str]) -> list[Path]:
    """Write texts by their paths below `root`, which is made if need be; the files, in order.

    Raises E412 where one of them is there, before anything is written.
    """
    refuse_present(root, texts)
    written: list[Path] = []
    with taken_back(written):
        for name, text in texts.items():
            path = root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            # "x": what somebody else made in the meantime stays as it is.
            with path.open("x", encoding="utf-8", newline="\n") as file:
                written.append(path)
                file.write(text)
    return written


@contextmanager
def taken_back(written: list[Path]) -> Iterator[None]:
    """Remove the files that were written so far where what is done meanwhile raises, also where somebody interrupts."""
    try:
        yield
    except BaseException:
        for path in written:
            path.unlink()
        raise


def refuse_present(root: Path, names: Iterable[str]) -> None:
    """Raise E412 where one of these paths below `root` is there, be it a link to nothing."""
    for name in names:
        if os.path.lexists(root / name):
            raise TrackmarshalError(
                "E412",
                f"{name} is there already",
                file=str(root / name),
                help="nothing was written; choose another place or another name, or edit what is there",
            )


@cache
def _environment() -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    return Environment(
        loader=FileSystemLoader(_TEMPLATES), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True, autoescape=False,
    )  # fmt: skip
