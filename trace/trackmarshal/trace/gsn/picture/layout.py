"""Where elements stand: worked out by graphviz-pure, a port of Graphviz that answers with the same bytes on every machine."""

from __future__ import annotations

import os
import shutil
import subprocess
import sysconfig
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from trackmarshal.errors import TrackmarshalError
from trackmarshal.trace.gsn.modules import ONE_ROW
from trackmarshal.trace.gsn.picture.boxes import DIAMOND, OVAL, ROUND, Box
from trackmarshal.trace.gsn.picture.content import Content

PROGRAM = "graphviz-pure"
INCH = 72.0
#: The room between rows, in inches.
APART = 0.48
#: No picture takes this long (s).
PATIENCE = 600


class Placed(NamedTuple):
    """Positions in points, from the upper left corner: centres of elements, and links as Bezier curves from their start."""

    width: float
    height: float
    centres: Mapping[str, tuple[float, float]]
    curves: Mapping[tuple[str, str], Sequence[tuple[float, float]]]


def laid_out(
    pictures: Sequence[tuple[Content, Mapping[str, Box]]], one_row: int = ONE_ROW, apart: float = APART
) -> list[Placed]:
    """Positions in each of some pictures, all in one call of the engine. Raises T424 where there is none, T425 where it does not answer.

    one_row: where more elements than this are below one, they stand in two rows. apart: the room between rows, in inches.
    """
    if not pictures:
        return []
    asked = "\n".join(_graph(content, boxes, one_row, apart) for content, boxes in pictures)
    answers = list(_answers(_run(_engine(), asked)))
    if len(answers) != len(pictures):
        raise _failed(f"{len(answers)} positions for {len(pictures)} pictures")
    return [_placed(answer, content) for answer, (content, _) in zip(answers, pictures)]


def _engine() -> str:
    """The program, of this Python's packages or on the path."""
    beside = Path(sysconfig.get_path("scripts")) / PROGRAM
    found = str(beside) if os.access(beside, os.X_OK) else shutil.which(PROGRAM)
    if found is None:
        raise TrackmarshalError(
            "T424",
            f"pictures are laid out by `{PROGRAM}`, which is not installed",
            help="pip install 'trackmarshal[gsn]'; or take another format: text, yaml, json",
        )
    return found


def _run(program: str, asked: str) -> str:
    try:
        done = subprocess.run([program, "-Tplain"], input=asked, capture_output=True, text=True, encoding="utf-8", timeout=PATIENCE, check=False)  # fmt: skip
    except (OSError, subprocess.TimeoutExpired) as problem:
        raise _failed(str(problem)) from problem
    if done.returncode != 0:
        raise _failed(done.stderr.strip().split("\n")[0] or f"exit status {done.returncode}")
    return done.stdout


def _failed(why: str) -> TrackmarshalError:
    return TrackmarshalError("T425", f"`{PROGRAM}` failed: {why}", help="install the version that constraints.txt names")  # fmt: skip


def _graph(content: Content, boxes: Mapping[str, Box], one_row: int, apart: float) -> str:
    """A picture in the DOT language, with numbers for names, so that no text of a project is in it."""
    number = {id_: f"n{index}" for index, id_ in enumerate(content.shown)}
    lines = [f'digraph {{ graph [nodesep=0.22, ranksep={apart}, ordering=out, splines=polyline]; node [label="", fixedsize=true, shape=box]; edge [arrowsize=0.9];']  # fmt: skip
    for id_, shown in content.shown.items():
        size = boxes[id_]
        high = size.height + (DIAMOND if shown.element.undeveloped else 0)
        form = "ellipse" if shown.element.kind in ROUND | OVAL else "box"
        lines.append(
            f"{number[id_]} [width={size.width / INCH:.4f}, height={high / INCH:.4f}, shape={form}];"
        )
    lines += _supports(content, number, one_row)
    lines += _beside(content, number)
    return "\n".join([*lines, "}"])


def _beside(content: Content, number: Mapping[str, str]) -> Iterator[str]:
    """What stands beside an element, by turns to its right and to its left, in a cluster with it, so that nothing comes between."""
    held: dict[str, list[str]] = {}
    seen: set[str] = set()
    for link in content.links:
        if link.kind == "supported_by":
            continue
        holder, other = (link.source, link.target) if link.kind == "in_context_of" else (link.target, link.source)  # fmt: skip
        if other in seen or other in held:  # it stands elsewhere already
            yield f"{number[link.source]} -> {number[link.target]} [constraint=false];"
            continue
        seen.add(other)
        own = held.setdefault(holder, [])
        left = len(own) % 2 == 1
        ends = (other, holder) if left else (holder, other)
        back = ", dir=back" if ends[0] == link.target else ""  # the head's room is where the link ends
        own.append(f"{number[ends[0]]} -> {number[ends[1]]} [minlen=1{back}];")
    for holder, own in held.items():
        if holder in seen:  # a defeater of what stands beside something: clusters do not overlap
            yield from own
        else:
            yield f"subgraph cluster_{number[holder]} {{peripheries=0; margin=0; {{rank=same; {' '.join(own)}}}}}"


def _supports(content: Content, number: Mapping[str, str], one_row: int) -> Iterator[str]:
    """Links of support; what stands side by side in large number stands in two rows, the second below all that is under the first."""
    below: dict[str, list[str]] = {}
    for link in content.links:
        if link.kind == "supported_by":
            below.setdefault(link.source, []).append(link.target)
    depth: dict[str, int] = {}
    for id_ in _deepest_first(below):
        depth[id_] = 1 + max((depth.get(t, 0) for t in below.get(id_, ())), default=0)
        depth[id_] += max((depth.get(t, 0) for t in below[id_][::2]), default=0) if len(below.get(id_, ())) > one_row else 0  # fmt: skip
    for source, targets in below.items():
        first = max(depth.get(target, 1) for target in targets[::2])
        for index, target in enumerate(targets):
            second = len(targets) > one_row and index % 2 == 1
            yield f"{number[source]}:s -> {number[target]}:n [minlen={1 + first if second else 1}];"


def _deepest_first(below: Mapping[str, Sequence[str]]) -> list[str]:
    order: list[str] = []
    seen: set[str] = set()
    for start in below:
        if start in seen:
            continue
        seen.add(start)
        path, ways = [start], [iter(below[start])]
        while path:
            target = next(ways[-1], None)
            if target is None:
                ways.pop()
                order.append(path.pop())
            elif target not in seen:
                seen.add(target)
                path.append(target)
                ways.append(iter(below.get(target, ())))
    return order


def _answers(text: str) -> Iterator[list[list[str]]]:
    """The lines of each picture's answer, as words."""
    lines: list[list[str]] = []
    for line in text.split("\n"):
        words = line.split()
        if words == ["stop"]:
            yield lines
            lines = []
        elif words:
            lines.append(words)


def _placed(answer: list[list[str]], content: Content) -> Placed:
    names = {f"n{index}": id_ for index, id_ in enumerate(content.shown)}
    links = {(link.source, link.target) for link in content.links}
    centres: dict[str, tuple[float, float]] = {}
    curves: dict[tuple[str, str], list[tuple[float, float]]] = {}
    width = height = 0.0
    try:
        for words in answer:
            if words[0] == "graph":
                width, height = float(words[2]) * INCH, float(words[3]) * INCH
            elif words[0] == "node":
                id_ = names[words[1]]
                low = DIAMOND / 2 if content.shown[id_].element.undeveloped else 0.0
                centres[id_] = float(words[2]) * INCH, height - float(words[3]) * INCH - low
            elif words[0] == "edge":
                numbers = [float(word) * INCH for word in words[4 : 4 + 2 * int(words[3])]]
                points = [(x, height - y) for x, y in zip(numbers[::2], numbers[1::2])]
                ends = names[words[1]], names[words[2]]
                if ends in links:
                    curves[ends] = points
                else:  # it was laid out from right to left
                    curves[ends[1], ends[0]] = points[::-1]
    except (KeyError, ValueError, IndexError) as problem:
        raise _failed(f"an answer that says no positions: {problem}") from problem
    if set(centres) != set(content.shown):
        raise _failed(f"positions of {len(centres)} of {len(content.shown)} elements")
    return Placed(width, height, centres, curves)


__all__ = ["APART", "PROGRAM", "Placed", "laid_out"]
