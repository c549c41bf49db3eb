"""Meaning: names, dimensions and types; syntax tree to typed tree."""
