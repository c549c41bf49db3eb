"""One cause, one finding: what follows from one missing declaration is told once, with all of its places."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from typing import Any

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.semantics.errors.names import Ambiguous, UnknownField, UnknownName
from trackmarshal.semantics.warnings.numbers import BareAngle
from trackmarshal.source import Span


def told_once(found: Iterable[Diagnostic], before: Iterable[Diagnostic] = ()) -> list[Diagnostic]:
    """Diagnostics in the order of places, those with one cause as one; without those whose cause stands in `before`."""
    known = [set(_could_use(item)) for item in before if _could_use(item)]
    # Whichever of the modules that were asked for is used, it declares this too.
    fresh = [item for item in found if not any(one.issubset(_could_use(item)) for one in known)]
    wanted = Counter(pair for item in fresh for pair in _could_use(item))
    told: set[object] = {_cause(item) for item in before if isinstance(item, _FOLDED)}
    told |= {_of_declaration(one) for item in before if _others(item) for one in _declared(item)}
    often = Counter(_of_declaration(one) for item in fresh for one in _declared(item))
    groups: dict[object, list[Diagnostic]] = {}
    for item in sorted((_most_wanted(item, wanted) for item in fresh), key=place):
        groups.setdefault(_badly_declared(item, often, told) or _cause(item), []).append(item)
    return [_together(group) for cause, group in groups.items() if cause not in told]


def place(item: Diagnostic) -> tuple[str, int, str]:
    """Where a diagnostic stands among others."""
    return _file(item), item.span.start, item.code


_FOLDED = (UnknownName, Ambiguous, UnknownField, BareAngle)


def _file(item: Diagnostic) -> str:
    return item.span.file.path


def _could_use(item: Diagnostic) -> list[tuple[str, str]]:
    """The modules, each with the file that could use it, of which one would make a name known."""
    return [(_file(item), module) for module in item.modules] if isinstance(item, UnknownName) else []


def _most_wanted(item: Diagnostic, wanted: Counter[tuple[str, str]]) -> Diagnostic:
    """Of several modules that declare an unknown name, those that would make most other names known too."""
    if not isinstance(item, UnknownName) or len(item.modules) < 2:
        return item
    most = max(wanted[pair] for pair in _could_use(item))
    best = tuple(module for module in item.modules if wanted[_file(item), module] == most)
    return UnknownName(**{**item.__dict__, "modules": best})


def _cause(item: Diagnostic) -> object:
    """What diagnostics have in common that have one cause; what is found at each use of a definition stands at one place."""
    if isinstance(item, UnknownName):
        return (
            ("use", _file(item), item.modules)
            if item.modules
            else ("name", _file(item), item.name, item.hint)
        )
    if isinstance(item, Ambiguous):
        return "ambiguous", _file(item), item.name
    if isinstance(item, UnknownField):
        return "field", _file(item), item.message
    if isinstance(item, BareAngle) and item.what:
        return "angle", _file(item), item.what
    return *place(item), item.span.end, item.message


#: From so many places on that ask for the same, a declaration is taken for the cause; two may be two slips.
_OFTEN = 3
#: What is declared: its name, where, as what, and what it meets.
_Declared = tuple[str, Span, str, str]


def _declared(item: Diagnostic) -> tuple[_Declared, ...]:
    found: tuple[_Declared, ...] = item.__dict__.get("declared", ())
    return found


def _others(item: Diagnostic) -> tuple[Span, ...]:
    found: tuple[Span, ...] = item.__dict__.get("others", ())
    return found


def _of_declaration(declared: _Declared) -> object:
    _, span, own, other = declared
    return "declared", span.file.path, span.start, own, other


def _badly_declared(item: Diagnostic, often: Counter[object], told: Collection[object]) -> object:
    """The declaration that is the cause of other errors, too: of the two things that are compared, the one that meets the same in most places."""
    causes = [_of_declaration(one) for one in _declared(item)]
    known = next((cause for cause in causes if cause in told), None)
    most = max(causes, key=often.__getitem__, default=None)
    return known or (most if most is not None and often[most] >= _OFTEN else None)


def _together(group: Sequence[Diagnostic]) -> Diagnostic:
    """The first of some diagnostics, with the places of the others."""
    first = group[0]
    if len(group) > 1 and _declared(first):
        return _of_one_declaration(group)
    if not isinstance(first, _FOLDED):
        return first
    places = {(item.span.start, item.span.end): item.span for item in group}
    values: dict[str, Any] = {**first.__dict__, "others": tuple(places.values())[1:]}
    if isinstance(first, UnknownName) and first.modules:
        names = {item.name for item in group if isinstance(item, UnknownName)}
        declared = " and ".join(f"`{module}`" for module in first.modules)
        verb = "declares" if len(first.modules) == 1 else "declare"
        if len(names) > 1:
            values["more"] = f", and {len(names) - 1} more that {declared} {verb}"
        values["hint"] = _use(first.modules, "them" if len(names) > 1 else "it")
    return type(first)(**values)


def _of_one_declaration(group: Sequence[Diagnostic]) -> Diagnostic:
    """The first of some diagnostics about one thing, which says where that is declared."""
    first = group[0]
    common = set.intersection(*({_of_declaration(one) for one in _declared(item)} for item in group))
    declared = tuple(one for one in _declared(first) if _of_declaration(one) in common)
    places = {(item.span.start, item.span.end): item.span for item in group}
    as_ = ", and ".join(f"`{name}` is declared as {own}, {span}" for name, span, own, _ in declared)
    values = {
        **first.__dict__, "others": tuple(places.values())[1:], "hint": f"{as_}: mend {'that' if len(declared) == 1 else 'one of them'}, or each of these places", "declared": declared,
    }  # fmt: skip
    return type(first)(**values)


def _use(modules: tuple[str, ...], it: str) -> str:
    if len(modules) == 1:
        return f"add `use {modules[0]}`, which declares {it}"
    listed = " or ".join(f"`use {module}`" for module in modules)
    return f"add {listed}: each declares {it}"


__all__ = ["place", "told_once"]
