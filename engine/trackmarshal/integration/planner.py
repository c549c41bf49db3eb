"""Cycles of a planner against the contract of a spec: the report that `trackmarshal check-planner` prints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from trackmarshal.errors import TrackmarshalError, wrong_type
from trackmarshal.files import open_regular
from trackmarshal.integration import adapter as written
from trackmarshal.integration.findings import Finding, at_the_door, of_defaults, of_motion, of_structure
from trackmarshal.integration.mapped import Mapped, read
from trackmarshal.integration.mapping import Column
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Cycle

CODES = {
    "D195": ("no cycles of a planner", "`check-planner` takes JSON Lines, one object a cycle, or a recording (.tmrec.jsonl, also .gz; .saa). A first line with `format` is a header."),
    "D196": ("a planner's cycles without a trajectory", "A trajectory is an object with three or more equally long lists of numbers, or a list of records or of rows, anywhere in the cycle; --driving and --emergency name one by its path, such as `plans.nominal`."),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class PlannerReport:
    """What a planner's cycles are in the contract's terms. cycles: as the suggested mapping makes them; findings: what does not fit, in words;
    adapter: the mapping as Python."""

    name: str
    mapped: Mapped
    cycles: tuple[Cycle, ...]
    findings: tuple[Finding, ...]
    adapter: str

    @property
    def fits(self) -> bool:
        """Whether the planner keeps the contract as it is."""
        return not [one for one in self.findings if one.level != "note"]

    @property
    def convertible(self) -> bool:
        """Whether the suggested mapping is all that it takes."""
        return not [one for one in self.findings if one.level == "broken"]

    @property
    def mapping(self) -> dict[str, Any]:
        """The mapping as plain data: paths of the parts, and of each field its column, unit and convention."""
        made = self.mapped
        return {
            "stamp": None if made.stamp is None else _plain(made.stamp),
            "driving": made.driving, "emergency": made.emergency, "ego": made.ego, "objects": made.objects, "obstacles": made.obstacles,
            "left": made.left, "right": made.right,
            "plan": {name: _plain(column) for name, column in made.plan.items()},
            "computed": made.computed,
            "ego_fields": {name: _plain(column) for name, column in made.ego_fields.items()},
            "object_fields": {name: _plain(column) for name, column in made.object_fields.items()},
            "obstacle_fields": {name: _plain(column) for name, column in made.obstacle_fields.items()},
        }  # fmt: skip

    def as_json(self) -> dict[str, Any]:
        """Everything but the cycles, as strict JSON has it."""
        found = [
            {"level": f.level, "about": f.about, "words": f.words, "help": f.help} for f in self.findings
        ]
        return {
            "name": self.name,
            "cycles": len(self.cycles),
            "fits": self.fits,
            "findings": found,
            "mapping": self.mapping,
            "adapter": self.adapter,
        }

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def lines(self) -> list[str]:
        """For people."""
        made = self.mapped
        steps = np.diff(made.times())
        pace = f", {np.median(steps):.3g} s apart" if len(steps) and made.stamp is not None else ""
        lines = [f"{self.name}: {len(self.cycles)} cycles{pace}", "", "what is taken for what"]
        for name in ("driving", "emergency", "ego", "objects", "obstacles", "left", "right"):
            path = made.no_objects if name == "objects" and made.objects is None else getattr(made, name)
            lines.append(
                f"  {name:<16} {'-' if path is None else '`' + path + '`' if path else 'the cycle itself'}"
            )
        if made.stamp is not None:
            lines.append(f"  {'stamp':<16} `{made.stamp.column}`, {made.stamp.words}")
        for where, fields in (
            ("plan", made.plan),
            ("ego", made.ego_fields),
            ("objects", made.object_fields),
            ("obstacles", made.obstacle_fields),
        ):
            for name, column in fields.items():
                lines.append(f"  {where + '.' + name:<16} `{column.column}`, {column.words}: {column.said}")
        if made.others:
            lines.append(f"  not taken: {', '.join(made.others)}")
        titles = {
            "broken": "does not fit, and no conversion mends it", "convert": "does not fit as it is; the adapter below converts it",
            "note": "worth knowing",
        }  # fmt: skip
        for level, title in titles.items():
            found = [one for one in self.findings if one.level == level]
            if found:
                lines += ["", title]
                for number, one in enumerate(found, start=1):
                    lines += f"  {number}. {one}".split("\n")
        lines += [
            "",
            "it keeps the contract as it is"
            if self.fits
            else "the adapter is all that it takes"
            if self.convertible
            else "it does not keep the contract yet",
        ]
        return lines


def check_planner(
    source: str | Path | Iterable[Mapping[str, Any]], spec: Spec, most: int = 100, driving: str | None = None, emergency: str | None = None,
    header: Mapping[str, Any] | None = None,
) -> PlannerReport:  # fmt: skip
    """Hold a planner's cycles against the input contract of a spec, whatever its columns are called.

    source: a file (a recording, or JSON Lines with an object a cycle), or cycles as plain data or arrays; header: what comes once, such as
    borders. most: how many cycles are looked at. driving, emergency: where the trajectories are (`plans.nominal`), where they are not found.
    What is taken for what is a suggestion by names and numbers: a person has to look it over. Raises D195, D196, and D12x of recordings.
    """
    if not isinstance(spec, Spec):
        raise wrong_type("a spec is what `load` and `loads` return", spec)
    if not isinstance(most, int):
        raise wrong_type("`most` is a number of cycles", most)
    if not isinstance(source, str | Path | Iterable):
        raise wrong_type("cycles are a file, or a list of mappings", source)
    for where, given_as in (("driving", driving), ("emergency", emergency)):
        if given_as is not None and not isinstance(given_as, str):
            raise wrong_type(f"`{where}` is where that trajectory is, as `plans.nominal`", given_as)
    if header is not None and not isinstance(header, Mapping):
        raise wrong_type("`header` is a mapping", header)
    if most < 1:
        raise TrackmarshalError("D195", f"{most} cycles", help="look at one at least")
    name = "the planner"
    if isinstance(source, str | Path):
        name = Path(source).name
        raws, header = _load(Path(source), most)
    else:
        given = list(islice(source, most))
        if not all(isinstance(one, Mapping) for one in given):
            raise TrackmarshalError(
                "D195", "a cycle is no mapping", help="hand in mappings by name, one a cycle"
            )
        raws = [dict(one) for one in given]
    if not raws:
        raise TrackmarshalError(
            "D195", "there is no cycle", file=name, help="record at least one, better a hundred"
        )
    fields = {one.name: frozenset(field.name for field in one.fields_) for one in spec.signals.values()}
    contract = {"plan": frozenset[str](), **fields}
    with np.errstate(all="ignore"):  # what is not finite is for the door to tell
        made = read(raws, contract, header, driving, emergency)
        times = made.times()
        cycles = tuple(made.cycle(place, t) for place, t in enumerate(times))
        findings = [*of_structure(made), *of_motion(made, times)]
        told = {one.about for one in findings if one.level == "broken"}
        rules = [rule for rule in spec.rules if rule.formula is not None]
        findings += at_the_door(spec, rules, cycles, told)
        findings += of_defaults(made, spec, rules)
        return PlannerReport(name, made, cycles, tuple(findings), written.adapter(made, raws, header))


#: What may stand before the first line: a byte order mark, as Windows writes it, and white space.
_BLANK = b"\xef\xbb\xbf \t\r\n"


def _load(path: Path, most: int) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Cycles of a file as plain data, and the header where there is one."""
    from trackmarshal.json_text import BadJson, parse
    from trackmarshal.scenarios import content, load

    data = _beginning(path, most) or content.read(path, str(path))
    if data.startswith((b"PK\x03\x04", b"\xff\xff\xff\xff")):
        recording = load(path)
        rows = [
            {"t": c.t, "ego": c.ego, "objects": c.objects, "candidates": c.candidates}
            for c in recording.cycles[:most]
        ]
        return rows, {"track": recording.track}
    if data.startswith(b"\x1f\x8b"):
        data = content.gunzip(data, str(path))
    if data.lstrip(_BLANK)[:1] not in (b"{", b"[", b""):
        raise TrackmarshalError(
            "D195",
            "this is no JSON",
            file=str(path),
            line=1,
            help="cycles are JSON Lines, an object a cycle: docs/integration.md has a program that writes them; "
            "`trackmarshal import log` takes a car's log (CSV, MCAP)",
        )
    raws: list[dict[str, Any]] = []
    header: dict[str, Any] = {}
    for number, line in enumerate(content.text(data, str(path)).split("\n"), start=1):
        if not line.strip():
            continue
        try:
            value = parse(line, constants=True)
        except BadJson as error:
            raise TrackmarshalError(
                "D195", str(error), file=str(path), line=number, help="every line is one JSON object"
            ) from error
        if not isinstance(value, dict):
            raise TrackmarshalError(
                "D195",
                "the line is not a JSON object",
                file=str(path),
                line=number,
                help="every line is one cycle",
            )
        if not raws and not header and "format" in value:
            header = value
            continue
        raws.append(value)
        if len(raws) == most:
            break
    return raws, header


def _beginning(path: Path, most: int) -> bytes:
    """Of JSON Lines that are more than a recording may have, as a planner writes in an hour, the header and as many cycles as are asked for; empty for all else."""
    from trackmarshal.scenarios import content

    left, lines, found = content.MAX_BYTES, list[bytes](), 0
    if not path.is_file() or path.stat().st_size <= left:
        return b""
    with open_regular(path) as stream:
        if stream.read(4096).lstrip(_BLANK)[:1] != b"{":
            return b""
        stream.seek(0)
        while found <= most and left > 0 and (line := stream.readline(left)):
            lines.append(line)
            found += bool(line.strip())
            left -= len(line)
    return b"".join(lines) if left > 0 else b""


def _plain(column: Column) -> dict[str, Any]:
    plain: dict[str, Any] = {
        "column": column.column,
        "unit": column.unit,
        "sign": column.sign,
        "because": column.said,
    }
    if column.field == "heading":
        plain |= {"zero": column.zero, "clockwise": column.clockwise, "degrees": column.degrees}
    return plain
