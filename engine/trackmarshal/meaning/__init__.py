"""What results rest on, as hashes of meaning: a result holds for as long as all of it is the same.

A rule is hashed as what it comes to, definitions put in: neither layout, comments, titles nor reasons count. Beside it stand the
parameters, tables, places and signals that it reads, the constraints on its parameters and tables, and the version of what evaluates it.
"""

from trackmarshal.meaning.inputs import Inputs, key, sha256
from trackmarshal.meaning.rules import Meaning, in_order, of, restricted, whole
from trackmarshal.meaning.tests import fingerprint_of_test
from trackmarshal.meaning.tool import tool

__all__ = [
    "Inputs",
    "Meaning",
    "fingerprint_of_test",
    "in_order",
    "key",
    "of",
    "restricted",
    "sha256",
    "tool",
    "whole",
]
