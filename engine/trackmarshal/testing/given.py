"""What a test gives: signals, events, parameters, tables, zones and lines, by the names of its module."""

from __future__ import annotations

import math
from typing import Any, NoReturn

from trackmarshal import typed
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import ParamInfo
from trackmarshal.runtime.settings import check_table
from trackmarshal.semantics.values import Poison
from trackmarshal.syntax import ast
from trackmarshal.syntax.ast import span_of
from trackmarshal.testing.si import table_in_si
from trackmarshal.testing.signals import Signals
from trackmarshal.units import digits, in_full

_KINDS = (ast.Signal, ast.Event, ast.Param, ast.ParamRecord, ast.Table, ast.Place)


class Given(Signals):
    """Reads what a test gives into a case."""

    def give(self, entry: ast.Given, case: dict[str, Any]) -> None:
        """Put what a name is given into a case."""
        symbol = self.scope.find(entry.name)
        item = symbol.item if symbol is not None else None
        if symbol is None or not isinstance(item, _KINDS):
            if entry.name in self.scope.broken:
                raise Poison  # its declaration has an error of syntax
            self._unknown(entry)
        if entry.changes and not (isinstance(item, ast.Signal) and self.spec.signals[item.name].sequence):
            hint = f"give all of `{entry.name}` in one value"
            self.fail(entry.changes[0].span, "`with` changes columns of a timeline", hint)
        many = isinstance(item, (ast.Signal, ast.Event))  # which have no module of their own
        self.meant.name(entry, item.name if many else symbol.qualified)
        match item:
            case ast.Signal():
                case["signals"][entry.name] = self.signal(self.spec.signals[item.name], entry)
            case ast.Event():
                case["signals"][entry.name] = self.truth(entry.value, f"the event `{item.name}`")
            case ast.Param():
                info = self.spec.params.get(symbol.qualified)
                if info is None:
                    raise Poison  # its declaration was reported
                case["params"][symbol.qualified] = self._param(info, entry.value)
            case ast.ParamRecord():
                case["params"] |= self._param_record(symbol, entry.value)
            case ast.Table():
                table = self.spec.tables.get(symbol.qualified)
                if table is None:
                    raise Poison
                rows = self.expressions.each(
                    lambda row: self.pair(row, table.units), self.list_of(entry.value)
                )
                try:
                    check_table(table_in_si(table), rows)
                except TrackmarshalError as error:
                    self.fail(span_of(entry.value), error.message, error.help or "")
                case["tables"][symbol.qualified] = rows
            case ast.Place():
                case["places"][symbol.qualified] = self.points(entry.value)
            case _:
                raise AssertionError(f"a test gives no {type(item).__name__}")

    def _unknown(self, entry: ast.Given) -> NoReturn:
        symbols = {name: self.scope.find(name) for name in self.scope.names()}
        known = [
            name for name, symbol in symbols.items() if symbol is not None and isinstance(symbol.item, _KINDS)
        ]
        hint = close_matches(entry.name, known) or "only what the test's module declares or uses can be given"
        problem = f"`{entry.name}` is no signal, event, parameter, table, zone or line"
        if entry.name in symbols and symbols[entry.name] is None:
            problem = f"`{entry.name}` is declared in several used modules"
            hint = "rename one, or use only one of the modules"
        unknown = self.scope.unknown(entry.name, entry.span.word(entry.name), "name", "")
        if unknown.modules and entry.name not in symbols:
            self.found.append(unknown)
            raise Poison
        self.fail(entry.span.word(entry.name), problem, hint)

    def _param_record(self, symbol: typed.Symbol, value: ast.Expr) -> dict[str, float]:
        """Some fields of a record of parameters, or all; the others stay."""
        if not isinstance(value, ast.RecordValue):
            hint = f"write `{symbol.name} = {{ field: value }}`"
            self.fail(span_of(value), "a record is needed here", hint)
        infos = {
            info.short: info
            for info in self.spec.params.values()
            if info.name.startswith(f"{symbol.qualified}.")
        }
        if not infos:
            raise Poison  # its declaration was reported
        given: dict[str, float] = {}
        for name, each in zip(value.names, value.values):
            info = infos.get(f"{symbol.name}.{name}")
            if info is None:
                fields = [short.partition(".")[2] for short in infos]
                hint = close_matches(name, fields) or f"it has {', '.join(fields)}"
                self.fail(span_of(each), f"`{symbol.name}` has no field `{name}`", hint)
            given[info.name] = self._param(info, each)
        return given

    def _param(self, info: ParamInfo, value: ast.Expr) -> float:
        number = self.number(value, info.unit, f"the parameter `{info.short}`")
        if not math.isfinite(number):
            self.fail(span_of(value), "a parameter is finite")
        lower = -math.inf if info.lower is None else info.lower
        upper = math.inf if info.upper is None else info.upper
        if not lower <= number <= upper:
            limits = ", ".join(digits(end, info.unit) for end in (lower, upper))
            problem = f"{in_full(number, info.unit)} is outside its range [{limits}]{'' if info.unit == '1' else ' ' + info.unit}"
            self.fail(span_of(value), problem, "", info.span.head)
        return number
