"""The option --json of commands that measure: text, or JSON to a file or to standard output."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.writable import require_writable_file

__all__ = ["JsonOutput"]


class JsonOutput:
    """Where results go, checked before anything is measured."""

    def __init__(self, option: str | None) -> None:
        """Read the option: None for text alone, "-" for JSON in its place, else the file to write beside the text.

        Raises:
            InputError: the file cannot be one.
        """
        self._alone = option == "-"
        self._file = None if option in (None, "-") else Path(str(option))
        if self._file is not None and (self._file.is_dir() or not self._file.parent.is_dir()):
            raise InputError("--json", f"{self._file} is not a file in a folder that exists")
        if self._file is not None:
            require_writable_file(self._file)

    def show(self, result: Any, text: str) -> None:
        """Print the result in one form, and write the JSON where a file is wanted."""
        written = json.dumps(result, indent=1, allow_nan=False)
        if self._file is not None:
            write_bytes(self._file, written.encode() + b"\n")
        print(written if self._alone else text)
