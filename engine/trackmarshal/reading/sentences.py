"""Numbers and formulas of the typed tree as sentences that can be read aloud.

What has parts has a letter wherever it could be heard in two ways: "the square root of A", and then what A is. So "times" and "divided by"
join single things, `of` is about the thing that follows, and "plus" and "minus" come last, as they do in writing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from string import ascii_uppercase
from typing import assert_never

from trackmarshal import typed
from trackmarshal.ir.spec import ParamInfo
from trackmarshal.reading.names import bridged
from trackmarshal.reading.phrases import Phrases, called, parameters_of, plain
from trackmarshal.reading.words import Words
from trackmarshal.syntax import ast
from trackmarshal.units import about, in_full

#: How tightly phrases hold together: what is looser than its place asks for has a letter. NAMED: a name or a plain number, which nothing can be taken apart of.
LOOSE, LISTED, ADDED, MULTIPLIED, WHOLE, NAMED = range(6)
#: Comparisons as they are with their sides exchanged.
_TURNED: dict[typed.Comparing, typed.Comparing] = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}  # fmt: skip
#: Exponents whose powers are said before what is raised, "the square of A".
_BEFORE = (2, 3)
OPEN, ALTERNATIVES, TOGETHER, SINGLE = range(4)


class Sentences(Phrases):
    """Sentences of one rule. params: values in force; taken: names that are no letters for numbers; shared, measured: see `Phrases`."""

    def __init__(
        self, words: Words, params: Mapping[str, ParamInfo], taken: frozenset[str], shared: frozenset[str], measured: frozenset[str]
    ) -> None:  # fmt: skip
        super().__init__(words, shared, measured)
        self._params = params
        self._free: list[str] = []
        self._more = (one for one in _letters() if one not in taken)  # most rules take a few of thousands
        self._said: set[str] = set()
        self._lettered: dict[tuple[bool, str], str] = {}
        self._waiting: list[tuple[str, typed.Number | typed.Formula]] = []

    def meanings(self) -> list[str]:
        """What the letters stand for that were used since this was last asked; with those that are used in saying so."""
        made = []
        while self._waiting:
            letter, node = self._waiting.pop(0)
            if isinstance(node, typed.NumberNode):
                made.append(self.words.is_.format(a=letter, b=self.number(node)))
            else:
                made.append(self.words.if_.format(a=letter, b=self.formula(node)))
        self._lettered.clear()
        return made

    def _letter(self, node: typed.Number | typed.Formula) -> str:
        key = (
            isinstance(node, typed.NumberNode),
            node.span.in_line,
        )  # one text is one thing where both stand
        known = self._lettered.get(key)
        if known is None:
            if len(self._free) == len(self._lettered):
                self._free.append(next(self._more))
            known = self._lettered[key] = self._free[len(self._lettered)]
            self._waiting.append((known, node))
        return known

    def number(self, node: typed.Number, least: int = LOOSE) -> str:
        """A number, or the letter that it has where it holds together less than `least`."""
        if least > LOOSE and self._level(node) < least:
            return self._letter(node)
        return self._number(node)

    def atom(self, node: typed.Number) -> str:
        return self.number(node, WHOLE)

    def formula(self, node: typed.Formula, least: int = OPEN) -> str:
        """A formula as a sentence, or the condition by its letter where it holds together less than `least`."""
        if least > OPEN and _together(node) < least:
            return self.words.condition[0].format(a=self._letter(node))
        return self._formula(node)

    # Numbers ------------------------------------------------------------------------------------------------

    def _level(self, node: typed.Number) -> int:
        """How tightly the phrase of a number holds together."""
        match node:
            case typed.Literally():
                return WHOLE if node.unit else NAMED
            case typed.Pi() | typed.Parameter() | typed.Field() | typed.NamedNumber():
                return NAMED
            case typed.OnLine() | typed.Negative() | typed.Kept():
                return WHOLE
            case typed.Power():  # "to the power of" stands last, where whatever is before it may be meant
                return WHOLE if typed.whole_exponent(node.exponent) in _BEFORE else LISTED
            case typed.StationGap():
                return LISTED
            case typed.CalledNumber() | typed.TableValue() | typed.Function():
                return WHOLE if len(node.arguments) < 2 else LISTED
            case typed.Arithmetic():
                return ADDED if node.op in ("+", "-") else MULTIPLIED
            case typed.Choice() | typed.NumberCase() | typed.Folded():
                return LOOSE
            case _:
                assert_never(node)

    def _number(self, node: typed.Number) -> str:
        words, atom = self.words, self.atom
        match node:
            case typed.Literally():
                return f"{node.text} {node.unit}" if node.unit else node.text
            case typed.Pi():
                return words.pi
            case typed.Parameter():
                return self._parameter(node)
            case typed.Field():
                return self.field(node.record, node.name)
            case typed.Negative():
                return words.minus.format(a=atom(node.operand))
            case typed.Arithmetic():
                return self._arithmetic(node)
            case typed.Power():
                whole = typed.whole_exponent(node.exponent)
                if whole in _BEFORE:
                    return (words.square if whole == 2 else words.cube).format(a=atom(node.base))
                return words.power.format(a=self.number(node.base, NAMED), b=atom(node.exponent))
            case typed.Function():
                # Of a power, what is raised is a name, or has a letter.
                least = [NAMED if node.name == "pow" else WHOLE, *(WHOLE for _ in node.arguments[1:])]
                arguments = [self.number(one, how) for one, how in zip(node.arguments, least, strict=True)]
                if len(arguments) > 2:
                    return words.more[node.name].format(a=self.listed(arguments))
                return words.functions[node.name].format(a=arguments[0], b=arguments[-1])
            case typed.Choice():
                return self._choice(node)
            case typed.NumberCase():
                branches = [(one.members, one.rest, self.number(one.value, ADDED)) for one in node.branches]
                return self._case(node.subject, branches)
            case typed.TableValue():
                placed = self.listed([atom(one) for one in node.arguments])
                return words.table.format(a=called(self.short(node.symbol)), b=placed)
            case typed.OnLine():
                return self._on_line(node)
            case typed.StationGap():
                return words.station_gap.format(a=self.line(node.line), b=atom(node.start), c=atom(node.end))
            case typed.Folded():
                return self._folded(node)
            case typed.Kept():
                asked = self.machine(node.machine)
                return (
                    words.kept.format(a=called(node.name), b=asked)
                    if node.name
                    else words.time_in.format(a=asked)
                )
            case typed.CalledNumber():
                return self._called(node)
            case typed.NamedNumber():
                return called(node.name)
            case _:
                assert_never(node)

    def _parameter(self, node: typed.Parameter) -> str:
        """With its value where it is said first; a field of a record that is given to a definition by its name there."""
        if isinstance(node.record, typed.NamedRecord):
            return self.field(node.record, node.symbol.qualified.rpartition(".")[2])
        info = self._params[node.symbol.qualified]
        short = info.name if info.short in self.shared else info.short
        name = short if info.record else called(short)
        if info.name in self._said:
            return name
        self._said.add(info.name)
        return self.words.parameter.format(a=name, b=about(in_full(info.value, node.written or info.unit)))

    def _arithmetic(self, node: typed.Arithmetic) -> str:
        match node.op:
            case "+" | "-":
                left, right = self.number(node.left, ADDED), self.number(node.right, MULTIPLIED)
            case "*" | "/":
                quotient = isinstance(node.left, typed.Arithmetic) and node.left.op == "/"
                left, right = self.number(node.left, WHOLE if quotient else MULTIPLIED), self.atom(node.right)
            case _:
                assert_never(node.op)
        return self.words.arithmetic[node.op].format(a=left, b=right)

    def _choice(self, node: typed.Choice) -> str:
        parts: list[str] = []
        last: typed.Number = node
        while isinstance(last, typed.Choice):
            value, condition = self.number(last.then, ADDED), self.formula(last.condition, TOGETHER)
            # Several conditions may hold: the first one counts.
            parts.append((self.words.else_where if parts else self.words.where).format(a=value, b=condition))
            last = last.otherwise
        return self.words.comma.join([*parts, self.words.otherwise.format(a=self.number(last, ADDED))])

    def _case(self, subject: typed.AnyMember, branches: Sequence[tuple[tuple[str, ...], bool, str]]) -> str:
        asked, parts = self.member(subject), []
        for members, rest, value in branches:
            if rest:
                parts.append(self.words.otherwise.format(a=value))
                continue
            said = self.words.same[0] if len(members) == 1 else self.words.among
            parts.append(self.words.where.format(a=value, b=said.format(a=asked, b=self.listed(members))))
        return self.words.comma.join(parts)

    def _on_line(self, node: typed.OnLine) -> str:
        point, line, words = self.record(node.point), self.line(node.line), self.words
        match node.function:
            case "station":
                return words.station.format(a=point, b=line)
            case "offset":
                return words.offset.format(a=point, b=line)
            case "direction":
                return words.direction.format(a=point, b=line)
            case "distance_to":
                return words.distance.format(a=point, b=line)
            case _:
                assert_never(node.function)

    def _folded(self, node: typed.Folded) -> str:
        among = self._where(self.ranged(node.range), node.where)
        body = "" if node.body is None else self.atom(node.body)
        made = self.words.folds[node.op][node.where is not None].format(a=among, b=body)
        return (
            made if node.otherwise is None else self.words.if_none.format(a=made, b=self.atom(node.otherwise))
        )

    def _where(self, ranged: str, where: typed.Formula | None) -> str:
        return (
            ranged
            if where is None
            else self.words.for_which.format(a=ranged, b=self.formula(where, TOGETHER))
        )

    def _called(self, node: typed.CalledNumber) -> str:
        name = called(self.short(node.symbol))
        if not parameters_of(node.symbol):
            return name
        given = [self.value(one) for one in node.arguments]
        return (self.words.of if len(given) == 1 else self.words.of_several).format(
            a=name, b=self.listed(given)
        )

    def value(self, node: typed.Value) -> str:
        """Anything that is given to a definition, as one word or one that has a letter."""
        match node:
            case typed.NumberNode():
                return self.atom(node)
            case typed.FormulaNode():
                return self._letter(node)
            case typed.Count():
                raise AssertionError("a count is compared, and given to nothing")
            case typed.SignalNode():
                return self.signal(node)
            case typed.RecordNode():
                return self.record(node)
            case typed.MemberNode():
                return self.member(node)
            case typed.LineNode():
                return self.line(node)
            case typed.AreaNode():
                return self.area(node)
            case typed.RegionNode():
                return self.region(node)
            case _:
                assert_never(node)

    # Formulas -----------------------------------------------------------------------------------------------

    def _formula(self, node: typed.Formula, deny: bool = False) -> str:
        words, single = self.words, self._single(node, deny)
        if single is not None:
            return single
        if deny:
            raise AssertionError("what has no word for its contrary is denied by those around it")
        match node:
            case typed.Not():
                if self._deniable(node.operand):
                    return self._formula(node.operand, True)
                # by its letter: what is denied would be heard to go on to the end of the sentence
                return words.condition[1].format(a=self._letter(node.operand))
            case typed.Boolean():
                return words.true if node.value else words.false
            case typed.Chained() if node.ops == ("<=", "<="):
                lower, value, upper = node.operands
                return self._between(value, lower, upper, False)
            case typed.Chained():
                pairs = zip(node.operands, node.ops, node.operands[1:])
                return self.listed(
                    [self._compared(left, words.comparisons[op][0], right) for left, op, right in pairs]
                )
            case typed.Connective():
                return self._connective(node)
            case typed.Quantified():
                return self._quantified(node)
            case typed.FormulaCase():
                branches = [(one.members, one.rest, self.formula(one.value, SINGLE)) for one in node.branches]
                return self._case(node.subject, branches)
            case typed.Temporal():
                return self._timed(
                    words.temporal[node.op], node.window, "bc", a=self.formula(node.operand, SINGLE)
                )
            case typed.Until():
                left, right = self.formula(node.left, SINGLE), self.formula(node.right, SINGLE)
                return self._timed(words.until[node.op], node.window, "cd", a=left, b=right)
            case typed.Step():
                said = words.weak_steps if node.weak else words.steps
                return said[node.op].format(a=self.formula(node.operand, SINGLE))
            case typed.Edge():
                return words.edges[node.op].format(a=self.formula(node.operand, SINGLE))
            case (
                typed.Event() | typed.BooleanField() | typed.Comparison() | typed.Within() | typed.InZone() | typed.InStretch() | typed.Inside()
                | typed.Meets() | typed.ClearOf() | typed.IsMember() | typed.InState() | typed.CountComparison() | typed.CalledFormula()
                | typed.NamedFormula()
            ):  # fmt: skip
                raise AssertionError(f"{type(node).__name__} says one thing")
            case _:
                assert_never(node)

    def _deniable(self, node: typed.Formula) -> bool:
        return not isinstance(
            node,
            typed.Not | typed.Boolean | typed.Chained | typed.Connective | typed.Quantified | typed.FormulaCase | typed.Temporal
            | typed.Until | typed.Step | typed.Edge,
        )  # fmt: skip

    def _single(self, node: typed.Formula, deny: bool) -> str | None:
        """A formula that says one thing, or that it is not so; None for one that says several."""
        words = self.words
        match node:
            case typed.Event():
                return words.holds[deny].format(a=plain(self.short(node.symbol)))
            case typed.BooleanField():
                said = words.own_holds_for if node.name in self.measured else words.holds_for
                return said[deny].format(a=plain(node.name), b=self.record(node.record))
            case typed.Comparison():
                return self._compared(node.left, words.comparisons[node.op][deny], node.right)
            case typed.Within():
                return self._between(node.value, node.lower, node.upper, deny)
            case typed.InZone():
                return words.in_zone[deny].format(a=self.record(node.point), b=self.short(node.zone.symbol))
            case typed.InStretch():
                place = (
                    self.record(node.place)
                    if isinstance(node.place, typed.RecordNode)
                    else self.number(node.place, ADDED)
                )
                return words.in_stretch[deny].format(a=place, b=self._stretch(node))
            case typed.Inside():
                return words.inside[deny].format(a=self.region(node.region), b=self.area(node.area))
            case typed.Meets():
                return words.meets[deny].format(a=self.region(node.region), b=self.area(node.area))
            case typed.ClearOf():
                return words.clear_of[deny].format(a=self.region(node.region), b=self.region(node.other))
            case typed.IsMember():
                return words.same[deny].format(a=self.member(node.left), b=self.member(node.right))
            case typed.InState():
                return words.in_state[deny].format(a=self.machine(node.machine), b=plain(node.state))
            case typed.CountComparison():
                # What is counted stands first: it ends in a comma, which what follows would be taken to belong to.
                op = _TURNED[node.op] if node.turned else node.op
                limit = self.number(node.limit, LISTED)
                return f"{self._counted(node.count)} {words.comparisons[op][deny]} {limit}"
            case typed.CalledFormula():
                return self._holds(node, deny)
            case typed.NamedFormula():
                return words.holds[deny].format(a=plain(node.name))
            case (
                typed.Not() | typed.Boolean() | typed.Chained() | typed.Connective() | typed.Quantified() | typed.FormulaCase()
                | typed.Temporal() | typed.Until() | typed.Step() | typed.Edge()
            ):  # fmt: skip
                return None
            case _:
                assert_never(node)

    def _compared(self, left: typed.Number, verb: str, right: typed.Number) -> str:
        return f"{self.number(left, LISTED)} {verb} {self.number(right, LISTED)}"

    def _between(self, value: typed.Number, lower: typed.Number, upper: typed.Number, deny: bool) -> str:
        ends = {"b": self.atom(lower), "c": self.atom(upper)}
        return self.words.within[deny].format(a=self.number(value, LISTED), **ends)

    def _holds(self, node: typed.CalledFormula, deny: bool) -> str:
        name = plain(self.short(node.symbol))
        if not parameters_of(node.symbol):
            return self.words.holds[deny].format(a=name)
        return self.words.holds_for[deny].format(
            a=name, b=self.listed([self.value(one) for one in node.arguments])
        )

    def _stretch(self, node: typed.InStretch) -> str:
        if node.symbol is not None:
            return self.short(node.symbol)
        return self.ends(node)

    def ends(self, node: typed.InStretch) -> str:
        """`of the centre line of track from 4900 m to 120 m`, also of one that goes by a name."""
        ends = self.atom(node.start), self.atom(node.end)
        return self.words.between_stations.format(a=self.line(node.line), b=ends[0], c=ends[1])

    def _connective(self, node: typed.Connective) -> str:
        words = self.words
        match node.op:
            case "and":
                return self.listed([self.formula(one, SINGLE) for one in _same(node, "and")])
            case "or":
                *others, last = [self.formula(one, SINGLE) for one in _same(node, "or")]
                said = f" {words.joined['or']} "
                return words.either.format(a=said.join([*others, last]))
            case "implies":
                left, right = self.formula(node.left, TOGETHER), self.formula(node.right, TOGETHER)
                return words.joined[node.op].format(a=left, b=right)
            case "iff" | "xor":  # `a and b iff c` has nothing before it that would hold `a and b` together
                left, right = self.formula(node.left, SINGLE), self.formula(node.right, SINGLE)
                said = words.joined[node.op].format(a=left, b=right)
                return said if node.op == "iff" else words.but_not_both.format(a=said)
            case _:
                assert_never(node.op)

    def quantifier(
        self, quantifier: str, range_: typed.Range, where: typed.Formula | None, by: typed.Number | None
    ) -> str:
        """`for every sample p of plan for which ..`."""
        words = self.words
        if by is not None:
            said = words.nearest if quantifier == "for all" else words.some_nearest
            made = said.format(a=self.ranged(range_), b=self.atom(by))
            return made if where is None else words.of_those.format(a=made, b=self.formula(where, TOGETHER))
        ranged = self._where(self.ranged(range_), where)
        some = words.some if len(range_.names) == 1 else words.some_several
        return (words.every if quantifier == "for all" else some).format(a=ranged)

    def _quantified(self, node: typed.Quantified) -> str:
        head = self.quantifier(node.quantifier, node.range, node.where, node.by)
        said = self.words.quantified if node.quantifier == "for all" else self.words.existing
        return said.format(a=head, b=self.formula(node.body))

    def _timed(self, said: tuple[str, str, str], window: typed.Window | None, ends: str, **parts: str) -> str:
        if window is None:
            return said[0].format(**parts)
        if typed.literal(window.lower) == 0.0:
            return said[2].format(**parts, **{ends[1]: self.atom(window.upper)})
        lower, upper = self.atom(window.lower), self.atom(window.upper)
        return said[1].format(**parts, **dict(zip(ends, (lower, upper))))

    def _counted(self, node: typed.Count) -> str:
        made = self.words.count.format(a=self.formula(node.counted, SINGLE))
        if node.window is not None:
            made += self.words.count_last.format(a=self.atom(node.window.upper))
        if node.reset is not None:
            made += self.words.count_since.format(a=self.formula(node.reset, SINGLE))
        return made if node.window is None and node.reset is None else made + self.words.comma.rstrip()

    def kept(self, node: typed.Transition) -> list[str]:
        """What a transition remembers."""
        return [
            self.words.remembers.format(a=self.number(one.value, ADDED), b=called(one.name))
            for one in node.kept
        ]

    def becomes(self, node: typed.Transition) -> str:
        sources = self.listed([f"“{plain(one)}”" for one in node.sources])
        return self.words.becomes.format(a=plain(node.target), b=sources, c=self.formula(node.guard))

    def starts(self, node: typed.Machine) -> str:
        item = node.symbol.item
        assert isinstance(item, ast.State)
        states = self.listed([f"“{plain(one.name)}”" for one in item.states])
        name = called(self.short(node.symbol))
        if node.element is not None:
            assert isinstance(node.element, typed.NamedRecord)
            name = self.words.of_each.format(a=name, b=called(node.element.name))
        started = self.words.starts.format(a=name, b=states, c=plain(item.start.name))
        gap = bridged(item)
        return f"{started} {self.words.bridges.format(a=gap)}" if gap else started


def _same(node: typed.Formula, op: typed.Joining) -> Iterator[typed.Formula]:
    """The parts of `a and b and c`, which is read from the left."""
    if isinstance(node, typed.Connective) and node.op == op:
        yield from _same(node.left, op)
        yield node.right
    else:
        yield node


def _together(node: typed.Formula) -> int:
    """How tightly the sentence of a formula holds together."""
    match node:
        case typed.Connective():
            match node.op:
                case "and":
                    return TOGETHER
                case "or":
                    return ALTERNATIVES
                case "implies" | "iff" | "xor":
                    return OPEN
                case _:
                    assert_never(node.op)
        case (
            typed.Quantified()
            | typed.FormulaCase()
            | typed.Temporal()
            | typed.Until()
            | typed.Step()
            | typed.Edge()
        ):
            return OPEN
        case typed.Chained():
            return TOGETHER
        case (
            typed.Boolean() | typed.Event() | typed.BooleanField() | typed.Comparison() | typed.Within() | typed.InZone() | typed.InStretch()
            | typed.Inside() | typed.Meets() | typed.ClearOf() | typed.IsMember() | typed.InState() | typed.Not() | typed.CountComparison()
            | typed.CalledFormula() | typed.NamedFormula()
        ):  # fmt: skip
            return SINGLE
        case _:
            assert_never(node)


def _letters() -> Iterator[str]:
    """A to Z, then A1 to Z1, and so on."""
    yield from ascii_uppercase
    for number in range(1, 1000):
        yield from (f"{letter}{number}" for letter in ascii_uppercase)
