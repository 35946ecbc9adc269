"""The one exception that is the user's to fix."""

from __future__ import annotations

import re

__all__ = ["InputError"]

_BREAKS = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")  # names in files may hold any
_LONGEST = 2000  # characters of a part, paths in it


class InputError(ValueError):
    """Bad input: a file, field or argument that the caller can correct.

    The message is one line: where, what is wrong with which value, and the cure. The command line prints it and
    exits with status 2; the API answers with a 4xx problem document.
    """

    def __init__(self, where: object, problem: str, cure: str = "", field: str = "") -> None:
        """Join `where` (a file, field or argument), `problem` and, if known, `cure` into one line.

        `field` is the dotted name of the wrong field of a request; "" where a file is wrong.
        """
        parts = (where, problem, cure, field)
        self.where, self.problem, self.cure, self.field = (_in_one_line(str(part)) for part in parts)
        super().__init__(f"{self.where}: {self.problem}" + (f"; {self.cure}" if self.cure else ""))

    @classmethod
    def of_field(cls, field: str, problem: str, cure: str = "") -> InputError:
        """Return the error of a field of a request, at the place of the same name."""
        return InputError(field, problem, cure, field)

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, str, str]]:
        """Let the line and the field go from one process to another; of a subclass nothing else."""
        return InputError, (self.where, self.problem, self.cure, self.field)


def _in_one_line(text: str) -> str:
    if len(text) > _LONGEST:
        text = f"{text[: _LONGEST // 2]} ... {text[-_LONGEST // 4 :]}"
    return _BREAKS.sub(lambda found: _escape(found[0]), text)


def _escape(letter: str) -> str:
    """Return the letter as Python writes it; a byte of a file name that is no UTF-8 is that byte, not half a pair."""
    byte = ord(letter) - 0xDC00
    return f"\\x{byte:02x}" if 0x80 <= byte <= 0xFF else ascii(letter)[1:-1]
