"""`python -m trackmarshal.scenarios.generate DECLARATION RECORDING`: write the recording of a declaration."""

from __future__ import annotations

import sys
from pathlib import Path

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios import recording_io
from trackmarshal.scenarios.generate import generate


def main(arguments: list[str]) -> int:
    """0 when written, 2 when something cannot be used."""
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        declaration, target = map(Path, arguments)
        recording_io.write(recording_io.moved(generate(declaration), declaration, target), target)
    except TrackmarshalError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
