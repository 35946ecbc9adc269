"""Journal of an upload: one line of JSON per announced file, so that a killed server loses none."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path
from typing import Any

__all__ = ["FileJournal"]


class FileJournal:
    """Announced files in order; the last line of a path counts."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def add(self, path: str, size: int, sha256: str) -> None:
        """Append a file.

        Raises:
            OSError: it could not be written; a partial line is removed.
        """
        line = (json.dumps({"path": path, "size": size, "sha256": sha256}, separators=(",", ":")) + "\n").encode()
        with self._file.open("ab", buffering=0) as journal:
            end = journal.tell()
            try:
                if journal.write(line) != len(line):
                    raise OSError(errno.ENOSPC, "the journal of an upload")
            except OSError:
                journal.truncate(end)
                raise

    def read(self) -> list[dict[str, Any]]:
        """Return `path`, `size` and `sha256` of every line; remove an incomplete last line from the file.

        Raises:
            OSError, ValueError: it is damaged.
        """
        lines = self._file.read_bytes() if self._file.is_file() else b""
        whole = lines[: lines.rfind(b"\n") + 1]
        if whole != lines:  # the server was killed while it wrote the last line
            os.truncate(self._file, len(whole))
        return [json.loads(line) for line in whole.splitlines()]
