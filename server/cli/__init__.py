"""The `hgs` command line: one module per command."""

from server.cli.program import BAD_INPUT, main

__all__ = ["BAD_INPUT", "main"]
