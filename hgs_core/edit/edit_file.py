"""Files of edits that a scene's page makes: JSON with a format and a version (docs/editing.md)."""

from __future__ import annotations

import json
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError

__all__ = ["MAX_BYTES", "EditFormat", "read_edit_file", "shown"]

MAX_BYTES = 64 << 20
_VERSION = 1


class EditFormat(StrEnum):
    """The formats of these files."""

    SPLATS = "hgs-splats"
    CROP = "hgs-crop"


def read_edit_file(file: Path, formats: Sequence[EditFormat]) -> dict[str, Any]:
    """Return the fields of a file in one of these formats; both format and version are checked.

    Raises:
        InputError: it is missing, too large, no JSON, or of another format; names the file, the field and the value.
    """
    cure = "give a list of splats" if EditFormat.CROP not in formats else "give a list of splats or a crop"
    try:
        size = file.stat().st_size
        if size > MAX_BYTES:
            raise InputError(file, f"has {size:,} bytes", f"give at most {MAX_BYTES:,}; edit in several steps")
        document: Any = json.loads(file.read_bytes())
    except OSError as error:
        raise InputError(file, f"cannot be read ({error.strerror})", cure) from error
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(file, f"is not JSON ({error})", "save it again on the scene's page") from error
    fields: dict[str, Any] = document if isinstance(document, dict) else {}
    if fields.get("format") not in list(formats):
        expected = " or ".join(repr(one.value) for one in formats)
        raise InputError(f"{file}: format", f"is {shown(fields.get('format'))}, not {expected}", cure)
    version = fields.get("version")
    if version != _VERSION or isinstance(version, bool):
        raise InputError(f"{file}: version", f"is {shown(version)}, not {_VERSION}", cure)
    return fields


def shown(value: Any) -> str:
    """Return a value of a file as JSON, cut short for a message."""
    text = json.dumps(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
