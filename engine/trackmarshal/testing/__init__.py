"""Tests inside specs: the signals that they build, and what they cover."""
