"""Standard output and error that take any text, and readers that leave early."""

from __future__ import annotations

import codecs
import contextlib
import os
import sys

__all__ = ["accept_any_text", "discard_output", "flush_output"]

_ANY_TEXT = "hgs-any-text"


def accept_any_text() -> None:
    """Make both streams accept any text: bytes of file names as they are, other letters as \\xe9."""
    codecs.register_error(_ANY_TEXT, _any_text)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # None where it is closed, and anything in tests
            stream.reconfigure(errors=_ANY_TEXT)


def flush_output() -> None:
    """Flush the output while a fault can still be reported.

    Raises:
        OSError: standard output takes no more.
    """
    if sys.stdout is not None:
        sys.stdout.flush()


def discard_output() -> None:
    """Discard the buffer: Python would complain about it once more at its end."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def _any_text(error: UnicodeError) -> tuple[str | bytes, int]:
    """Replace the first letter that cannot be said: a byte that Python reads as half a surrogate pair is that byte."""
    assert isinstance(error, UnicodeEncodeError)
    letter = error.object[error.start]
    if 0xDC80 <= ord(letter) <= 0xDCFF:
        return bytes([ord(letter) - 0xDC00]), error.start + 1
    return letter.encode("ascii", "backslashreplace").decode("ascii"), error.start + 1
