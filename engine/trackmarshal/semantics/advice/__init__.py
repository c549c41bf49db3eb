"""Looks for what compiles and is hardly meant: each finding is a warning, which a rule may allow with a reason."""
