"""Requirements as ReqIF 1.2, through the package `reqif` (the extra `trackmarshal[exchange]`), which is imported late.

A list of requirements is a specification, a requirement an object of the type `Requirement`, and what it refines a relation of the type `refines`.
"""

from __future__ import annotations

from importlib import import_module

from trackmarshal.trace.exchange.content import Naming
from trackmarshal.trace.exchange.refused import Refused

#: Names that ReqIF's implementation guide gives to what everybody has.
STANDARD = {"id": "ReqIF.ForeignID", "title": "ReqIF.Name", "statement": "ReqIF.Text"}
#: What relations to what a requirement refines are called.
REFINES = "refines"


def require(shown: str) -> None:
    """Raise T359 where the package is not installed."""
    try:
        import_module("reqif.parser")
    except ImportError:
        raise Refused(
            "T359",
            "ReqIF is read and written by the package `reqif`, which is not installed",
            shown,
            help="pip install 'trackmarshal[exchange]'",
        ) from None


def named(naming: Naming) -> Naming:
    """The names of fields without those that are read so anyway, such as `ReqIF.Text`."""
    fields = {ours: theirs for ours, theirs in naming.fields.items() if STANDARD.get(ours) != theirs}
    return Naming(fields, naming.defaults)
