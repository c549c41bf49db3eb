"""What a fault changes in a cycle: a closed set of edits, each declared by the name of what it edits."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from trackmarshal.runtime.lines import Line
from trackmarshal.scenarios.faults.moment import Moment
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.recording import CANDIDATES
from trackmarshal.scenarios.trajectory import wrap

Change = Callable[[Moment], None]
#: The most samples of a trajectory that are spoken of.
_MOST = 100_000
#: The most that is added to the number of a cycle: beyond the 64 bits that a Supervisor takes.
_FAR = 2**64
#: Numbers that plain YAML numbers cannot say.
_WORDS = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}


def change(item: Item) -> Change:
    """The edit that an item declares; raises D151."""
    found = item.any_fields()
    kinds = [name for name in _KINDS if name in found]
    if len(kinds) != 1:
        raise item.wrong("this is no change", f"one of {', '.join(_KINDS)} says what is changed")
    return _KINDS[kinds[0]](item)


def _number(item: Item) -> float:
    """A number, or one of nan, inf, -inf."""
    word = item.plain()
    if isinstance(word, str) and word in _WORDS:  # a list or a table is none
        return _WORDS[word]
    return item.number()


def _said(item: Item) -> None:
    """The `true` of an operation that needs no value; raises D151 for `false`, which would be no operation."""
    if not item.flag():
        raise item.wrong("`false` changes nothing", "true, or another operation")


def _column(item: Item) -> Change:
    """`column: driving.a`: its values, or those of some samples, are set or added to; or it is cut, turned round or removed."""
    fields = item.fields(("column",), ("samples", "set", "add", "keep", "remove", "reverse"))
    of, name = _dotted(fields["column"], (*CANDIDATES, "objects", "obstacles"))
    edit = _edit(item, fields)
    for each in ("samples", "keep", "reverse"):
        if each in fields and of not in CANDIDATES:
            raise fields[each].wrong(
                f"`{each}` is for trajectories", f"`{of}` are changed all alike: leave it out"
            )
    if "samples" in fields and edit is None:
        raise fields["samples"].wrong(
            "`remove` takes the whole column", "`set: nan` makes some samples unusable"
        )
    first, last = (0, 10**9) if "samples" not in fields else _range(fields["samples"])

    def apply(moment: Moment) -> None:
        if of in CANDIDATES:
            columns = moment.candidates[of]
            if edit is None:
                del columns[name]
                return
            inside = columns[name][first : last + 1]
            columns[name] = [*columns[name][:first], *edit(inside), *columns[name][last + 1 :]]
            return
        for element in moment.signals[of]:
            if edit is None:
                del element[name]
            else:
                element[name] = edit([element[name]])[0]

    return apply


def _edit(item: Item, fields: dict[str, Item]) -> Callable[[list[float]], list[float]] | None:
    """The one operation among the fields, on a list of values; None removes it."""
    given = [name for name in ("set", "add", "keep", "remove", "reverse") if name in fields]
    if len(given) != 1:
        raise item.wrong("one operation is expected", "set, add, keep, reverse or remove")
    match given[0]:
        case "set":
            value = _number(fields["set"])
            return lambda values: [value] * len(values)
        case "add":
            more = fields["add"].number()
            return lambda values: [value + more for value in values]
        case "keep":
            count = fields["keep"].count(0, _MOST)
            return lambda values: values[:count]
        case "reverse":
            _said(fields["reverse"])
            return lambda values: values[::-1]
        case "remove":
            _said(fields["remove"])
            return None
        case other:
            raise AssertionError(other)


def _field(item: Item) -> Change:
    """`field: ego.v`: it is set, added to or removed."""
    fields = item.fields(("field",), ("set", "add", "remove"))
    of, name = _dotted(fields["field"], ("ego",))
    edit = _edit(item, fields)

    def apply(moment: Moment) -> None:
        if edit is None:
            del moment.signals[of][name]
        else:
            moment.signals[of][name] = edit([moment.signals[of][name]])[0]

    return apply


def _trajectory(item: Item) -> Change:
    """`trajectory: driving`: it is moved as a whole, drifts to the left, is cut, refined or removed."""
    fields = item.fields(("trajectory",), ("left", "drift", "keep", "refine", "remove"))
    which = fields["trajectory"].choice(CANDIDATES)
    given = [name for name in fields if name != "trajectory"]
    if len(given) != 1:
        raise item.wrong("one operation is expected", "left, drift, keep, refine or remove")
    if given[0] == "remove":
        _said(fields["remove"])

        def removed(moment: Moment) -> None:
            del moment.candidates[which]

        return removed
    operation = _operation(given[0], fields[given[0]])

    def apply(moment: Moment) -> None:
        moment.candidates[which] = operation(moment.candidates[which])

    return apply


def _operation(name: str, amount: Item) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """What is done to a trajectory, by so many m or to so many samples."""
    match name:
        case "left":
            return partial(_moved, left=amount.number())
        case "drift":
            return partial(_drifted, left=amount.number())
        case "keep":
            return partial(_cut, count=amount.count(0, _MOST))
        case "refine":
            return partial(_refined, count=amount.count(2, _MOST))
        case other:
            raise AssertionError(other)


def _moved(plan: dict[str, Any], left: float) -> dict[str, Any]:
    """All samples to the left, m, as the first one sees it."""
    c, s = math.cos(plan["heading"][0]), math.sin(plan["heading"][0])
    return {**plan, "x": [x - left * s for x in plan["x"]], "y": [y + left * c for y in plan["y"]]}


def _drifted(plan: dict[str, Any], left: float) -> dict[str, Any]:
    """Samples further and further to the left: not at all at first, by `left` m at last."""
    last = len(plan["x"]) - 1
    by = [left * (i / last) ** 2 for i in range(last + 1)]
    return {
        **plan,
        "x": [x - d * math.sin(h) for x, d, h in zip(plan["x"], by, plan["heading"])],
        "y": [y + d * math.cos(h) for y, d, h in zip(plan["y"], by, plan["heading"])],
    }


def _cut(plan: dict[str, Any], count: int) -> dict[str, Any]:
    return {name: column[:count] for name, column in plan.items()}


def _refined(plan: dict[str, Any], count: int) -> dict[str, Any]:
    """As many samples as said, straight between those that are there."""
    steps, have = count - 1, len(plan["t"]) - 1

    def between(name: str, column: list[float], at: float) -> float:
        i = min(int(at), have - 1)
        step = column[i + 1] - column[i]
        if name == "heading":  # the shorter way round
            return wrap(column[i] + (at - i) * wrap(step))
        return column[i] + (at - i) * step

    places = [have * k / steps for k in range(steps + 1)]
    return {name: [between(name, column, at) for at in places] for name, column in plan.items()}


def _signal(item: Item) -> Change:
    """`signal: objects`: it is not there, or, `ego`, the car is reported further to the left, m."""
    fields = item.fields(("signal",), ("left", "remove"))
    name = fields["signal"].choice(("ego", "objects", "obstacles", "track"))
    if "left" in fields:
        if name != "ego":
            raise fields["left"].wrong("`left` is the car's", "`signal: ego`, or `remove: true`")
        item.fields(("signal", "left"))
        left = fields["left"].number()

        def aside(moment: Moment) -> None:
            moment.signals["ego"].update(moment.beside_the_car(0.0, left, 0.0))

        return aside
    fields = item.fields(("signal", "remove"))
    _said(fields["remove"])

    def removed(moment: Moment) -> None:
        del moment.signals[name]

    return removed


def _place(item: Item) -> Change:
    """`place: objects`: those that are there are put `ahead` and to the `left` of the car, m, driving as it does."""
    fields = item.fields(("place", "ahead", "left"))
    name = fields["place"].choice(("objects",))
    ahead, left = fields["ahead"].number(), fields["left"].number()

    def apply(moment: Moment) -> None:
        for element in moment.signals[name]:
            element.update(moment.beside_the_car(ahead, left, 0.0), v=moment.signals["ego"]["v"])

    return apply


def _append(item: Item) -> Change:
    """`append: objects`: one more (or `copies`), placed relative to the car; `turn` in degrees."""
    fields = item.fields(("append", "id", "ahead", "left", "length", "width"), ("turn", "v", "copies"))
    name = fields["append"].choice(("objects", "obstacles"))
    numbers = {each: fields[each].number() for each in ("length", "width", "v") if each in fields}
    ahead, left = fields["ahead"].number(), fields["left"].number()
    turn = math.radians(fields["turn"].number()) if "turn" in fields else 0.0
    id_ = fields["id"].text()
    copies = fields["copies"].count(1, 10_000) if "copies" in fields else 1
    ids = [id_] if copies == 1 else [f"{id_}{i}" for i in range(copies)]

    def apply(moment: Moment) -> None:
        pose = moment.beside_the_car(ahead, left, turn)
        moment.signals[name] += [{"id": each, **pose, **numbers} for each in ids]

    return apply


def _border(item: Item) -> Change:
    """`border: left`: points from..to are `swap`ped with the other border's, set to a number, or alone are `keep`t."""
    fields = item.fields(("border",), ("swap", "keep", "set"))
    line = fields["border"].choice(("left", "right"))
    other = "right" if line == "left" else "left"
    given = [name for name in fields if name != "border"]
    if len(given) != 1:
        raise item.wrong("one operation is expected", "swap, keep or set")
    if given[0] == "set":
        value = _number(fields["set"])

        def spoil(moment: Moment) -> None:
            track = moment.signals["track"]
            _put(track, line, [[value, value], *_points(track[line])[1:]])

        return spoil
    first, last = _range(fields[given[0]])

    def apply(moment: Moment) -> None:
        track = moment.signals["track"]
        mine, theirs = _points(track[line]), _points(track[other])
        if given[0] == "keep":
            _put(track, line, mine[first : last + 1])
            track["closed"] = False
            return
        inside = slice(first, last + 1)
        mine[inside], theirs[inside] = theirs[inside], mine[inside]
        _put(track, line, mine)
        _put(track, other, theirs)

    return apply


def _put(track: dict[str, Any], side: str, points: list[list[float]]) -> None:
    """Other points in place of a border; one that has these points stays, so that a change of which nothing comes is seen to be none."""
    if points != _points(track[side]):
        track[side] = points


def _points(border: Any) -> list[list[float]]:
    """The points of a border, to be changed."""
    points = border.points.tolist() if isinstance(border, Line) else border
    return [list(map(float, point)) for point in points]


def _cycle(item: Item) -> Change:
    """`cycle: lost` (it never comes) or `silent` (the caller says so), or `number`, `t`, `arrival` or `clock`, by `add`."""
    fields = item.fields(("cycle",), ("add",))
    what = fields["cycle"].choice(("lost", "silent", "number", "t", "arrival", "clock"))
    if what in ("lost", "silent"):
        item.fields(("cycle",))
        return lambda moment: setattr(moment, what, True)
    more = item.fields(("cycle", "add"))["add"]
    amount = more.count(-_FAR, _FAR) if what == "number" else more.number()
    return lambda moment: setattr(moment, what, getattr(moment, what) + amount)


def _judge(item: Item) -> Change:
    """`judge: slow` (by `delay`, s), `raises`, `short` (a verdict is missing) or `unknown` (a verdict that is none)."""
    fields = item.fields(("judge",), ("delay",))
    what = fields["judge"].choice(("slow", "raises", "short", "unknown"))
    if what == "slow":
        delay = item.fields(("judge", "delay"))["delay"].number(0.0, 1000.0)
        return lambda moment: setattr(moment, "delay", delay)
    item.fields(("judge",))
    return lambda moment: setattr(moment, "judge", what)


def _dotted(item: Item, known: tuple[str, ...]) -> tuple[str, str]:
    of, dot, name = item.text().partition(".")
    if not dot or not name or of not in known:
        raise item.wrong(f"`{item.text()}` is not known", f"one of {', '.join(known)}, a dot, and a field")
    return of, name


def _range(item: Item) -> tuple[int, int]:
    """Two whole numbers, first and last."""
    numbers = [each.count(0, 1_000_000) for each in item.items()]
    if len(numbers) != 2 or numbers[0] > numbers[1]:
        raise item.wrong("this is no range", "two whole numbers are expected, first and last: [3, 5]")
    return numbers[0], numbers[1]


_KINDS: dict[str, Callable[[Item], Change]] = {
    "column": _column,
    "field": _field,
    "trajectory": _trajectory,
    "signal": _signal,
    "place": _place,
    "append": _append,
    "border": _border,
    "cycle": _cycle,
    "judge": _judge,
}
