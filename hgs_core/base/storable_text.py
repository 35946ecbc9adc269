"""Text that every database, JSON document and page can hold."""

from __future__ import annotations

import re

from hgs_core.base.errors import InputError

__all__ = ["is_storable", "require_storable"]

# Postgres stores no NUL, UTF-8 no half of a surrogate pair (as which Python reads file names of other encodings).
_UNSTORABLE = re.compile("[\0\ud800-\udfff]")


def is_storable(text: str) -> bool:
    """Return whether the text has neither NUL nor half a surrogate pair."""
    return _UNSTORABLE.search(text) is None


def require_storable(field: str, text: str, longest: int) -> None:
    """Refuse text that cannot be stored, or of more than `longest` characters.

    Raises:
        InputError: names the field.
    """
    if len(text) > longest:
        raise InputError.of_field(field, f"{len(text)} characters are too many", f"give at most {longest}")
    if not is_storable(text):
        raise InputError.of_field(field, f"{text[:80]!a} holds NUL or half a surrogate pair", "give valid UTF-8 text")
