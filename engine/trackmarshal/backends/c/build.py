"""Generated C to a shared library: compiled once for its content, kept in the user's cache."""

from __future__ import annotations

import atexit
import ctypes
import errno
import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.util import find_spec
from itertools import takewhile
from pathlib import Path

from trackmarshal.backends.c.functions.operators import called
from trackmarshal.backends.c.glue import glue
from trackmarshal.backends.c.source import Source
from trackmarshal.cache import cache_folder
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.operators import FUNCTIONS

#: Functions of libm of which another one may give other digits.
OWN_DIGITS = sorted({c for name, function in FUNCTIONS.items() if function.libm for c in called(name)[1]})
#: Without these, a compiler may fuse, re-associate, or compute functions of constants by other code than libm's.
DIGITS = ("-ffp-contract=off", "-fno-fast-math", *(f"-fno-builtin-{name}" for name in OWN_DIGITS))
EXACT = ("-std=c99", *DIGITS)
#: sqrt as one instruction: nobody reads errno. Signals of the floating-point unit are not used either. Behind -fno-fast-math, which takes both back.
UNSIGNALLED = ("-fno-math-errno", "-fno-trapping-math")
FAST = ("-O2", *UNSIGNALLED)
SHARED = ("-shared", "-fPIC")
#: Where Linux tells of processors.
PROCESSORS = Path("/proc/cpuinfo")
#: What compilers are told, so that they say in one language why a disk takes nothing.
_ENGLISH = {"LC_ALL": "C"}
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)


def own_machine() -> tuple[str, ...]:
    """Flags for what runs on this machine alone. Part of the name under which it is kept: of a cache that machines share, none takes what it cannot run.

    Wider registers, and nothing that fuses: gcc 12.2 with -mfma fuses some products and sums whatever -ffp-contract says.
    """
    return ("-mavx2",) if "avx2" in _features() else ()


def _features() -> list[str]:
    """What the first processor can do, where Linux tells of an x86; empty elsewhere."""
    try:
        with PROCESSORS.open(encoding="utf-8", errors="replace") as lines:
            return next(
                (line.split() for line in takewhile(str.strip, lines) if line.startswith("flags")), []
            )
    except OSError:
        return []


def compiler() -> list[str] | None:
    """The command of the C compiler: $CC, else the first of cc, gcc, clang, else that of the package ziglang; None without one."""
    given = os.environ.get("CC")
    if given:
        words = shlex.split(given)
        return words if words and shutil.which(words[0]) else None
    for name in ("cc", "gcc", "clang"):
        path = shutil.which(name)
        if path:
            return [path]
    return [sys.executable, "-m", "ziglang", "cc"] if find_spec("ziglang") is not None else None


def library(source: Source, capacities: Mapping[str, int]) -> Path:
    """The shared library of a program, built if it is not there; raises TrackmarshalError E471 or E472."""
    files = {f"{source.name}.h": source.header, f"{source.name}.c": source.source, "glue.c": glue(source)}
    return _built(files, ["glue.c", "-lm"], [*_flags(capacities), *SHARED], "so")


def sizes(source: Source, types: Sequence[str]) -> Path:
    """A library whose `sizes` are the bytes of types in a program's header with the default capacities; raises TrackmarshalError E471 or E472.

    Whether a compiler takes the program is asked too, but no code is made of it: for the shipped rules that would be all but a fiftieth of the time.
    """
    asked = ", ".join(f"sizeof({name})" for name in types)
    header, own = f"{source.name}.h", f"{source.name}.c"
    units = {"sizes.c": f'#include "{header}"\nconst size_t sizes[] = {{{asked}}};\n'}
    files = {header: source.header, own: source.source, **units}
    return _built(files, list(units), [*_flags({}), *SHARED], "so", checked=[own])


def loaded(path: Path) -> ctypes.CDLL:
    """A library that was built; raises TrackmarshalError E471 where this system does not load it."""
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        help_ = "a compiler in $CC may be one for another machine; if the disk is mounted `noexec`, name another folder in TRACKMARSHAL_CACHE"
        raise TrackmarshalError("E471", f"what was compiled is not loaded: {error}", help=help_) from error


def small_library(*paths: Path) -> Path:
    """The shared library of files of ours that depend on no spec, headers among them; raises TrackmarshalError E471 or E472."""
    files = {path.name: path.read_text(encoding="utf-8") for path in paths}
    units = [name for name in files if name.endswith(".c")]
    return _built(files, units, ["-std=c99", "-O2", *SHARED], "so")


def program(
    source: Source, files: Mapping[str, str], units: Sequence[str], capacities: Mapping[str, int]
) -> Path:
    """A program around a Supervisor, of further files of which `units` are compiled, built if it is not there; raises TrackmarshalError
    E471 or E472. The Supervisor's own code is compiled once for all programs that it is in."""
    flags = _flags(capacities)
    header = {f"{source.name}.h": source.header}
    own = f"{source.name}.c"
    compiled = _built({**header, own: source.source}, [own], [*flags, "-c"], "o")
    return _built({**header, **files}, [*units, str(compiled), "-lm"], flags, "run")


def _flags(capacities: Mapping[str, int]) -> list[str]:
    macros = [f"-D{name}={value}u" for name, value in sorted(capacities.items())]
    return [*EXACT, *FAST, *own_machine(), *macros]


def _built(
    files: Mapping[str, str], units: Sequence[str], flags: list[str], ending: str, checked: Sequence[str] = ()
) -> Path:
    """What a compiler makes of units among files, kept under a name that ends so; it has to take those that are checked, too."""
    digest = hashlib.sha256()
    # A processor has programs of 64 and of 32 bits, and of one C library or another, which share a home but not what is loaded.
    kind = str(getattr(sys.implementation, "_multiarch", ""))
    machine = (os.environ.get("CC", ""), platform.machine(), sys.platform, kind)
    for part in (*files.values(), *units, *checked, *flags, *machine):
        digest.update(part.encode())
        digest.update(b"\0")
    folder = cache_folder()
    name = digest.hexdigest()[:32]
    try:
        # In folders of their own, by the first letters: in a folder of thousands, looking takes as long as compiling something small.
        root = (_uncached() if folder is None else folder) / "c" / name[:2]
        root.mkdir(parents=True, exist_ok=True)
        return _kept(root, name, ending) or _compile(files, units, flags, root, name, ending, checked)
    except OSError as error:
        help_ = "check the folder's permissions and the space left, or name another one in TRACKMARSHAL_CACHE"
        raise TrackmarshalError("E471", f"what is compiled has no place: {error}", help=help_) from error


@cache
def _uncached() -> Path:
    """What stands for the cache where there is none: a folder that this process alone has, and that goes with it.

    A process that was forked has it, too, and leaves it to the one that made it.
    """
    folder, own = Path(tempfile.mkdtemp(prefix="trackmarshal-")), os.getpid()

    def away() -> None:
        if os.getpid() == own:
            shutil.rmtree(folder, ignore_errors=True)

    atexit.register(away)
    return folder


def _kept(root: Path, name: str, ending: str) -> Path | None:
    """What was built of a program, if it is there and is what was once built: its file's name ends in the hash of its content."""
    for path in root.glob(f"{name}-*.{ending}"):
        if path.stem.rpartition("-")[2] == _hash(path):
            return path
    return None


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:32]


def _compile(
    files: Mapping[str, str],
    units: Sequence[str],
    flags: list[str],
    root: Path,
    name: str,
    ending: str,
    checked: Sequence[str],
) -> Path:
    command = compiler()
    if command is None:
        raise TrackmarshalError(
            "E471",
            "no C compiler is found",
            help="install gcc or clang, or `pip install trackmarshal[c]`; or name one in $CC, or choose another backend",
        )
    # Built aside and moved: another process sees all of it or nothing, and two builders overwrite each other with the same.
    with tempfile.TemporaryDirectory(dir=root) as folder:
        place = Path(folder)
        for file, text in files.items():
            (place / file).write_text(text, encoding="utf-8")
        for words in (*(["-fsyntax-only", unit] for unit in checked), ["-o", "made", *units]):
            try:
                done = subprocess.run(
                    [*command, *flags, *words],
                    cwd=place,
                    capture_output=True,
                    text=True,
                    check=False,
                    env={**os.environ, **_ENGLISH},
                )
            except OSError as error:
                message = f"`{' '.join(command)}` cannot be run: {error}"
                raise TrackmarshalError("E471", message, help="name another compiler in $CC") from error
            if done.returncode != 0:
                message = f"`{' '.join(command)}` says: {done.stderr.strip()[:2000]}"
                if any(os.strerror(cause) in done.stderr for cause in _NO_ROOM):
                    raise OSError(message)
                raise TrackmarshalError("E472", message)
        target = root / f"{name}-{_hash(place / 'made')}.{ending}"
        os.replace(place / "made", target)
    return target
