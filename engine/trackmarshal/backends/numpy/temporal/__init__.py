"""Temporal operators on arrays, along the last axis and on non-uniform samples."""

from trackmarshal.backends.numpy.temporal.carrier import Bound
from trackmarshal.backends.numpy.temporal.extrema import always, eventually, extrema
from trackmarshal.backends.numpy.temporal.shifts import shift
from trackmarshal.backends.numpy.temporal.until import held, since, until
from trackmarshal.backends.numpy.temporal.windows import BoolArray, FloatArray, Windows, windows

__all__ = [
    "BoolArray",
    "Bound",
    "FloatArray",
    "Windows",
    "always",
    "eventually",
    "extrema",
    "held",
    "shift",
    "since",
    "until",
    "windows",
]
