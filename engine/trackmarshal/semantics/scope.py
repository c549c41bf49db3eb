"""Which names a module can see, and what they were declared as."""

from __future__ import annotations

import re
from collections.abc import Callable

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.semantics.errors.names import Ambiguous, Duplicate, Hides, UnknownName
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.typed import Symbol
from trackmarshal.units import UNIT_PATTERN, UNITS

#: Declarations that put a name into the module's scope, and what messages call them.
KINDS: dict[type[ast.Item], str] = {
    ast.Enum: "enumeration", ast.Signal: "signal", ast.Course: "course", ast.Event: "event", ast.Param: "parameter", ast.ParamRecord: "record of parameters", ast.Table: "table", ast.Place: "place",
    ast.Stretch: "stretch", ast.Define: "definition", ast.Reference: "reference", ast.State: "state", ast.Shape: "shape", ast.Rulebook: "rulebook",
}  # fmt: skip


#: What a configuration replaces by name, without a `use` of where it is declared.
_REPLACED = (ast.Param, ast.ParamRecord, ast.Table, ast.Place)
#: Names that mean something without being declared, and what.
BUILT_IN = {"pi": "number", "inf": "number", "nan": "number"}


class Scope:
    """The names of one module: its own, then those of the modules that it uses."""

    def __init__(
        self, module: str, found: list[Diagnostic], elsewhere: Callable[[str, str, str], tuple[str, ...]]
    ) -> None:
        self.module = module
        self._elsewhere = elsewhere
        self.own: dict[str, Symbol] = {}
        self.used: dict[str, list[Symbol]] = {}
        #: Names whose declarations have errors of syntax: in this module, and here or in a used one.
        self.own_broken: set[str] = set()
        self.broken: set[str] = set()
        #: Whether a used module could not be loaded: it may declare any name.
        self.incomplete = False
        self._found = found

    def declare(self, name: str, item: ast.Item) -> None:
        known = self.own.get(name)
        if known is not None:
            self._found.append(Duplicate(_head(item), _head(known.item), spoken(item), name))
            return
        if name in BUILT_IN:
            self._found.append(
                Hides(_head(item), None, spoken(item), name, BUILT_IN[name], " of the language")
            )
        self.own[name] = Symbol(item, self.module, f"{self.module}.{name}")

    def use(self, other: Scope) -> None:
        self.broken |= other.own_broken
        for name, symbol in other.own.items():
            symbols = self.used.setdefault(name, [])
            if symbol not in symbols:
                symbols.append(symbol)

    def check_own(self) -> None:
        """Report declarations that hide those of used modules."""
        for name, symbol in self.own.items():
            for other in self.used.get(name, ()):
                if not _same_thing(symbol.item, other.item):
                    hint = "rename one, or remove this one: the other is visible here"
                    if spoken(symbol.item) == spoken(other.item) and isinstance(symbol.item, _REPLACED):
                        hint += f"; where this replaces it (`--with`), leave out `use {other.module}`"
                    self._found.append(_hides(_head(symbol.item), spoken(symbol.item), name, other, hint))

    def check_bound(self, name: str, span: Span, what: str) -> None:
        """Report a variable that hides a declaration, or pi."""
        known = self.own.get(name) or next(iter(self.used.get(name, ())), None)
        if known is not None:
            self._found.append(_hides(span, what, name, known, f"give the {what} a name of its own"))
        elif name in BUILT_IN:
            hint = f"give the {what} a name of its own"
            self._found.append(Hides(span, None, what, name, BUILT_IN[name], " of the language", hint))

    def names(self) -> set[str]:
        return {*self.own, *self.used}

    def names_of(self, kind: type[ast.Item]) -> list[str]:
        """The names of declarations of a kind; none of those that two modules declare."""
        return [
            name
            for name in self.names()
            if (found := self.find(name)) is not None and isinstance(found.item, kind)
        ]

    def knows(self, name: str) -> bool:
        return name in self.own or name in self.used

    def find(self, name: str) -> Symbol | None:
        """The symbol, or None; never reports."""
        if name in self.own:
            return self.own[name]
        found = self.used.get(name, [])
        return found[0] if len(found) == 1 else None

    def look_up(self, name: str, span: Span, what: str, extra: set[str]) -> Symbol | Diagnostic | None:
        """The symbol, or what is wrong with the name, or None when that was reported elsewhere.

        `extra` are other names known at this place.
        """
        if name in self.own:
            return self.own[name]
        found = self.used.get(name, [])
        if len(found) > 1:
            modules = " and ".join(f"`{symbol.module}`" for symbol in found)
            return Ambiguous(span, _head(found[0].item), name, modules)
        if found:
            return found[0]
        if name in self.broken:
            return None  # its declaration has an error of syntax, which was reported
        has_fields = span.file.text[span.end : span.end + 1] == "."
        known = (self._records() | extra) - set(BUILT_IN) if has_fields else self.names() | extra
        listed = "" if has_fields else self._listed(name)
        if listed:  # whatever else has this name in a module that is not used
            return UnknownName(span, what, name, listed)
        hint = close_matches(name, known)
        if self.incomplete and not hint:
            return None  # the module that could not be loaded may declare it
        return self.unknown(name, span, what, hint or (self._to_bind(name) if has_fields else ""))

    def _listed(self, name: str) -> str:
        """How to ask for a member of an enumeration, or a state of a machine, that stands by itself; empty where it is none."""
        items = [*self.own.values(), *(found[0] for found in self.used.values())]
        for item in (symbol.item for symbol in items):
            if isinstance(item, ast.Enum) and name in {member.name for member in item.members}:
                asked = self.field_of(item.name) or "..."
                return (
                    f"it is a member of `{item.name}`: write `{asked} is {name}` for each that is asked for"
                )
            if isinstance(item, ast.State) and name in {state.name for state in item.states}:
                machine = f"{item.name}({item.binder})" if item.binder else item.name
                return (
                    f"it is a state of `{item.name}`: write `{machine} is {name}` for each that is asked for"
                )
        return ""

    def field_of(self, enum: str) -> str:
        """The field that is one of an enumeration, as it is asked for; empty where there is none, several, or one of elements alone."""
        signals = [
            symbol.item
            for symbol in (*self.own.values(), *(each[0] for each in self.used.values()))
            if isinstance(symbol.item, ast.Signal)
        ]
        found = [(item, field) for item in signals for field in item.fields_ if field.type == enum]
        if len(found) != 1 or found[0][0].kind != "state" or found[0][0].many:
            return ""
        item, field = found[0]
        return f"{item.name}.{field.name}"

    def _records(self) -> set[str]:
        """Names that may have fields."""
        no_fields = (ast.Define, ast.Table, ast.Place)
        found = {name: symbol.item for name, symbol in self.own.items()}
        found |= {name: symbols[0].item for name, symbols in self.used.items() if name not in found}
        return {name for name, item in found.items() if not isinstance(item, no_fields)}

    def _to_bind(self, name: str) -> str:
        """How a variable comes to be; empty where there is nothing that it could range over."""
        symbols = [*self.own.items(), *((each, found[0]) for each, found in self.used.items())]
        signals = [(each, symbol.item) for each, symbol in symbols if isinstance(symbol.item, ast.Signal)]
        found = [each for each, item in signals if item.kind in ("trajectory", "series")]
        found += [each for each, item in signals if item.many]
        return f"bind it, such as by `for all {name} in {found[0]}`, or declare it" if found else ""

    def unknown(self, name: str, span: Span, what: str, hint: str) -> UnknownName:
        """What is said of a name that is not declared; a module that declares it comes before names that are alike."""
        modules = self._elsewhere(name, what, self.module)
        if name.lower() in ("true", "false"):
            hint = f"write `{name.lower()}`"
        if what == "function":
            hint = _FOREIGN.get(name, hint)
        hint = _unit_with_blanks(name, span) or hint or "declare it, or `use` the module that declares it"
        return UnknownName(span, what, name, hint, modules)


_LASTS = "what has held for so long is `historically[0 s, 3 s] ...`; how long a `state` is what it is, `time_in(state)`"
#: Functions of other languages, and what to write.
_FOREIGN = {
    "between": "write `x in [a, b]`", "len": "write `count(o in objects)`", "size": "write `count(o in objects)`",
    "changes": "say what begins to hold, as in `rising(race.flag is a)`", "changed": "say what begins to hold, as in `rising(race.flag is a)`",
    "duration": _LASTS, "held": _LASTS, "lasts": _LASTS,
    "before": "what was before now is `once[0 s, 5 s] ...`; what has held since something was, `a since b`",
}  # fmt: skip
_QUOTIENT = re.compile(
    rf"((?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)[ \t]*({UNIT_PATTERN}(?:/{UNIT_PATTERN})*)?[ \t]*/[ \t]*\Z"
)
_EXPONENT = re.compile(r"\^-?[0-9]+|[²³]")


def _unit_with_blanks(name: str, span: Span) -> str:
    """What to write for the `h` of `60 km / h`; empty where it is no such thing."""
    if name not in UNITS:
        return ""
    text = span.file.text
    before = _QUOTIENT.search(text, text.rfind("\n", 0, span.start) + 1, span.start)
    if before is None:
        return f"`{name}` is a unit, and follows a number"
    exponent = _EXPONENT.match(text, span.end)
    unit = f"{before[2] or '1'}/{name}{exponent.group() if exponent else ''}"
    return f"write `{before[1]} {unit}`: there are no blanks in a unit"


def spoken(item: ast.Item) -> str:
    """What messages call a declaration."""
    if isinstance(item, ast.Place):
        return item.kind
    if isinstance(item, ast.Define):
        return "predicate" if item.keyword == "predicate" else "definition"
    return KINDS[type(item)]


def _same_thing(item: ast.Item, other: ast.Item) -> bool:
    """Whether two declarations stand for one thing in the car, or in the library; whether signals agree is checked elsewhere."""
    if isinstance(item, (ast.Signal, ast.Event, ast.Course)):
        return type(item) is type(other)
    return isinstance(item, ast.Reference) and item == other


def _hides(span: Span, what: str, name: str, known: Symbol, hint: str) -> Hides:
    where = f" of `{known.module}`"
    return Hides(span, _head(known.item), what, name, spoken(known.item), where, hint)


def _head(item: ast.Item) -> Span:
    span: Span = item.__dict__["span"]
    return span.head
