"""Errors of names and modules: what is unknown, declared twice or ambiguous, and files that no `use` finds."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.source import Span


class UnknownName(Diagnostic):
    code = "E201"
    title = "unknown name"
    text = "unknown {what} `{name}`{more}"
    label = "not declared here or in a used module"
    remedy = "{hint}"
    explanation = (
        "Every name must be declared in the module or in one that it uses (`use module.name`). Names of modules used by a "
        "used module are not visible. What one missing `use` or one missing declaration makes unknown is one error, with all places."
    )

    span: Span
    what: str
    name: str
    hint: str = ""
    #: The modules that declare it, one of which could be used.
    modules: tuple[str, ...] = ()
    more: str = ""
    others: tuple[Span, ...] = ()


class Duplicate(Diagnostic):
    code = "E202"
    title = "declared twice"
    text = "{what} `{name}` is declared twice"
    label = "declared again here"
    other_label = "first declared here"
    remedy = "rename one of them"
    explanation = "A name stands for one thing in a module; a rule's name is unique in everything that is checked together."

    span: Span
    other: Span
    what: str
    name: str


class Hides(Diagnostic):
    code = "E222"
    title = "a name that hides another one"
    text = "{what} `{name}` hides the {other_what} `{name}`{where}"
    label = "means something else from here on"
    other_label = "the {other_what} is declared here"
    remedy = "{hint}"
    explanation = (
        "Whatever is visible where a name is declared or bound has another name: of two declarations of one name, a reader takes "
        "one for the other, and a limit that was changed in one place stays what it was in the other. Signals and events are the "
        "same thing in every module, and may be declared again alike."
    )

    span: Span
    other: Span | None
    what: str
    name: str
    other_what: str
    where: str
    hint: str = "rename one of them"


class Ambiguous(Diagnostic):
    code = "E208"
    title = "a name with two meanings"
    text = "`{name}` is declared in {modules}"
    label = "which one?"
    other_label = "one is here"
    remedy = "rename one, or use only one of the modules"
    explanation = "Two used modules declare the same name; nothing is chosen silently."

    span: Span
    other: Span
    name: str
    modules: str
    others: tuple[Span, ...] = ()


class UnknownField(Diagnostic):
    code = "E210"
    title = "unknown field"
    text = "{what} has no field `{name}`"
    label = "it has: {known}"
    remedy = "{hint}"
    explanation = (
        "Only the fields that a signal's declaration lists can be read: they are the input contract."
    )

    span: Span
    what: str
    name: str
    known: str
    hint: str = ""
    others: tuple[Span, ...] = ()


class UnknownMember(Diagnostic):
    code = "E247"
    title = "no such member"
    text = "`{enumeration}` has no member `{name}`"
    label = "it has: {known}"
    remedy = "{hint}"
    explanation = "An enumeration has the members that its declaration lists, and no others: what is asked for, and what data gives, is one of them."

    span: Span
    enumeration: str
    name: str
    known: str
    hint: str = ""


class UnknownReference(Diagnostic):
    code = "E219"
    title = "unknown word"
    text = "{problem}"
    remedy = "{hint}"
    explanation = "Some places take a word from a fixed list, or the name of a rule, an assumption or a reference declared elsewhere."

    span: Span
    problem: str
    hint: str = ""


class ModuleNotFound(Diagnostic):
    code = "E203"
    title = "module not found"
    text = "no module `{name}`"
    label = "looked for {path}"
    remedy = "{hint}"
    explanation = (
        "`use a.b` reads a/b.spec below the folder in which the project's modules start, and where there is none, the library's: "
        "`prelude.*`, `supervisor.*`, `vehicles.*`, `tracks.*` and others come with the tool."
    )

    span: Span
    name: str
    path: str
    hint: str = ""


class ImportCycle(Diagnostic):
    code = "E204"
    title = "modules use each other in a circle"
    text = "import cycle: {cycle}"
    label = "this `use` closes the circle"
    remedy = "{hint}"
    explanation = "Modules are read in an order in which each comes after those that it uses; a circle has no such order."

    span: Span
    cycle: str
    hint: str


class ModuleName(Diagnostic):
    code = "E205"
    title = "the module's name does not fit"
    text = "{problem}"
    other_label = "the other one is here"
    remedy = "{hint}"
    explanation = "A file starts with `module NAME`, once, and a module `a.b` lives in a/b.spec, so that `use a.b` finds it."

    span: Span
    problem: str
    hint: str = ""
    other: Span | None = None
