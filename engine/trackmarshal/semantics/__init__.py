"""Meaning: names, dimensions and types; syntax tree to IR."""
