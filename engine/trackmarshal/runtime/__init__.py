"""Inputs, geometry, verdicts: what evaluation needs at run time."""
