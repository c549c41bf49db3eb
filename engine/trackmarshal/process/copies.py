"""What `compile --process` writes for Python: the modules here that need nothing of trackmarshal, as a package of their own."""

from __future__ import annotations

from pathlib import Path

#: They import each other by relative names only.
MODULES = ("messages", "shared_memory", "datagrams", "client", "executing")
_HEAD = '"""What talks to a Supervisor that is a process of its own. Written by trackmarshal; docs/process.md."""\n'


def link() -> dict[str, str]:
    """Files of the package `link` by path."""
    folder = Path(__file__).parent
    copied = {f"link/{name}.py": (folder / f"{name}.py").read_text(encoding="utf-8") for name in MODULES}
    return {"link/__init__.py": _HEAD, **copied}
