"""The end of a benchmark's program: its exit status, and one line for a fault that people can mend."""

from __future__ import annotations

import sys
from collections.abc import Callable

from server.cli.outer_faults import outer_fault

__all__ = ["refusing"]


def refusing(run: Callable[[], int]) -> int:
    """Run a benchmark and return its exit status; 2 after a fault of its input or surroundings.

    Raises:
        Exception: a fault of the program itself.
    """
    try:
        return run()
    except Exception as error:
        if (refusal := outer_fault(error)) is None:
            raise
        print(f"benchmarks: {refusal}", file=sys.stderr)
        return 2
