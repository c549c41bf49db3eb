"""The emitted C of a process, function by function: mailboxes, the client, the desk and what can stand in a message, at their edges.

It is a library here, so that nothing depends on when a process comes to it. Where a fence stands, Python is asked: what another process may do meanwhile
is done there.
"""

from __future__ import annotations

import ctypes
import math
import os
import re
import shutil
import subprocess
import sys
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from trackmarshal.backends.c.build import EXACT, SHARED, _built, compiler
from trackmarshal.backends.c.process.emit import Emitted
from trackmarshal.backends.c.source import generate
from trackmarshal.process import shared_memory
from trackmarshal.process.client import Border, Client
from trackmarshal.process.executing import Executing
from trackmarshal.process.messages import Layout, LinkError, Message
from trackmarshal.process.shared_memory import Region
from trackmarshal.runtime.cycle import Limits

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

SPEC = """module m
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s, lit: bool }
signal objects : set of object { x: m, v: m/s, shy: bool default false } capacity 3
signal marks : series { x: m, v: m/s }
signal track : corridor { left: polyline, right: polyline }
signal stop : polyline
event yellow "a yellow flag is shown"
rule calm ""
  require not yellow or ego.lit or ego.v < 30 m/s
rule room ""
  for all o in objects
  require once[0 s, 1 s] (o.x - ego.x > 0 m or o.v >= 0 m/s or o.shy)
rule slow ""
  for all p in marks
  require p.v < 30 m/s
rule beside ""
  for all p in plan
  require distance_to(p, track.left) >= 1 m and distance_to(p, track.right) >= 1 m
rule before ""
  for all p in plan
  require distance_to(p, stop) >= 1 m
"""
LIMITS = Limits(samples=8, elements=3, border=4, budget=1e9)
#: Beside what is emitted: what Python cannot see by itself, and what stands where a fence does.
PROBE = """
#include "client.h"
#include "desk.h"
#include "executing.h"
void (*probe_hook)(void) = NULL;
void (*probe_stored)(void) = NULL;
void probe_store(void) { if (probe_stored != NULL) { probe_stored(); } }
void probe_fence(int order) { (void)order; if (probe_hook != NULL) { probe_hook(); } }
size_t probe_desk(void) { return sizeof(tml_desk); }
size_t probe_client(void) { return sizeof(tml_client); }
size_t probe_executing(void) { return sizeof(tml_executing); }
const unsigned char *probe_out(const tml_desk *desk) { return desk->out.bytes; }
uint64_t probe_refused(const tml_client *client, size_t cause) { return client->refused[cause]; }
"""
#: The process itself, which tells Python of each look into a mailbox.
SERVE = """
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "mailbox.h"
static bool probe_get(const tml_region *region, const tml_box *box, uint64_t *seen, tml_message *into, tml_cause *cause);
#define main process_main
#define tml_get probe_get
#include "process.c"
#undef tml_get
void (*probe_looked)(void) = NULL;
static bool probe_get(const tml_region *region, const tml_box *box, uint64_t *seen, tml_message *into, tml_cause *cause) {
  const bool found = tml_get(region, box, seen, into, cause);
  probe_looked();
  return found;
}
void probe_end(void) { ending = 1; }
bool probe_serve(const char *name) {
  const char *which;
  ending = 0;
  if (!tml_desk_start(&desk, 77u, true, &which) || !shared_memory(name)) { return false; }
  serve_memory(TML_WAIT_POLL);
  return true;
}
"""
FENCED = """
void probe_fence(int);
void probe_store(void);
#define __atomic_thread_fence(order) probe_fence(order)
#define __atomic_store_n(at, value, order) (probe_store(), __atomic_store_n(at, value, order))
#define __atomic_add_fetch(at, value, order) (probe_store(), __atomic_add_fetch(at, value, order))
"""
#: Before the desk: what it counts by has 32 bits, as on a smaller machine; all that others count by too is declared by then.
NARROW = """
#define _POSIX_C_SOURCE 200809L
#include <float.h>
#include <math.h>
#include <string.h>
#include <time.h>
#include "messages.h"
#define size_t uint32_t
"""
UNITS = ("messages.c", "mailbox.c", "client.c", "desk.c", "executing.c", "supervisor.c", "probe.c", "serve.c")
FETCH = ctypes.CFUNCTYPE(
    ctypes.c_bool, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.POINTER(ctypes.c_size_t)
)
HOOK = ctypes.CFUNCTYPE(None)

PLAN = {"t": [0.0, 0.4, 2.0], "x": [0.0, 4.0, 12.0], "y": [0.0] * 3, "heading": [0.0] * 3, "v": [10.0, 10.0, 0.0]}  # fmt: skip
LEFT, RIGHT, STOP = ([[-50.0, 6.0], [90.0, 6.0]], [[-50.0, -6.0], [90.0, -6.0]], [[80.0, -5.0], [80.0, 5.0]])


class C:
    """The library, and the messages that it speaks."""

    def __init__(self, narrow: bool = False) -> None:
        spec = tm.loads(SPEC)
        source = generate(spec, list(spec.rules), doored=True)
        made = Emitted(source, asdict(LIMITS))
        self.layout = Layout(made.description)
        files = {
            "supervisor.h": source.header,
            "supervisor.c": source.source,
            "probe.c": PROBE,
            "serve.c": SERVE,
            **made.files,
        }
        files["mailbox.c"] = FENCED + files["mailbox.c"]
        files["desk.c"] = (NARROW if narrow else "") + files["desk.c"]
        flags = [*EXACT, "-O0", *(f"-D{name}={size}u" for name, size in made.sizes.items()), *SHARED]
        self.dll: Any = ctypes.CDLL(str(_built(files, [*UNITS, "-lm"], flags, "so")))
        for name in ("probe_desk", "probe_client", "probe_executing"):
            getattr(self.dll, name).restype = ctypes.c_size_t
        self.dll.probe_out.restype = ctypes.c_void_p
        for name, kinds in {
            "tml_desk_start": [ctypes.c_void_p, ctypes.c_uint64, ctypes.c_bool, ctypes.c_void_p],
            "tml_desk_take": [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t, FETCH, ctypes.c_void_p, ctypes.c_void_p],
            "tml_desk_overdue": [ctypes.c_void_p], "tml_region_open": [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_bool, ctypes.c_bool, ctypes.c_void_p],
            "tml_get": [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p],
            "tml_client_memory_of": [ctypes.c_void_p, ctypes.c_uint64, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_int, ctypes.c_void_p],
            "probe_serve": [ctypes.c_char_p], "tml_client_tick": [ctypes.c_void_p], "tml_client_hear": [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p],
            "tml_client_answer": [ctypes.c_void_p, ctypes.c_uint64, ctypes.c_double, ctypes.c_char_p],
            "tml_executing_start_of": [ctypes.c_void_p, ctypes.c_uint64, ctypes.c_size_t, ctypes.c_double, ctypes.c_bool],
        }.items():  # fmt: skip
            getattr(self.dll, name).argtypes = kinds
            getattr(self.dll, name).restype = ctypes.c_bool
        self.dll.tml_desk_clock.restype, self.dll.tml_desk_clock.argtypes = ctypes.c_double, [ctypes.c_void_p]
        self.dll.tml_desk_beat.argtypes = [ctypes.c_void_p]
        self.dll.probe_out.argtypes = [ctypes.c_void_p]
        self.dll.tml_put.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p]
        self.dll.tml_client_send.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
        self.dll.tml_client_send.restype = self.dll.probe_refused.restype = ctypes.c_uint64
        self.dll.probe_refused.argtypes = [ctypes.c_void_p, ctypes.c_size_t]
        self.dll.tml_client_time.argtypes = [ctypes.c_void_p, ctypes.c_double]
        self.dll.tml_client_close.argtypes = [ctypes.c_void_p]
        self.dll.tml_look.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_bool]
        self.dll.tml_sound.argtypes = [ctypes.c_char_p]
        self.dll.tml_executing_hear.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t]
        self.dll.tml_crc.restype = ctypes.c_uint32
        self.dll.tml_crc.argtypes = [ctypes.c_uint32, ctypes.c_char_p, ctypes.c_size_t]
        self.sizes = {file["name"]: file["size"] for file in self.layout.said["memory"]["files"]}

    def box(self, file: str, name: str) -> int:
        """Where C has a mailbox."""
        boxes = next(one["mailboxes"] for one in self.layout.said["memory"]["files"] if one["name"] == file)
        at = ctypes.addressof(ctypes.c_char.in_dll(self.dll, f"tml_{file}_boxes"))
        return at + 40 * [box["name"] for box in boxes].index(name)

    def hooked(self, hook: Callable[[], None] | None, where: str = "probe_hook") -> Any:
        """Ask Python at every fence, or look; what is returned has to be kept as long as it is asked."""
        called = HOOK() if hook is None else HOOK(hook)
        ctypes.c_void_p.in_dll(self.dll, where).value = ctypes.cast(called, ctypes.c_void_p).value
        return called

    def room(self, message: bytes = b"") -> Any:
        """Memory for any message."""
        return ctypes.create_string_buffer(bytes(message), max(self.layout.longest, len(message)) + 1)

    def sealed(self, kind: str, message: bytearray, session: int, sequence: int, sent: float) -> bytes:
        self.layout.seal(message, self.layout.kinds[kind], session, sequence, sent)
        return bytes(message)


@pytest.fixture(scope="module")
def c() -> C:
    return C()


@pytest.mark.parametrize("flag", ["-ffast-math", "-ffinite-math-only", "-fno-math-errno"])
def test_a_time_that_is_none_is_not_compiled_away(flag: str, tmp_path: Path) -> None:
    """A client that took no number for NaN sent no stamp, so that every cycle was refused, and the executing layer drove on whatever ended
    at no time. The Supervisor's own source refuses such flags, which are for each file to have."""
    spec = tm.loads(SPEC)
    source = generate(spec, list(spec.rules), doored=True)
    made = Emitted(source, asdict(LIMITS))
    for name, text in {"supervisor.h": source.header, **made.files}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    for unit in ("messages.c", "client.c", "desk.c", "executing.c"):
        sizes = [f"-D{name}={size}u" for name, size in made.sizes.items()]
        command = [*(compiler() or []), "-std=c99", *sizes, "-E", flag, unit]
        said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        refused = flag != "-fno-math-errno"
        assert ((said.returncode != 0), ("compile this file without" in said.stderr)) == (refused, refused), (
            unit
        )


#: As 32-bit PCs have them: a number of 64 bits is aligned to 4 bytes.
ALIGNED_TO_4 = """
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "mailbox.h"
typedef uint64_t four __attribute__((aligned(4)));
#define uint64_t four
#include "mailbox.c"
#undef uint64_t
size_t aligned(void) { return __alignof__(*word(NULL, 0u)); }
"""


def test_words_of_shared_memory_are_atomic_on_32_bits(tmp_path: Path) -> None:
    """clang takes the alignment of the type, and had a library lock what it takes for unaligned: a lock in each process by itself, for which nothing is linked."""
    spec = tm.loads(SPEC)
    source = generate(spec, list(spec.rules), doored=True)
    made = Emitted(source, asdict(LIMITS))
    flags = [*EXACT, "-O0", *(f"-D{name}={size}u" for name, size in made.sizes.items()), *SHARED]
    files = {"supervisor.h": source.header, **made.files, "aligned.c": ALIGNED_TO_4}
    dll = ctypes.CDLL(str(_built(files, ["aligned.c", "-lm"], flags, "so")))
    dll.aligned.restype = ctypes.c_size_t
    assert dll.aligned() == 8


#: As machines of 32 bits have it whose times have 64 (musl; glibc with _TIME_BITS=64): seconds are twice as long as what their kernel reads.
LONG_SECONDS = """
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "mailbox.h"
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
struct long_seconds { __int128 tv_sec; long tv_nsec; };
static long most[2];
static long asked(long number, ...) {
  va_list given;
  va_start(given, number);
  (void)va_arg(given, void *);
  (void)va_arg(given, int);
  (void)va_arg(given, unsigned);
  (void)memcpy(most, va_arg(given, const void *), sizeof(most));
  va_end(given);
  return 0;
}
#define time_t __int128
#define timespec long_seconds
#define clock_gettime(clock, at) ((at)->tv_sec = 0, (at)->tv_nsec = 0, 0)
#define nanosleep(time, left) ((void)(time), 0)
#define syscall asked
#include "mailbox.c"
double slept(double seconds) {
  static uint64_t memory[64];
  const tml_region region = {(unsigned char *)memory, sizeof(memory)};
  tml_wait(&region, 0u, seconds, TML_WAIT_SLEEP);
  return (double)most[0] + (1e-9 * (double)most[1]);
}
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere, nobody sleeps")
@pytest.mark.parametrize(("seconds", "most"), [(0.01, 0.01), (0.75, 0.75), (1.0, 1.0), (1e9, 1.0)])
def test_who_sleeps_where_times_are_longer_than_words_does_so_as_long_as_said(
    seconds: float, most: float
) -> None:
    """The kernel read no time at all, and the process looked all the time, which kept a processor busy: on one with a real-time priority, from all others."""
    spec = tm.loads(SPEC)
    source = generate(spec, list(spec.rules), doored=True)
    made = Emitted(source, asdict(LIMITS))
    flags = [*EXACT, "-O0", *(f"-D{name}={size}u" for name, size in made.sizes.items()), *SHARED]
    files = {"supervisor.h": source.header, **made.files, "slept.c": LONG_SECONDS}
    dll = ctypes.CDLL(str(_built(files, ["slept.c", "-lm"], flags, "so")))
    dll.slept.restype, dll.slept.argtypes = ctypes.c_double, [ctypes.c_double]
    assert dll.slept(seconds) == pytest.approx(most, abs=2e-9)


def test_nothing_is_kept_but_in_what_a_caller_has(tmp_path: Path) -> None:
    """Desks, clients and executing layers serve a thread each: two desks shared the line that was fetched last, and whoever was first wrote down
    the tables of CRCs, beside those that read them."""
    spec = tm.loads(SPEC)
    source = generate(spec, list(spec.rules), doored=True)
    made = Emitted(source, asdict(LIMITS))
    for name, text in {"supervisor.h": source.header, **made.files}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    units = [f"{name}.c" for name in ("messages", "mailbox", "desk", "client", "executing")]
    sizes = [f"-D{name}={size}u" for name, size in made.sizes.items()]
    command = [*(compiler() or []), *EXACT, "-fno-pie", "-O0", *sizes, "-c", *units]
    subprocess.run(command, cwd=tmp_path, check=True)
    objects = [unit.replace(".c", ".o") for unit in units]
    said = subprocess.run(["nm", *objects], cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert "T tml_crc" in said
    assert [line for line in said.splitlines() if re.search(" [BbCDdGgSs] ", line)] == []


#: As a host has it for each of its Supervisors.
ITS_OWN = """#include "client.h"
#include "executing.h"
static struct {{ tml_client client; tml_executing executing; }} kept;
int begun_{samples}(void) {{
  const char *why = "";
  const bool started = tml_executing_start(&kept.executing, TML_SILENCE, false);
  const bool listens = tml_client_datagrams(&kept.client, 9u, &why);
  const bool maps = tml_client_memory(&kept.client, "nowhere", TML_WAIT_SLEEP, &why);
  return (started ? 1 : 0) + (listens ? 2 : 0) + (maps ? 4 : 0) + ((why[0] == 'a') ? 8 : 0);
}}
"""


@pytest.mark.skipif(shutil.which("ar") is None, reason="no ar")
def test_two_clients_that_are_linked_are_told_apart(tmp_path: Path) -> None:
    """As two programs of rules: the linker takes the functions of the first library without a word, and those of the larger client wrote beyond the
    smaller one."""
    spec = tm.loads(SPEC)
    source = generate(spec, list(spec.rules), doored=True)
    main = (
        "int begun_9(void);\nint begun_18(void);\nint main(void) { return begun_9() + (16 * begun_18()); }\n"
    )
    (tmp_path / "main.c").write_text(main)
    for samples in (9, 18):
        made, folder = Emitted(source, asdict(replace(LIMITS, samples=samples))), tmp_path / str(samples)
        folder.mkdir()
        for name, text in {"supervisor.h": source.header, **made.files}.items():
            (folder / name).write_text(text, encoding="utf-8")
        (folder / "host.c").write_text(ITS_OWN.format(samples=samples))
        units = [f"{name}.c" for name in ("messages", "mailbox", "client", "executing")]
        sizes = [f"-D{name}={size}u" for name, size in made.sizes.items()]
        command = [*(compiler() or []), *EXACT, "-O0", *sizes, "-c", *units, "host.c"]
        subprocess.run(command, cwd=folder, check=True)
        objects = [unit.replace(".c", ".o") for unit in units]
        subprocess.run(["ar", "rc", "lib.a", *objects], cwd=folder, check=True)
    ends = []
    for libraries in (["9/lib.a", "18/lib.a"], ["18/lib.a", "9/lib.a"]):
        command = [*(compiler() or []), "main.c", "9/host.o", "18/host.o", *libraries, "-lm", "-o", "made"]
        subprocess.run(command, cwd=tmp_path, check=True)
        ends.append(subprocess.run([tmp_path / "made"], cwd=tmp_path, check=False).returncode)
    # The other one's are refused, and its own are there, but for shared memory that nobody has made.
    assert ends == [16 * 8 + 3, 8 + 16 * 3]


class Sent:
    """A channel that keeps what is sent, in order."""

    def __init__(self) -> None:
        self.kept: list[tuple[str, bytes]] = []

    def send(self, box: str, message: bytearray) -> bool:
        self.kept.append((box, bytes(message)))
        return True

    def receive(self, seconds: float) -> bytes | None:
        return None

    def close(self) -> None:
        pass


class Planner:
    """A client in Python in simulated time, whose messages are handed on one by one."""

    def __init__(self, layout: Layout, session: int = 1000) -> None:
        self.channel, self.now = Sent(), 0.0
        self.client = Client(layout, self.channel, lambda: self.now)
        self.client.session = session
        self.borders = {"left": Border(LEFT), "right": Border(RIGHT), "stop": Border(STOP)}

    def signals(self) -> dict[str, Any]:
        track = {"left": self.borders["left"], "right": self.borders["right"], "closed": False}
        return {
            "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 10.0, "lit": False}, "marks": {"x": [1.0], "v": [2.0]}, "yellow": False,
            "objects": {"id": [7, 8], "x": [50.0, 60.0], "v": [1.0, 2.0]}, "track": track, "stop": self.borders["stop"],
        }  # fmt: skip

    def cycle(self, number: int | None, t: float | None = None, **changes: Any) -> list[tuple[str, bytes]]:
        """What is sent of a cycle: its lines, where they are new, then itself."""
        self.channel.kept.clear()
        if number is not None:
            self.now = number / 10
        plan = {**PLAN, "x": [x + self.now * 10 for x in PLAN["x"]]}
        signals = self.signals()
        signals["ego"]["x"] = self.now * 10
        self.client.send(number, self.now if t is None else t, plan, plan, {**signals, **changes})
        return list(self.channel.kept)

    def tick(self, now: float) -> bytes:
        self.channel.kept.clear()
        self.now = now
        self.client.tick()
        return self.channel.kept[0][1]


class Desk:
    """A Supervisor behind its messages."""

    def __init__(self, c: C, simulated: bool = True) -> None:
        self.c, which = c, ctypes.c_char_p()
        self._memory = ctypes.create_string_buffer(c.dll.probe_desk() + 64)
        self.at = (ctypes.addressof(self._memory) + 63) & ~63
        assert c.dll.tml_desk_start(self.at, 77, simulated, ctypes.byref(which)), which.value

    def take(self, data: bytes, fetch: Any = None) -> tuple[str, Message | None]:
        """Why a message is not taken, or `none`; the decision, where one was made."""
        cause = ctypes.c_int()
        given = FETCH() if fetch is None else fetch
        decided = self.c.dll.tml_desk_take(
            self.at, self.c.room(data), len(data), given, None, ctypes.byref(cause)
        )
        return self.c.layout.causes[cause.value], self.out() if decided else None

    def decided(self, messages: list[tuple[str, bytes]], fetch: Any = None) -> Message:
        """About a cycle, of which all messages are taken."""
        for box, data in messages:
            cause, message = self.take(data, fetch)
            assert (cause, message is None) == ("none", box != "cycle")
        assert message is not None
        return message

    def out(self) -> Message:
        data = ctypes.string_at(self.c.dll.probe_out(self.at), self.c.layout.longest)
        cause, message = self.c.layout.look(data[: int.from_bytes(data[12:16], "little")], up=False)
        assert message is not None, cause
        return message

    def overdue(self) -> Message | None:
        return self.out() if self.c.dll.tml_desk_overdue(self.at) else None

    def beat(self) -> Message:
        self.c.dll.tml_desk_beat(self.at)
        return self.out()

    @property
    def clock(self) -> float:
        found: float = self.c.dll.tml_desk_clock(self.at)
        return found


def faults(message: Message) -> list[str]:
    names = message.layout.faults
    kinds = zip(message["reason_kind"], message["reason_name"])
    return [names[name] for kind, name in list(kinds)[: message["reason_count"]] if kind == 0]


# The desk -------------------------------------------------------------------------------------------------------------


def test_the_clock_of_messages_is_that_of_the_newest_cycle_or_tick(c: C) -> None:
    """It never goes back, lines do not move it, and what is refused does not."""
    desk, planner = Desk(c), Planner(c.layout)
    assert desk.clock < -1e300
    assert desk.overdue() is None
    said = desk.decided(planner.cycle(0))
    assert (desk.clock, said["now"], said["simulated"], said.head.sent) == (0.0, 0.0, 1, 0.0)
    assert desk.take(planner.tick(0.05))[0] == "none"
    assert desk.clock == 0.05
    assert desk.take(planner.tick(0.02))[0] == "none"
    assert desk.clock == 0.05
    line = bytearray(c.layout.kinds["line"].length)
    c.layout.kinds["line"].put(line, "line_version", 9)
    assert desk.take(c.sealed("line", line, 1000, 99, 5.0))[0] == "none"
    assert desk.take(c.sealed("tick", bytearray(48), 999, 99, 6.0))[0] == "session"
    assert desk.take(c.sealed("tick", bytearray(48), 1000, 1, 7.0))[0] == "sequence"
    assert desk.take(c.sealed("tick", bytearray(48), 1000, 99, math.inf))[0] == "content"
    assert desk.clock == 0.05
    real = Desk(c, simulated=False)
    assert abs(real.clock - time.monotonic()) < 5.0
    assert real.overdue() is None
    assert real.beat()["simulated"] == 0


def test_a_cycle_is_overdue_after_its_decision_is_outdated(c: C) -> None:
    """Then that is decided, about no cycle, and again when that one is."""
    desk, planner = Desk(c), Planner(c.layout)
    assert desk.take(planner.tick(-1.0))[0] == "none"
    assert desk.overdue() is None  # nobody has ever sent one
    said = desk.decided(planner.cycle(0))
    until = said["valid_until"]
    assert (said["safe"], until) == (1, 0.15)
    assert desk.take(planner.tick(until))[0] == "none"
    assert desk.overdue() is None
    for now in (math.nextafter(until, 1.0), 0.35):
        assert desk.take(planner.tick(now))[0] == "none"
        missed = desk.overdue()
        assert missed is not None
        assert (missed["about_session"], missed["about_sequence"], missed["number"], missed["wanted"]) == (
            0,
            0,
            0,
            0,
        )
        assert (missed["safe"], missed["driven"], missed["driven_number"], faults(missed)) == (
            0,
            2,
            0,
            ["missing_cycle"],
        )
        assert math.isnan(missed["t"])
        assert missed["fallback/due"][:3].tolist() == PLAN["t"]
        assert desk.overdue() is None
    beat = desk.beat()
    assert (beat["decided"], beat["client"], beat["heard"]) == (3, 1000, planner.client._sequence)
    assert (beat["taken"], beat["state"]) == (8, c.layout.states.index("previous_emergency"))


def test_a_later_client_replaces_an_earlier_one_with_all_that_it_has_said(c: C) -> None:
    """Its messages count from 1, and its lines, too: a cycle of its that names lines of before has none."""
    desk, one, other = Desk(c), Planner(c.layout), Planner(c.layout, 1001)
    said = desk.decided(one.cycle(0))
    assert (said["about_session"], said["about_sequence"], said["safe"]) == (1000, 4, 1)
    *lines, (_, cycle) = other.cycle(1)
    said = desk.decided([("cycle", cycle)])  # its lines were lost
    assert (said["about_session"], said["safe"], said["wanted"]) == (1001, 0, 0b111)
    assert faults(said).count("bad_border") == 3
    for _, data in one.cycle(2):
        assert desk.take(data) == ("session", None)
    for _, data in lines:  # they may come after it
        assert desk.take(data) == ("none", None)
        assert desk.take(data) == ("sequence", None)
    assert desk.take(cycle) == ("sequence", None)
    said = desk.decided(other.cycle(2))
    assert (said["safe"], said["wanted"]) == (1, 0)
    beat = desk.beat()
    assert (beat["client"], beat["heard"]) == (1001, 5)
    refused = dict(zip(c.layout.causes, beat["refused"].tolist()))
    assert {cause: n for cause, n in refused.items() if n} == {"session": 1, "sequence": 4}


def test_a_cycle_has_the_lines_of_its_own_client_or_none(c: C) -> None:
    """Not one of before where it names none, nor that of a client that replaces its own while it is decided about, though their versions are alike."""
    desk, one, other = Desk(c), Planner(c.layout), Planner(c.layout, 1001)
    assert desk.decided(one.cycle(0))["safe"] == 1
    said = desk.decided(other.cycle(1, stop=None, track={"left": other.borders["left"]}))
    assert (said["safe"], said["wanted"], sorted(faults(said))) == (0, 0, ["bad_border", "missing"])
    lines = dict(enumerate(data for _, data in Planner(c.layout, 1002).cycle(2)[:-1]))

    def fetch(_: Any, slot: int, into: int, size: Any) -> bool:
        ctypes.memmove(into, lines[slot], len(lines[slot]))
        size[0] = len(lines[slot])
        return True

    other.client._forget(0b111)
    other.client._versions = [0, 0, 0]
    *_, cycle = other.cycle(2)
    said = desk.decided([cycle], FETCH(fetch))
    assert (said["about_session"], said["safe"], said["wanted"]) == (
        1001,
        0,
        0b110,
    )  # its left border had come before
    assert desk.beat()["client"] == 1002
    missed = desk.overdue() if desk.take(Planner(c.layout, 1002).tick(1.0))[0] == "none" else None
    assert missed is not None
    assert missed["wanted"] == 0  # of no cycle


def test_another_line_in_a_slot_is_looked_at(c: C) -> None:
    """What was prepared for the one before is not taken for it, though it has as many points."""
    desk, planner = Desk(c), Planner(c.layout)
    assert desk.decided(planner.cycle(0))["safe"] == 1
    for number, (name, points) in enumerate((("left", LEFT), ("right", RIGHT), ("stop", STOP)), start=1):
        planner.borders[name] = Border([[x, y * 0.1] if name != "stop" else [x - 73.0, y] for x, y in points])
        messages = planner.cycle(number)
        assert [box for box, _ in messages] == [f"line_{number - 1}", "cycle"]
        said = desk.decided(messages)
        rules = said.layout.rules
        wrong = [rules[i] for i, verdict in enumerate(said["driving_verdict"][: len(rules)]) if verdict != 0]
        assert (said["safe"], wrong) == (0, ["before" if name == "stop" else "beside"]), name
        planner.borders[name] = Border(points)
        desk.decided(planner.cycle(number))  # of a number that was
    planner.borders["left"] = Border([*LEFT, [91.0, 6.0], [92.0, 6.0], [93.0, 6.0]])
    assert faults(desk.decided(planner.cycle(4))) != []


def test_a_line_that_is_not_known_is_fetched(c: C) -> None:
    """Of its slot, and of no other one; once, and not where it is known."""
    desk, planner = Desk(c), Planner(c.layout)
    *lines, cycle = planner.cycle(0)
    asked: list[int] = []
    given = dict(enumerate(data for _, data in lines))

    def fetch(_: Any, slot: int, into: int, size: Any) -> bool:
        asked.append(slot)
        if slot in given:
            ctypes.memmove(into, given[slot], len(given[slot]))
            size[0] = len(given[slot])
        return slot in given

    said = desk.decided([cycle], FETCH(fetch))
    assert (said["safe"], said["wanted"], asked) == (1, 0, [0, 1, 2])
    asked.clear()
    assert desk.decided(planner.cycle(1), FETCH(fetch))["safe"] == 1
    assert asked == []
    planner.client._forget(0b111)
    *lines, cycle = planner.cycle(2)
    # Of another slot; something else; nothing.
    given = {0: lines[1][1], 1: planner.tick(0.2)}
    said = desk.decided([cycle], FETCH(fetch))
    assert (said["safe"], said["wanted"], asked) == (0, 0b111, [0, 1, 2])
    beat = desk.beat()
    assert beat["refused"][c.layout.causes.index("kind")] == 2


@pytest.mark.parametrize(
    ("entry", "value", "expected"),
    [
        ("came", 0, ("missing_cycle", "cycle", "")), ("numbered", 0, ("missing", "cycle", "number")), ("stamped", 0, ("missing", "cycle", "t")),
        ("driving/present", 0, ("missing", "driving", "")), ("emergency/present", 0, ("missing", "emergency", "")),
        ("driving/absent", 1 << 4, ("missing", "driving", "v")), ("emergency/absent", 1, ("missing", "emergency", "t")),
        ("signals.objects/absent", 1 << 1, ("missing", "objects", "v")), ("signals.objects/named", 0, ("missing", "objects", "id")),
        ("signals.objects/present", 0, ("missing", "objects", "")), ("signals.marks/present", 0, ("missing", "marks", "")),
        ("signals.marks/absent", 1 << 0, ("missing", "marks", "x")), ("signals.ego/present", 0, ("missing", "ego", "")),
        ("signals.ego.lit", -1, ("not_finite", "ego", "lit")), ("signals.yellow/event", -1, ("not_finite", "yellow", "")),
        ("signals.stop/present", 0, ("missing", "stop", "")), ("signals.track/present", 0, ("missing", "track", "")),
        ("driving/count", 9, ("over_capacity", "driving", "")), ("signals.objects/count", 4, ("over_capacity", "objects", "")),
        ("signals.marks/count", 9, ("over_capacity", "marks", "")),
    ],
)  # fmt: skip
def test_what_a_message_does_not_have_is_a_fault(
    entry: str, value: int, expected: tuple[str, str, str], c: C
) -> None:
    """Whatever else stands there: columns that are absent, and what belongs to a signal that is not there, are not read."""
    desk, planner, kind = Desk(c), Planner(c.layout), c.layout.kinds["cycle"]
    *lines, (_, cycle) = planner.cycle(0)
    message = bytearray(cycle)
    kind.put(message, entry, value)
    if entry == "signals.stop/present":  # what is not there is not asked for
        kind.put(message, "signals.stop.line", 99)
    said = desk.decided([*lines, ("cycle", c.sealed("cycle", message, 1000, 9, 0.0))])
    layout = c.layout
    found = [
        (layout.faults[said["reason_name"][i]], layout.signals[said["reason_signal"][i]], layout.fields[said["reason_field"][i]])
        for i in range(said["reason_count"]) if said["reason_kind"][i] == 0
    ]  # fmt: skip
    assert (said["safe"], said["wanted"]) == (0, 0)
    assert expected in found
    assert found == [expected]


@pytest.mark.parametrize("narrow", [False, True])
@pytest.mark.parametrize(
    ("box", "entry"), [("cycle", "driving/count"), ("cycle", "signals.objects/count"), ("line_2", "count")]
)
def test_more_than_a_process_of_32_bits_can_count_is_too_much(box: str, entry: str, narrow: bool) -> None:
    """Of a planner with 64 bits, as many as fit were taken, and the cycle was safe."""
    c = C(narrow)
    desk, planner = Desk(c), Planner(c.layout)
    sent = []
    for name, data in planner.cycle(0):
        message, kind = bytearray(data), "cycle" if name == "cycle" else "line"
        if name == box:
            count = c.layout.kinds[kind].get(message, entry)
            c.layout.kinds[kind].put(message, entry, count + (1 << 32))
        sequence = int.from_bytes(data[32:40], "little")
        sent.append((name, c.sealed(kind, message, 1000, sequence, 0.0)))
    said = desk.decided(sent)
    assert (said["safe"], "over_capacity" in faults(said)) == (0, True)


def test_a_decision_is_about_the_cycle_as_it_was_numbered_and_stamped(c: C) -> None:
    desk, planner, kind = Desk(c), Planner(c.layout), c.layout.kinds["cycle"]
    said = desk.decided(planner.cycle(7, t=0.68))
    assert (said["number"], said["t"], said["now"], said["safe"]) == (7, 0.68, 0.7, 1)
    for group in ("driving", "fallback"):
        assert said.due(group).tolist() == [t + 0.68 for t in PLAN["t"]]
    for k, (number, stamp) in enumerate(((0, 1), (1, 0))):
        message = bytearray(planner.cycle(8)[-1][1])
        kind.put(message, "numbered", number)
        kind.put(message, "stamped", stamp)
        said = desk.decided([("cycle", c.sealed("cycle", message, 1000, 50 + k, 0.8))])
        assert said["number"] == (8 if number else 0)
        assert said["t"] == 0.8 if stamp else math.isnan(said["t"])


def test_samples_that_a_large_stamp_moves_to_one_time_are_decided_about(c: C) -> None:
    """The decision can be read, and is executed: whoever drives fell back from what is safe."""
    desk, planner = Desk(c), Planner(c.layout)
    planner.now = 1e6
    planner.channel.kept.clear()
    times = [0.0, 2.0, 2.0 + 1e-11]
    plan = {**PLAN, "t": times, "x": [1e7 + x for x in (0.0, 10.0, 10.0)]}
    signals = planner.signals()
    signals["ego"]["x"] = 1e7
    planner.client.send(1, planner.now, plan, plan, signals)
    said = desk.decided(list(planner.channel.kept))
    assert said["safe"] == 1
    for group in ("driving", "fallback"):
        assert said.due(group).tolist() == [1e6, 1e6 + 2.0, 1e6 + 2.0]
    executing = Executing(c.layout, simulated=True)
    assert executing.hear(bytes(said.data)) == "none"
    assert executing.at(1e6).action == "drive"


def test_faults_of_a_sender_keep_their_names(c: C) -> None:
    desk, planner = Desk(c), Planner(c.layout)
    planner.channel.kept.clear()
    given = [("not_finite", "ego", "lit", 3), ("missing", "nobody", "nothing", None)]
    planner.client.send(None, None, None, None, {}, given, came=False)
    said = desk.decided(planner.channel.kept)
    layout = c.layout
    found = {
        (layout.faults[said["reason_name"][i]], said["reason_signal"][i], said["reason_field"][i], said["reason_index"][i])
        for i in range(said["reason_count"])
    }  # fmt: skip
    assert ("not_finite", layout.signals.index("ego"), layout.fields.index("lit"), 3) in found
    assert ("missing", len(layout.signals), len(layout.fields), -1) in found
    assert (said["safe"], said["number"], math.isnan(said["t"])) == (0, 0, True)


# What can stand in a message --------------------------------------------------------------------------------------------


Edge = tuple[str, str, int, Any, Any, dict[str, int]]


def _edges(c: C) -> Iterator[Edge]:
    """Kind, entry, place in it, a value that can be, one that cannot, and what stands beside it: so that nothing else is wrong."""
    layout = c.layout
    most, rules, states, unsafe = len(layout.faults), len(layout.rules), len(layout.states), {"safe": 0}
    for name in ("came", "numbered", "stamped", "driving/present", "emergency/present", "signals.ego/present", "signals.objects/present",
                 "signals.marks/present", "signals.track/present", "signals.track/closed", "signals.stop/present"):  # fmt: skip
        yield "cycle", name, 0, 1, 2, {}
    yield "line", "slot", 0, len(layout.lines) - 1, len(layout.lines), {}
    yield "line", "line_version", 0, 1, 0, {}
    yield "beat", "simulated", 0, 1, 2, {}
    for kind, name, good, bad, beside in (
        ("cycle", "found_count", 65, 66, {}), ("beat", "state", states - 1, states, {}), ("beat", "state", 0, -1, {}),
        ("decision", "state", states - 1, states, {}), ("decision", "state", 0, -1, {}), ("decision", "simulated", 1, 2, {}),
        ("decision", "driven", 2, 3, unsafe), ("decision", "driven", 0, -1, unsafe), ("decision", "driven", 0, 1, unsafe),
        ("decision", "safe", 1, 0, {}), ("decision", "safe", 0, 2, {"driven": 0}), ("decision", "safe", 0, -1, {"driven": 0}),
        ("decision", "safe", 0, 1, {"driven": 2}), ("decision", "stored", 1, 0, {}), ("decision", "stored", 1, 0, {"driven": 2, **unsafe}),
        ("decision", "stored", 1, 2, {"driven": 0, **unsafe}), ("decision", "stored", 0, -1, {"driven": 0, **unsafe}),
        ("decision", "about_sequence", 1, 0, {}), ("decision", "reason_count", 64, 65, {}), ("decision", "reason_count", 0, -1, {}),
        ("decision", "lost", most - 1, most, {}), ("decision", "lost", 0, -1, {}), ("decision", "serial", 1, 0, {}),
        ("decision", "driving/count", 2, 1, {}), ("decision", "driving/count", 8, 9, {}), ("decision", "fallback/count", 2, 1, {}),
        ("decision", "fallback/count", 8, 9, {"driven": 2, **unsafe}),
    ):  # fmt: skip
        yield kind, name, 0, good, bad, beside
    for kind, name, place, good, bad in (
        ("cycle", "found_name", 64, most - 1, most), ("cycle", "found_name", 64, 1, 0), ("cycle", "found_index", 64, -1, -2),
        ("decision", "reason_kind", 63, 2, 3), ("decision", "reason_candidate", 63, 1, 2), ("decision", "reason_name", 63, most - 1, most),
        ("decision", "reason_rule", 63, rules - 1, rules), ("decision", "driving_verdict", rules - 1, 4, 5),
        ("decision", "emergency_verdict", rules - 1, 4, 5),
    ):  # fmt: skip
        yield kind, name, place, good, bad, {}
    for group in ("driving", "fallback"):
        for place, due, bad_due in (
            (7, -2.0, -2.5),
            (7, 9e8, 1e9 - 2.0),
            (7, -1.0, math.inf),
            (0, -9.0, math.nan),
            (0, -7.0, -6.5),
        ):
            yield "decision", f"{group}/due", place, due, bad_due, {}


def test_c_and_python_draw_the_same_line(c: C) -> None:
    """Of every entry that can be wrong, a value that is taken, and the next one, which is not."""
    layout = c.layout
    for name, entry, place, good, bad, beside in _edges(c):
        kind = layout.kinds[name]
        for value, sound in ((good, True), (bad, False)):
            message = bytearray(kind.length)
            if name == "cycle":
                kind.put(message, "found_count", 65)
                for one in ("found_name", "found_signal"):  # what is behind the last name would do as one
                    kind.put(message, one, [1] * 65)
            if name == "line":
                kind.put(message, "line_version", 1)
            if name == "decision":
                kind.put(message, "reason_count", 64)
                for group in ("driving", "fallback"):
                    kind.put(message, f"{group}/count", 8)
                    kind.put(
                        message, f"{group}/due", [k - 8.0 for k in range(8)]
                    )  # the number behind them would do as one
                for one in ("safe", "driven", "stored", "serial", "about_sequence"):
                    kind.put(message, one, beside.get(one, 1))
            if kind.entries[entry].array:
                whole = list(kind.get(message, entry))
                whole[place] = value
                kind.put(message, entry, whole)
            else:
                kind.put(message, entry, value)
            data = c.sealed(name, message, 1, 1, 0.0)
            assert c.dll.tml_look(c.room(data), len(data), kind.up) == 0
            assert (c.dll.tml_sound(c.room(data)) == 0) is sound, (name, entry, value, beside)
            if not kind.up:
                assert (layout.look(data, up=False)[0] == "none") is sound, (name, entry, value, beside)


def test_what_is_no_message(c: C) -> None:
    """It has a whole head, is as long as that says, which is as long as its kind is, and nothing in it was changed."""
    kind = c.layout.kinds["tick"]
    data = c.sealed("tick", bytearray(kind.length), 1, 1, 0.0)

    def look(given: bytes, up: bool = True) -> str:
        cause: str = c.layout.causes[c.dll.tml_look(c.room(given), len(given), up)]
        assert cause == c.layout.look(given, up)[0]
        return cause

    given = [look(data), look(data, False), look(data[:-1]), look(data + b"\0"), look(b"")]
    assert given == ["none", "kind", "size", "size", "size"]
    for place, cause in (
        (0, "magic"),
        (4, "crc"),
        (8, "version"),
        (10, "kind"),
        (12, "length"),
        (16, "layout"),
        (24, "crc"),
        (47, "crc"),
    ):
        changed = bytearray(data)
        changed[place] ^= 64
        assert look(bytes(changed)) == cause
    longer = bytearray(data + bytes(8))
    longer[12] += 8  # as long as it says, and of no kind
    assert look(bytes(longer)) == "length"


@pytest.mark.parametrize(
    ("session", "sequence", "sent"), [(0, 1, 0.0), (1, 0, 0.0), (1, 1, math.nan), (1, 1, -math.inf)]
)
def test_a_sender_has_a_session_a_count_and_a_clock(session: int, sequence: int, sent: float, c: C) -> None:
    for name in ("tick", "beat"):
        data = c.sealed(name, bytearray(c.layout.kinds[name].length), session, sequence, sent)
        assert c.dll.tml_look(c.room(data), len(data), name == "tick") == 0
        assert c.layout.causes[c.dll.tml_sound(c.room(data))] == "content"
        assert name == "tick" or c.layout.look(data, up=False)[0] == "content"


def test_a_crc_is_that_of_zlib(c: C) -> None:
    """Of any number of bytes, and going on from what stood before them."""
    data = bytes(range(3, 40))
    for count in range(len(data)):
        assert c.dll.tml_crc(0, data, count) == zlib.crc32(data[:count])
        assert c.dll.tml_crc(0x1234_5678, data, count) == zlib.crc32(data[:count], 0x1234_5678)


@pytest.mark.parametrize("real", [True, False])
def test_decisions_in_simulated_time_and_those_of_a_car_are_told_apart_in_c_too(real: bool, c: C) -> None:
    """A car takes none that somebody simulates, nor a sign of life, and takes its own; and the other way round."""
    desk, planner = Desk(c, simulated=not real), Planner(c.layout)
    *_, cycle = planner.cycle(0)
    said = [desk.take(cycle[1])[1], desk.beat()]
    memory = ctypes.create_string_buffer(c.dll.probe_executing() + 64)
    at = (ctypes.addressof(memory) + 63) & ~63
    for car in (True, False):
        own = c.layout.fingerprint, c.dll.probe_executing()
        assert c.dll.tml_executing_start_of(at, *own, c.layout.silence, not car)
        python = Executing(c.layout, simulated=not car)
        for message in said:
            assert message is not None
            cause = c.layout.causes[c.dll.tml_executing_hear(at, c.room(message.data), len(message.data))]
            assert cause == python.hear(bytes(message.data)) == ("none" if car == real else "content")


# Mailboxes --------------------------------------------------------------------------------------------------------------


class Memory(ctypes.Structure):
    """A tml_region."""

    _fields_ = [("memory", ctypes.c_void_p), ("size", ctypes.c_size_t)]


def opened(c: C, path: Path, make: bool = False, writing: bool = False) -> tuple[Memory | None, str]:
    """A file of cycles in memory; why not, where it is none."""
    region, why = Memory(), ctypes.c_char_p()
    found = c.dll.tml_region_open(
        ctypes.byref(region), bytes(path), c.sizes["cycles"], make, writing, ctypes.byref(why)
    )
    return region if found else None, (why.value or b"").decode()


OTHER = "is for another spec, other rules, capacities or limits, of another engine, or is none of ours"


def test_a_file_of_something_else_is_replaced_and_never_opened(c: C, tmp_path: Path) -> None:
    """By its magic, version, layout or size, or where it is shorter or longer; whoever has the other one mapped keeps it."""
    path = tmp_path / "one.cycles"
    assert opened(c, path) == (None, "cannot be opened: no Supervisor has made it")
    (tmp_path / "one.cycles.new").write_bytes(b"left behind by one that was killed")
    made, _ = opened(c, path, make=True)
    assert made is not None
    whole = path.read_bytes()
    assert (len(whole), sorted(os.listdir(tmp_path))) == (c.sizes["cycles"], ["one.cycles"])
    for place in (0, 4, 8, 16):
        spoilt = bytearray(whole)
        spoilt[place] ^= 1
        others = [bytes(spoilt)] if place else [bytes(spoilt), whole[:-1], whole + b"\0", b""]
        for other in others:
            path.write_bytes(other)
            kept = os.open(path, os.O_RDONLY)
            assert opened(c, path) == opened(c, path, writing=True) == (None, OTHER)
            assert opened(c, path, make=True)[0] is not None
            assert (path.read_bytes(), os.pread(kept, len(other) + 1, 0)) == (whole, other)
            os.close(kept)
    inode = path.stat().st_ino
    for writing, rights in ((False, "r--s"), (True, "rw-s")):
        region, _ = opened(c, path, make=True, writing=writing)
        assert region is not None
        assert path.stat().st_ino == inode  # one that fits stays
        begin = f"{region.memory:x}-"
        assert (
            next(
                line.split()[1]
                for line in Path("/proc/self/maps").read_text().splitlines()
                if line.startswith(begin)
            )
            == rights
        )


@pytest.fixture
def boxed(c: C, tmp_path: Path) -> tuple[Memory, Region]:
    """A file that C writes, as Python reads it."""
    region, _ = opened(c, tmp_path / "one.cycles", make=True, writing=True)
    assert region is not None
    return region, Region(c.layout, "cycles", str(tmp_path / "one.cycles"), False)


def test_a_message_is_whole_before_it_is_the_newest(c: C, boxed: tuple[Memory, Region]) -> None:
    """Of each, in its slot: first an odd turn, then what it says, then its even turn, and the bell."""
    region, reading = boxed
    box, at = reading._boxes["tick"], c.box("cycles", "tick")
    seen: list[tuple[int, int, bytes]] = []

    def look() -> None:
        following = reading.latest("tick") + 1
        slot = box["first"] + following % box["slots"] * box["step"]
        seen.append((following, reading._words[slot // 8], bytes(reading._bytes[slot + 64 : slot + 112])))

    before = [bytes(48), bytes(48)]
    for k in range(1, 6):
        kept, message = c.hooked(look), bytes([k]) * 48
        c.dll.tml_put(ctypes.byref(region), at, c.room(message))
        c.hooked(None)
        assert kept is not None
        assert seen.pop() == (k, 2 * k - 1, before[k % 2])
        assert (reading.latest("tick"), reading.heard) == (k, k)
        assert reading.get("tick", k - 1) == (k, message)
        before[k % 2] = message
    assert seen == []


def test_the_newest_message_is_whole_at_any_time_and_the_bell_rings_last(
    c: C, boxed: tuple[Memory, Region]
) -> None:
    """Who looked between two words saw a message that was not whole yet, or slept on as it came: it was lost, or as late as the next one."""
    region, reading = boxed
    box, at, seen = reading._boxes["tick"], c.box("cycles", "tick"), list[tuple[bool, int]]()

    def look() -> None:
        newest = reading.latest("tick")
        turn = reading._words[(box["first"] + newest % box["slots"] * box["step"]) // 8]
        seen.append((turn == 2 * newest, newest - reading.heard))

    kept = c.hooked(look, "probe_stored")
    for k in range(1, 4):
        c.dll.tml_put(ctypes.byref(region), at, c.room(bytes([k]) * 48))
    c.hooked(None, "probe_stored")
    assert kept is not None
    # The odd turn, six words, the even turn, which of them is the newest, and the bell: what came before each.
    assert seen == [*[(True, 0)] * 9, (True, 1)] * 3
    reading.close()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere, nobody sleeps")
@pytest.mark.parametrize("c_sleeps", [True, False])
def test_whoever_sleeps_is_woken(c_sleeps: bool, c: C, boxed: tuple[Memory, Region], tmp_path: Path) -> None:
    """Without a wake, every cycle waited until the process looked by itself: nothing was wrong but the time that it took."""
    region, reading = boxed

    def slept() -> float:
        asleep, over = threading.Event(), list[float]()

        def sleep() -> None:
            heard, begin = reading.heard, time.monotonic()
            asleep.set()
            if c_sleeps:
                c.dll.tml_wait(ctypes.byref(region), ctypes.c_uint32(heard), ctypes.c_double(1.0), 0)
            else:
                reading.wait(heard, 1.0)
            over.append(time.monotonic() - begin)

        sleeper = threading.Thread(target=sleep)
        sleeper.start()
        asleep.wait()
        time.sleep(0.1)
        if c_sleeps:  # which Python wakes
            with closing(Region(c.layout, "cycles", str(tmp_path / "one.cycles"), True)) as writing:
                writing.put("tick", bytearray(48))
        else:
            c.dll.tml_put(ctypes.byref(region), c.box("cycles", "tick"), c.room(bytes(48)))
        sleeper.join()
        return over[0]

    # Whoever is to wake may come late where much else runs.
    assert any(0.05 < slept() < 0.9 for _ in range(4))
    reading.close()


@pytest.mark.parametrize(
    ("machine", "bits", "number"),
    [
        # As the kernel's tables of system calls have it; most of a machine of 64 bits run processes of 32.
        ("x86_64", 64, 202), ("x86_64", 32, 240), ("i686", 32, 240), ("aarch64", 64, 98), ("aarch64", 32, 240), ("armv7l", 32, 240),
        ("riscv64", 64, 98), ("ppc64le", 64, 221), ("riscv32", 32, None), ("mips64", 64, None),
    ],
)  # fmt: skip
def test_a_process_sleeps_by_the_call_of_its_own_bits(
    machine: str, bits: int, number: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python of 32 bits on a kernel of 64, as on many a Raspberry Pi, called what has this number there: nobody was woken, and who waited looked all the time."""
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(sys, "maxsize", 2 ** (bits - 1) - 1)
    monkeypatch.setattr("platform.machine", lambda: machine)
    assert shared_memory._futex() == number


def test_what_is_written_while_it_is_read_is_not_taken(
    c: C, boxed: tuple[Memory, Region], tmp_path: Path
) -> None:
    region, reading = boxed
    writing = Region(c.layout, "cycles", reading.path, True)
    box, at = reading._boxes["tick"], c.box("cycles", "tick")
    into, seen, cause = c.room(), ctypes.c_uint64(), ctypes.c_int()

    def get() -> tuple[bool, int, str, bytes]:
        found = c.dll.tml_get(ctypes.byref(region), at, ctypes.byref(seen), into, ctypes.byref(cause))
        return found, seen.value, c.layout.causes[cause.value], into.raw[:1]

    assert get()[:3] == (False, 0, "none")
    writing.put("tick", bytearray(b"a" * 48))
    assert get() == (True, 1, "none", b"a")
    assert get()[:3] == (False, 1, "none")
    for letter in b"bcd":
        writing.put("tick", bytearray([letter] * 48))
    assert get() == (True, 4, "none", b"d")  # the newest one

    # While it is copied, two more come, of which the second one takes its slot: that one is the message.
    writing.put("tick", bytearray(b"e" * 48))
    more = [bytearray(b"f" * 48), bytearray(b"g" * 48)]

    def write() -> None:
        while more:
            writing.put("tick", more.pop(0))

    kept = c.hooked(write)
    assert get() == (True, 7, "none", b"g")
    c.hooked(None)
    assert kept is not None

    # One that says that it is the newest and is not whole: not taken, and not looked at again until another one comes.
    slot = (box["first"] + 8 % box["slots"] * box["step"]) // 8
    for turn in (15, 17, 14, 2 * 8 + 2 * box["slots"]):
        seen.value = 7
        writing._words[box["place"] // 8], writing._words[slot] = 8, turn
        assert get()[:3] == (False, 8, "torn")
        assert get()[:3] == (False, 8, "none")
    writing.put("tick", bytearray(b"i" * 48))
    assert get() == (True, 9, "none", b"i")
    writing.close()
    reading.close()


@pytest.mark.parametrize("look", [0, 1, 2, 3])
def test_a_tick_that_follows_a_cycle_does_not_overtake_it(look: int, c: C, tmp_path: Path) -> None:
    """Whenever both come between two looks of the process: the cycle was refused then, as one that is not newer than the tick."""
    planner, looks, writing = Planner(c.layout), list[int](), list[Region]()

    def looked() -> None:
        looks.append(len(looks))
        if looks[-1] == look:
            writing.append(Region(c.layout, "cycles", str(tmp_path / "one.cycles"), True))
            for box, data in [*planner.cycle(0), ("tick", planner.tick(0.0))]:
                writing[0].put(box, bytearray(data))
        if looks[-1] == look + 6:
            c.dll.probe_end()

    kept = c.hooked(looked, "probe_looked")
    assert c.dll.probe_serve(bytes(tmp_path / "one"))
    assert kept is not None
    reading = Region(c.layout, "decisions", str(tmp_path / "one.decisions"), False)
    found = [c.layout.look(reading.get(box, 0)[1] or b"", up=False)[1] for box in ("decision", "beat")]
    assert found[0] is not None
    assert found[1] is not None
    assert (found[0]["about_sequence"], found[0]["safe"]) == (4, 1)
    assert (found[1]["heard"], sum(found[1]["refused"])) == (5, 0)
    reading.close()
    writing[0].close()


# The client -------------------------------------------------------------------------------------------------------------


def _structure(*fields: tuple[str, Any]) -> type[ctypes.Structure]:
    return type("Made", (ctypes.Structure,), {"_fields_": list(fields)})


P, N = ctypes.c_void_p, ctypes.c_size_t
Points = _structure(("points", P), ("count", N), ("id", ctypes.c_uint64))
Plan = _structure(("count", N), *((name, P) for name in PLAN))
Ego = _structure(*((name, ctypes.c_double) for name in ("x", "y", "heading", "v")), ("lit", ctypes.c_byte))
Objects = _structure(("count", N), ("id", P), ("x", P), ("v", P), ("shy", P))
Marks = _structure(("count", N), ("x", P), ("v", P))
Track = _structure(("left", Points), ("right", Points), ("closed", ctypes.c_bool))
Stop = _structure(("line", Points))
Fault = _structure(
    ("name", ctypes.c_int), ("signal", ctypes.c_char_p), ("field", ctypes.c_char_p), ("index", N)
)
CCycle = _structure(
    ("came", ctypes.c_bool), ("numbered", ctypes.c_bool), ("stamped", ctypes.c_bool), ("number", ctypes.c_int64), ("t", ctypes.c_double),
    ("now", ctypes.c_double), ("driving", P), ("emergency", P), ("ego", P), ("objects", P), ("marks", P), ("track", P), ("stop", P),
    ("yellow", ctypes.c_byte), ("found", P), ("found_count", N),
)  # fmt: skip
NOWHERE = 2 ** (8 * ctypes.sizeof(N)) - 1


class CClient:
    """A client in C, its Supervisor's files without a Supervisor, and what it sends, as Python reads it."""

    def __init__(self, c: C, folder: Path) -> None:
        self.c, self._alive = c, list[Any]()
        name, why = folder / "one", ctypes.c_char_p()
        for file, size in c.sizes.items():
            region = Memory()
            assert c.dll.tml_region_open(
                ctypes.byref(region), bytes(folder / f"one.{file}"), size, True, True, ctypes.byref(why)
            )
        self._memory = ctypes.create_string_buffer(c.dll.probe_client() + 64)
        self.at = (ctypes.addressof(self._memory) + 63) & ~63
        self.decisions = Region(c.layout, "decisions", f"{name}.decisions", True)
        self.cycles = Region(c.layout, "cycles", f"{name}.cycles", False)
        self.seen = dict.fromkeys(("line_0", "line_1", "line_2", "cycle", "tick"), 0)

    def connect(self) -> None:
        why = ctypes.c_char_p()
        path = self.cycles.path.removesuffix(".cycles").encode()
        own = self.c.layout.fingerprint, self.c.dll.probe_client()
        assert self.c.dll.tml_client_memory_of(self.at, *own, path, 1, ctypes.byref(why)), why.value
        self.c.dll.tml_client_time(self.at, 0.25)

    def column(self, values: Any, kind: Any = ctypes.c_double) -> int | None:
        """Where C has values; None for none."""
        if values is None:
            return None
        self._alive.append((kind * max(1, len(values)))(*values))
        return ctypes.addressof(self._alive[-1])

    def part(self, kind: Any, *values: Any) -> int:
        self._alive.append(kind(*values))
        return ctypes.addressof(self._alive[-1])

    def plan(self, count: int = 3, **changes: Any) -> int:
        return self.part(Plan, count, *(self.column(column) for column in {**PLAN, **changes}.values()))

    def points(self, points: Any, id_: int, count: int | None = None) -> Any:
        flat = None if points is None else [one for row in points for one in row]
        return Points(self.column(flat), len(points or ()) if count is None else count, id_)

    def given(self, **changes: Any) -> dict[str, Any]:
        return {
            "came": True, "numbered": True, "stamped": True, "number": 5, "t": 0.5, "driving": self.plan(), "emergency": self.plan(),
            "ego": self.part(Ego, 0.0, 1.0, 2.0, 10.0, 0), "marks": self.part(Marks, 1, self.column([1.0]), self.column([2.0])),
            "objects": self.part(Objects, 2, self.column([7, 8], ctypes.c_uint64), self.column([50.0, 60.0]), self.column([1.0, 2.0]),
                                 self.column([0, 1], ctypes.c_byte)),
            "track": self.part(Track, self.points(LEFT, 1), self.points(RIGHT, 2), True), "stop": self.part(Stop, self.points(STOP, 3)),
            "yellow": 0, **changes,
        }  # fmt: skip

    def send(self, **changes: Any) -> dict[str, Message]:
        """What is sent of a cycle, by mailbox."""
        cycle = CCycle(**self.given(**changes))
        assert self.c.dll.tml_client_send(self.at, ctypes.byref(cycle)) > 0
        return self.sent()

    def sent(self) -> dict[str, Message]:
        found = {}
        for box, seen in self.seen.items():
            self.seen[box], data = self.cycles.get(box, seen)
            if data is not None:
                cause, message = self.c.layout.look(data, up=True)
                assert message is not None, cause
                found[box] = message
        return found

    def hear(self) -> bool:
        size = N()
        found: bool = self.c.dll.tml_client_hear(self.at, self.c.room(), ctypes.byref(size))
        return found

    def refused(self, cause: str) -> int:
        return int(self.c.dll.probe_refused(self.at, self.c.layout.causes.index(cause)))


@pytest.fixture
def planner(c: C, tmp_path: Path) -> Iterator[CClient]:
    made = CClient(c, tmp_path)
    made.connect()
    yield made
    c.dll.tml_client_close(made.at)
    made.cycles.close()
    made.decisions.close()


def test_c_and_python_send_the_same(planner: CClient) -> None:
    """Of what is there, and of what is not: absent columns, sets without ids, signals that are missing, lines without points, events."""
    layout, x, y = planner.c.layout, planner.column, Planner(planner.c.layout)
    objects = {"id": [7, 8], "x": [50.0, 60.0], "v": [1.0, 2.0], "shy": [False, True]}
    track = {"left": Border(LEFT), "right": Border(RIGHT), "closed": True}
    plain: dict[str, Any] = {
        "ego": {"x": 0.0, "y": 1.0, "heading": 2.0, "v": 10.0, "lit": False}, "marks": {"x": [1.0], "v": [2.0]}, "objects": objects, "track": track,
        "stop": Border(STOP), "yellow": False,
    }  # fmt: skip
    ids, a, b, shy = x([7, 8], ctypes.c_uint64), x([50.0, 60.0]), x([1.0, 2.0]), x([0, 1], ctypes.c_byte)
    without, many = {**PLAN, "v": None}, [float(k) for k in range(1, 40)]
    driving: Any
    signals: dict[str, Any]
    for changes, driving, signals in (
        ({}, PLAN, {}),
        ({"driving": None}, None, {}),
        ({"driving": planner.plan(v=None)}, without, {}),
        ({"objects": planner.part(Objects, 2, None, a, b, shy)}, PLAN, {"objects": {k: v for k, v in objects.items() if k != "id"}}),
        ({"objects": planner.part(Objects, 2, ids, None, b, shy)}, PLAN, {"objects": {**objects, "x": None}}),
        ({"objects": planner.part(Objects, 2, ids, a, b, None)}, PLAN, {"objects": {**objects, "shy": None}}),
        ({"objects": None, "marks": None}, PLAN, {"objects": None, "marks": None}),
        ({"yellow": 1}, PLAN, {"yellow": True}),
        ({"yellow": -1}, PLAN, {"yellow": None}),
        ({"track": planner.part(Track, planner.points(LEFT, 1), planner.points(None, 0), False)}, PLAN, {"track": {"left": track["left"]}}),
        ({"stop": None}, PLAN, {"stop": None}),
        ({"numbered": False, "stamped": False, "number": 0, "t": 0.0}, PLAN, {}),
        ({"driving": planner.plan(x=None, v=None)}, {**PLAN, "x": None, "v": None}, {}),
        ({"came": False}, PLAN, {}),
        # Of more than there is room for, nothing is written behind it.
        ({"driving": planner.plan(9, **dict.fromkeys(PLAN, many)), "emergency": None}, dict.fromkeys(PLAN, many[:9]), {}),
        ({"objects": planner.part(Objects, 5, x(range(1, 40), ctypes.c_uint64), x(many), x(many), x([1] * 40, ctypes.c_byte)), "marks": None}, PLAN,
         {"objects": {"id": range(1, 6), "x": many[:5], "v": many[:5], "shy": [True] * 5}, "marks": None}),
    ):  # fmt: skip
        y.channel.kept.clear()
        whole: dict[str, Any] = {"numbered": True, "came": True, "emergency": PLAN, **changes}
        numbered = whole["numbered"]
        y.client.send(
            5 if numbered else None,
            0.5 if numbered else None,
            driving,
            whole["emergency"],
            {**plain, **signals},
            came=whole["came"],
        )
        said = planner.send(**changes)
        assert said["cycle"].data[48:] == y.channel.kept[-1][1][48:], changes
        assert said["cycle"].head.kind == layout.kinds["cycle"].number
        for box, data in y.channel.kept[:-1]:
            assert said[box].data[48:] == data[48:]
        assert (said["cycle"].head.sent, planner.c.dll.tml_sound(planner.c.room(said["cycle"].data))) == (
            0.25,
            0,
        )


def test_of_more_than_there_is_room_for_c_says_how_many(planner: CClient) -> None:
    """The first ones go along, and nothing behind them is written; the Supervisor sees by the number that it has not all."""
    x = planner.column
    many = [float(k) for k in range(1, 40)]
    said = planner.send(
        driving=planner.plan(9, **dict.fromkeys(PLAN, many)),
        objects=planner.part(Objects, 5, x(range(1, 40), ctypes.c_uint64), x(many), x(many), x([1] * 40, ctypes.c_byte)),
        stop=planner.part(Stop, planner.points([[k, k] for k in many], 3, 7)),
        found=planner.part(Fault * 70, *[(1, b"ego", b"lit", 3)] * 70), found_count=70,
    )  # fmt: skip
    message = said["cycle"]
    assert (message["driving/count"], message["driving.t"].tolist(), message["driving.v"].tolist()) == (
        9,
        many[:8],
        many[:8],
    )
    assert (message["signals.objects/count"], message["signals.objects/id"].tolist()) == (5, [1, 2, 3])
    assert (message["signals.objects.x"].tolist(), message["signals.objects.shy"].tolist()) == (
        many[:3],
        [1, 1, 1],
    )
    assert (said["line_2"]["count"], said["line_2"]["points"].tolist()) == (
        7,
        [1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0],
    )
    assert (message["found_count"], set(message["found_name"]), set(message["found_index"])) == (65, {1}, {3})


def test_faults_that_c_has_found(planner: CClient) -> None:
    layout = planner.c.layout
    most, unknown = len(layout.faults), layout.faults.index("unknown")
    given = [
        (1, b"ego", b"lit", 0),
        (0, b"nobody", None, NOWHERE),
        (most - 1, None, b"nothing", 5),
        (most, b"ego", b"", 1),
    ]
    said = planner.send(found=planner.part(Fault * 4, *given), found_count=4)["cycle"]
    signals, fields = len(layout.signals), len(layout.fields)
    ego, lit = layout.signals.index("ego"), layout.fields.index("lit")
    found: Any = [list(said[f"found_{name}"][:5]) for name in ("name", "signal", "field", "index")]
    assert found == [
        [1, unknown, most - 1, unknown, 0], [ego, signals, signals, ego, 0], [lit, fields, fields, 0, 0], [0, -1, 5, 1, 0]
    ]  # fmt: skip
    said = planner.send(found=None, found_count=3)[
        "cycle"
    ]  # as to tm_step, it is a fault that they are not there
    found = [said[f"found_{name}"][0] for name in ("name", "signal", "field", "index")]
    assert (said["found_count"], found) == (1, [layout.faults.index("missing"), signals, fields, -1])


def test_a_line_is_sent_where_it_is_new_or_wanted(planner: CClient) -> None:
    """New is one with another id, or as many points more or less, or without an id; without a cycle none is."""
    c, sent = planner.c, planner.send
    lines = ("line_0", "line_1", "line_2")

    def boxes(*versions: int, **changes: Any) -> list[str]:
        said = sent(**changes)
        names = ("signals.track.left", "signals.track.right", "signals.stop.line")
        assert tuple(said["cycle"][name] for name in names) == versions
        for slot, box in enumerate(lines):
            assert box not in said or (said[box]["slot"], said[box]["line_version"]) == (slot, versions[slot])
        return [box for box in said if box in lines]

    def stop(id_: int, points: Any = STOP) -> dict[str, Any]:
        return {"stop": planner.part(Stop, planner.points(points, id_))}

    assert boxes(0, 0, 0, came=False) == []
    assert boxes(1, 1, 1) == [*lines]
    assert boxes(1, 1, 1) == []
    assert boxes(1, 1, 2, **stop(4)) == boxes(1, 1, 3, **stop(4, [*STOP, [81.0, 0.0]])) == ["line_2"]
    assert boxes(1, 1, 4, **stop(0)) == boxes(1, 1, 5, **stop(0)) == ["line_2"]
    assert boxes(1, 1, 0, **stop(0, None)) == []
    assert boxes(1, 1, 6, **stop(3)) == ["line_2"]

    session = sent()["cycle"].head.session
    kind = c.layout.kinds["decision"]
    for sequence, (about, wanted, heard) in enumerate(
        ((session - 1, 0b111, 0), (session, 0b101, 1), (session, 0, 1), (session, 0b11, 0)), start=1
    ):
        message = bytearray(kind.length)
        for name, value in {
            "serial": int(sequence != 4),
            "about_session": about,
            "about_sequence": 1,
            "wanted": wanted,
        }.items():
            kind.put(message, name, value)
        planner.decisions.put("decision", bytearray(c.sealed("decision", message, 1, sequence, 0.0)))
        assert planner.hear() is (sequence != 4)  # the last one cannot be, and says nothing
        expected = {2: (2, 1, 7)}.get(sequence, (1, 1, 6) if sequence == 1 else (2, 1, 7))
        assert boxes(*expected) == (["line_0", "line_2"] if sequence == 2 else []), heard
    assert planner.refused("content") == 1


def test_c_hears_nothing_of_before_and_each_message_once(planner: CClient) -> None:
    """Decisions before signs of life; what is no whole message is counted."""
    c, layout = planner.c, planner.c.layout
    kinds = layout.kinds
    c.dll.tml_client_close(planner.at)

    def put(name: str, sequence: int, spoilt: bool = False) -> None:
        message = bytearray(kinds[name].length)
        if name == "decision":
            for entry in ("serial", "about_session"):
                kinds[name].put(message, entry, 1)
        made = bytearray(c.sealed(name, message, 1, sequence, 0.0))
        made[60] ^= spoilt
        planner.decisions.put(name, made)

    put("decision", 1)
    put("beat", 1)
    planner.connect()
    assert not planner.hear()
    put("beat", 2)
    put("decision", 2)
    assert [planner.hear() for _ in range(3)] == [True, True, False]
    put("decision", 3, spoilt=True)
    assert not planner.hear()
    assert planner.refused("crc") == 1
    box = planner.decisions._boxes["decision"]
    planner.decisions._words[box["place"] // 8] += 1
    assert not planner.hear()
    assert planner.refused("torn") == 1
    begin = time.monotonic()
    assert not c.dll.tml_client_answer(planner.at, 1, 0.01, c.room())
    assert 0.01 <= time.monotonic() - begin < 20.0
    assert c.dll.tml_client_tick(planner.at)
    assert list(planner.sent()) == ["tick"]


@pytest.mark.verifies("S-1-B-7")
def test_only_a_decision_about_the_very_message_is_its_answer_in_c(planner: CClient) -> None:
    """Planners count alike: a decision about the cycle of another one says nothing of this one's."""
    c, decision = planner.c, planner.c.layout.kinds["decision"]
    head = planner.send()["cycle"].head
    own = (head.session, head.sequence)
    about = [(head.session + 1, head.sequence), (head.session, head.sequence - 1), (head.session, 0), own]
    for sequence, (session, number) in enumerate(about, start=1):
        message = bytearray(decision.length)
        for entry, value in {"serial": 1, "about_session": session, "about_sequence": number}.items():
            decision.put(message, entry, value)
        planner.decisions.put("decision", bytearray(c.sealed("decision", message, 1, sequence, 0.0)))
        answered = c.dll.tml_client_answer(planner.at, head.sequence, 0.001, c.room())
        assert answered == ((session, number) == own)
    assert planner.refused("content") == 0


def test_a_client_in_c_sends_nothing_in_a_fork(planner: CClient) -> None:
    """It would count on with the same numbers, and each take decisions about the other's cycles for its own."""
    planner.send()
    cycle = CCycle(**planner.given())
    child = os.fork()
    if child == 0:
        sent = planner.c.dll.tml_client_send(planner.at, ctypes.byref(cycle))
        os._exit(10 if sent == 0 and not planner.c.dll.tml_client_tick(planner.at) else 11)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 10
    assert planner.sent() == {}
    # Behind three lines and a cycle.
    assert planner.send()["cycle"].head.sequence == 5


# The client in Python ---------------------------------------------------------------------------------------------------


class Emptied(list[Any]):
    """A list that another thread empties once somebody has asked how long it is."""

    def __iter__(self) -> Iterator[Any]:
        return iter([])


@pytest.mark.parametrize(
    ("signal", "field"),
    [("objects", "v"), ("objects", "shy"), ("objects", "id"), ("driving", "t"), ("marks", "x")],
)
def test_a_column_that_another_thread_empties(signal: str, field: str, c: C) -> None:
    """Zeros stood for what it had no more: objects at rest, at x = 0, that nobody has seen."""
    one = Planner(c.layout)
    objects = {"id": [7, 8], "x": [50.0, 60.0], "v": [1.0, 2.0], "shy": [True, False]}
    signals: dict[str, Any] = {**one.signals(), "driving": PLAN, "objects": objects}
    signals[signal] = {**signals[signal], field: Emptied(signals[signal][field])}
    driving = signals.pop("driving")
    with pytest.raises(LinkError, match="has another length than just before"):
        one.client.send(0, 0.0, driving, PLAN, signals)
    assert "cycle" not in [box for box, _ in one.channel.kept]


def test_samples_of_a_series_have_no_ids(c: C) -> None:
    """As to the Supervisor's own door, which says that nothing declares it."""
    one = Planner(c.layout)
    with pytest.raises(LinkError, match=r"the program reads no `signals\.marks\.id`"):
        one.cycle(0, marks={"id": [1], "x": [1.0], "v": [2.0]})
    assert one.channel.kept == []
