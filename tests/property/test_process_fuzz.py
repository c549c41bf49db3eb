"""Whatever comes as a message, C and Python take the same, do the same with it, and keep to their memory."""

from __future__ import annotations

import math
import os
import random
import shutil
import struct
from collections import Counter
from pathlib import Path

import pytest

from support.process_tape import Record, compiled, expected, played, recorded
from support.processes import Served, built
from support.sanitized import FLAGS as SANITIZED
from trackmarshal.process.messages import Layout

pytestmark = [
    pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler"),
    pytest.mark.verifies("S-1-B-3"),
]
#: Messages that `make acceptance` mutates.
MESSAGES = int(os.environ.get("TRACKMARSHAL_FUZZ_CYCLES", "10000")) // 5
Pool = tuple[list[bytes], list[bytes]]


@pytest.fixture(scope="module")
def pool() -> Pool:
    """Messages that went up and that came down."""
    with Served(built()) as served:
        return recorded(served, 11)


def sealed(layout: Layout, data: bytearray) -> bytes:
    """With a CRC that fits, and a head that is one."""
    kind = layout._by_number.get(struct.unpack_from("<H", data, 10)[0])
    if kind is None or len(data) != kind.length:
        return bytes(data)
    session, sequence, sent = struct.unpack_from("<QQd", data, 24)
    layout.seal(data, kind, session, sequence, sent)
    return bytes(data)


def spoilt(rng: random.Random, layout: Layout, data: bytes) -> bytes:
    """A message that is cut, longer, changed somewhere, or made up of entries that cannot be, with a CRC that fits or not."""
    made = bytearray(data)
    first = (
        24 if rng.random() < 0.01 else 48
    )  # a made-up session or sequence shuts out all that come after it
    match rng.randrange(8):
        case 0:
            return bytes(made[: rng.randrange(len(made) + 1)])
        case 1:
            return bytes(made) + rng.randbytes(rng.choice([1, 8, 40_000]))
        case 2:
            made[rng.randrange(48)] ^= 1 << rng.randrange(8)
            return bytes(made)
        case 3:
            made[rng.randrange(len(made))] ^= 1 << rng.randrange(8)
            return bytes(made)
        case 4:
            return rng.randbytes(rng.randrange(200))
        case _:
            kind = layout._by_number[struct.unpack_from("<H", made, 10)[0]]
            for _ in range(rng.randint(1, 3)):
                entry = rng.choice(
                    [one for one in kind.entries.values() if one.offset >= first] or [kind.entries["sent"]]
                )
                size = struct.calcsize("=" + entry.format)
                place = entry.offset + size * rng.randrange(entry.room)
                wild = struct.pack("<d", rng.choice([float("nan"), float("inf"), -1e300, 0.0, 1e18, 5e-324]))
                values = [
                    b"\xff" * 8,
                    bytes(8),
                    b"\x01" + bytes(7),
                    b"\x02" + bytes(7),
                    rng.randbytes(8),
                    wild,
                ]
                made[place : place + size] = rng.choice(values)[:size]
            return sealed(layout, made)


def tape_of(rng: random.Random, layout: Layout, pool: Pool, count: int) -> list[Record]:
    """Messages and times in an order in which they might come: mostly forward, some again, some of earlier, some spoilt."""
    up, down = pool
    now, place, tape = 0.0, 0, list[Record]()
    for _ in range(count):
        place = (place + 1) % len(down) if rng.random() < 0.8 else rng.randrange(len(down))
        data = down[place] if rng.random() < 0.7 else rng.choice(up)
        sent = struct.unpack_from("<d", data, 40)[0]
        tape.append(data if rng.random() < 0.6 else spoilt(rng, layout, data))
        if rng.random() < 0.4:
            now = max(now, sent + rng.choice([0.0, 0.01, 0.06, 0.2])) if -1.0 < sent < 10.0 else now
            tape.append(now)
        if rng.random() < 0.01:  # a Supervisor that starts, and is replaced before it has decided anything
            beat = bytearray(next(one for one in down if len(one) == layout.kinds["beat"].length))
            session, sequence, _ = struct.unpack_from("<QQd", data, 24)
            struct.pack_into("<QQd", beat, 24, session + 1, sequence, now)
            tape += [sealed(layout, beat), now]
        if place == 0:  # time begins anew: it would never get back to where decisions are fresh
            now = 0.0
    return tape


def restarting(layout: Layout, pool: Pool) -> list[Record]:
    """A decision of a Supervisor with a late clock, the same of one that starts after it with an early one, and then nothing any more."""
    looked = (layout.look(data, up=False)[1] for data in pool[1])
    said = next(
        one for one in looked if one is not None and one.kind.name == "decision" and one["driven"] == 1
    )
    tape, session, now = list[Record](), said.head.session, said["now"]
    for later, sent in enumerate((1e6, now)):
        data = bytearray(said.data)
        layout.seal(data, said.kind, session + later, 1, sent)
        tape.append(bytes(data))
    return [*tape, *(now + k * layout.silence / 2 for k in range(4))]


def at_the_edges(layout: Layout, pool: Pool) -> list[Record]:
    """Decisions asked for at the very times at which something begins or ends, and just after them; with headings on both sides of pi."""
    looked = (layout.look(data, up=False)[1] for data in pool[1])
    said = next(
        one for one in looked if one is not None and one.kind.name == "decision" and one["driven"] == 1
    )
    kind, session, now = said.kind, said.head.session, said["now"]
    due = list(said.due("driving"))
    stored = [time + 1.0 for time in said.due("fallback")]  # there is some left where the other one ends

    def decision(later: int, sequence: int, **changes: float) -> bytes:
        data = bytearray(said.data)
        for group, times in (("driving", due), ("fallback", stored)):
            kind.put(data, f"{group}/due", times)
            kind.put(data, f"{group}.heading", [3.1 * (-1) ** k for k in range(len(times))])
        for name, value in changes.items():
            kind.put(data, name, value)
        layout.seal(data, kind, session + later, sequence, 1e6)  # it is heard of all the time
        return bytes(data)

    def asked(*times: float) -> list[Record]:
        return [at for time in times for at in (time, math.nextafter(time, math.inf), time + 0.013)]

    soon = now + 0.05
    return [
        decision(0, 1, valid_until=100.0), *asked(now, *due), due[-1] + 0.1,
        decision(0, 2, valid_until=soon), *asked(soon),
        decision(0, 3, valid_until=100.0, driven=2, safe=0), *asked(now, *stored),
        decision(0, 4), math.nextafter(now, 0.0), now, math.nan, now,
        decision(1, 1, valid_until=100.0, driven=0, safe=0, stored=0), now, soon,
        decision(1, 2, valid_until=100.0), decision(1, 3, valid_until=100.0, driven=0, safe=0, stored=0), now,
    ]  # fmt: skip


def test_c_and_python_make_the_same_of_a_tape(pool: Pool, tmp_path: Path) -> None:
    """What is taken and what is driven, sample by sample."""
    layout, program = built().layout, compiled(tmp_path, ["-O0"], desk=False)
    seen: Counter[str] = Counter()
    tapes = [tape_of(random.Random(seed), layout, pool, 250) for seed in range(12)]
    for tape in (*tapes, restarting(layout, pool), at_the_edges(layout, pool)):
        said, wanted = played(program, tape), expected(layout, tape)
        assert len(said) == len(wanted)
        for one, other in zip(said, wanted):
            words, others = one.split(), other.split()
            if words[0] == "refused":
                assert words == others
                continue
            if words[0] == "at":
                assert words == others
                seen[f"{words[1]} {words[2]}"] += 1
                continue
            # Of what goes up, C also looks at what is in it.
            assert (words[1], words[3]) == (others[1], others[3])
            assert words[2] == others[2] or (words[2], others[2]) == ("content", "none")
            seen[words[3]] += 1
    assert {
        "none",
        "size",
        "magic",
        "version",
        "layout",
        "kind",
        "length",
        "crc",
        "session",
        "sequence",
        "content",
    } <= seen.keys()
    assert {
        "1 1",
        "2 1",
        "2 2",
        "2 3",
        "2 4",
        "2 5",
        "2 6",
    } <= seen.keys()  # driven; fallback: as decided, restarted, silent, outdated, left, ended


@pytest.mark.acceptance
def test_the_reader_under_the_sanitizers(pool: Pool, tmp_path: Path) -> None:
    """The program holds every decision against itself: it is sound, about the message, and none is safe without a cycle that was taken."""
    layout, program = built().layout, compiled(tmp_path, SANITIZED, desk=True)
    decided: Counter[str] = Counter()
    for seed in range(max(2, MESSAGES // 1000)):
        rng = random.Random(1000 + seed)
        up = pool[0]
        tape: list[Record] = []
        for k in range(1000):
            data = up[k % len(up)] if rng.random() < 0.97 else rng.choice(up)
            if k % len(up) == 0:  # a planner that starts anew: its session is later
                session = seed * 100 + k // len(up) + 1
            made = bytearray(data)
            struct.pack_into("<Q", made, 24, session)
            fine = sealed(layout, made)
            tape.append(fine if rng.random() < 0.7 else spoilt(rng, layout, fine))
        for line in played(program, tape)[:-1]:
            _, _, cause, _, made_one = line.split()
            decided[made_one] += 1
            decided[cause] += 1
    assert decided["2"] > 0
    assert decided["1"] > 0
    assert {"size", "magic", "version", "layout", "kind", "length", "crc", "content"} <= decided.keys()
