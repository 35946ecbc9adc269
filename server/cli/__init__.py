"""The `hgs` command line: one module per command."""

import sys

# `python -m server.cli` has put the working directory first on the module path, and is looking for this package.
# What else lies there is none of ours, but in a checkout that is not installed.
if sys.argv[:1] == ["-m"] and not sys.flags.safe_path and __file__ != f"{sys.path[0]}/server/cli/__init__.py":
    del sys.path[0]

from server.cli.program import BAD_INPUT, main

__all__ = ["BAD_INPUT", "main"]
