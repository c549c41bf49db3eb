"""The standard library, written in the spec language."""
