"""Declarations of modules: what must hold of each beyond its syntax, and what it comes to."""
