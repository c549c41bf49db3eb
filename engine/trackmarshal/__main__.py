"""`python -m trackmarshal VERB`: the command, where its folder is not on the path."""

import sys

from trackmarshal.cli.main import main

sys.exit(main())
