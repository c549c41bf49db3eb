"""Expressions of the syntax tree to values of the typed tree: names are resolved, kinds and dimensions checked, definitions written out."""
