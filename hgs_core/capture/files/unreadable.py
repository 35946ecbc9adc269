"""The error for a file that cannot be read."""

from __future__ import annotations

from pathlib import Path

from hgs_core.base.errors import InputError

__all__ = ["unreadable"]


def unreadable(file: Path, error: Exception, cure: str, what: str = "unreadable") -> InputError:
    """Return the error for a file that could not be read; `cure` is for damage, not for lack of permission."""
    if isinstance(error, PermissionError):
        return InputError(file, "may not be read", "make it readable")
    reason = getattr(error, "strerror", None) or error
    return InputError(file, f"{what} ({reason})", cure)
