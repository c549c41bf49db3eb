"""Generated C under the address and undefined-behaviour sanitizers; optimized as `make acceptance` has it, every day not, which compiles in half the time."""

from __future__ import annotations

from support.length import amount

FLAGS = (amount("-O0", "-O1"), "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
