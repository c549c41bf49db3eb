"""Faults to plant into a small complete project, and harmless edits of it, as tables: `tests/acceptance/test_planted_faults.py` plants them."""
