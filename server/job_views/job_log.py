"""The end of a job's log, as a terminal would show it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from hgs_core.base.tail import last_lines
from server.http.encodable import encodable

__all__ = ["MOST_LOG_LINES", "log_tail"]

MOST_LOG_LINES = 1000
_MOST_BYTES = 256 << 10
_LONGEST_LINE = 2000  # characters

# Colours are dropped, and a progress bar is reduced to its last state.
_ESCAPES = re.compile(r"\x1b\[[0-9;?]*[ -/]*[@-~]|[\x00-\x08\x0b-\x1f\x7f]")


def log_tail(run: Path, count: int) -> dict[str, Any]:
    """Return at most `count` lines from the end of a run's stage logs, as documented in docs/rest.md."""
    tail = last_lines(run / "stage.log", count, _MOST_BYTES)
    return {"lines": [_shown(line) for line in tail.lines], "complete": tail.whole}


def _shown(line: str) -> Any:
    drawn = line.rstrip("\r").rpartition("\r")[2]
    return encodable(_ESCAPES.sub("", drawn)[:_LONGEST_LINE])
