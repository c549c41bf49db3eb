"""Generated C under the address and undefined-behaviour sanitizers; optimized and with lines for the debugger as `make acceptance` has it, every day with
neither, which compiles in a third of the time: what is found is named by its function, and undefined behaviour by its line."""

from __future__ import annotations

from support.length import amount

FLAGS = (*amount(("-O0",), ("-O1", "-g")), "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
