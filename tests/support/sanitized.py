"""Generated C under the address and undefined-behaviour sanitizers; optimized and with lines for the debugger as `make acceptance` has it, every day with
neither, which compiles in a third of the time: what is found is named by its function, and undefined behaviour by its line."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from unittest import mock

from support.embedded import STRICT
from support.length import amount
from trackmarshal.backends.c import build
from trackmarshal.backends.c.build import EXACT, UNSIGNALLED

FLAGS = (*amount(("-O0",), ("-O1", "-g")), "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def unit(files: Mapping[str, str], name: str, compiler: str) -> Path:
    """The object of one of these generated files under the sanitizers, which compiles without a warning; its capacities are those of its header.

    It is kept by its content, as libraries are: that of all shipped rules takes seconds, and the example and a tape's player are made around the same.
    """
    with mock.patch.dict(os.environ, {"CC": compiler}):
        return build._built(files, [name], [*EXACT, *UNSIGNALLED, *STRICT, *FLAGS, "-c"], "o")
