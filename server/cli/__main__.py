"""`python -m server.cli`, the same as `hgs`."""

import sys

from server.cli.program import main

__all__: list[str] = []

sys.exit(main())
