"""What a declared name stands for."""

from __future__ import annotations

from trackmarshal.node import Node
from trackmarshal.syntax import ast


class Symbol(Node):
    """A declared name: its declaration and the module it stands in."""

    item: ast.Item
    module: str
    qualified: str

    @property
    def name(self) -> str:
        """The name as declared, without its module."""
        return self.qualified.rpartition(".")[2]
