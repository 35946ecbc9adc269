"""The text files of a capture, read within bounds: strangers' files are measured before they are parsed.

| text           | most bytes | most values | why                                                                |
|----------------|------------|-------------|--------------------------------------------------------------------|
| JSON           | 32 MiB     | 1 million   | 40,000 pictures with their poses; parsed it takes up to 300 MB     |
| TOML, YAML     | 4 MiB      |             | 1,000 cameras take 1 MiB                                           |
| tables by line | 1 GiB      |             | read line by line; a line of more than 64 KiB is cut, and said so  |

Text is UTF-8, with a byte order mark or without, or UTF-16 with its byte order mark; lines end as on any system.
"""

from __future__ import annotations

import codecs
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.capture.files.unreadable import unreadable

__all__ = ["LONGEST_LINE", "begins_with", "read_json", "read_text", "read_toml", "text_lines"]

LONGEST_LINE = 1 << 16
"""The most characters of a line that `text_lines` yields; the rest is dropped."""

_MOST_BYTES = 4 << 20
_MOST_JSON_BYTES = 32 << 20
_MOST_JSON_VALUES = 1_000_000
_MOST_BYTES_BY_LINE = 1 << 30
_MARKS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_MARK_OF_UTF32 = codecs.BOM_UTF32_LE
_WHOLE_DIGITS = 18  # digits of whole numbers in 64 bits
_DEEPEST_KEY = 32  # tables within tables, which TOML can name in one line


def read_text(file: Path, cure: str, most_bytes: int = _MOST_BYTES) -> str:
    """Return the text of a file, its lines ended by a line feed.

    Raises:
        InputError: the file is missing, larger than `most_bytes`, or not text; `cure` is for damage.
    """
    try:
        with file.open("rb") as opened:
            data = opened.read(most_bytes + 1)
    except OSError as error:
        raise unreadable(file, error, cure) from error
    if len(data) > most_bytes:
        raise _too_large(file, file.stat().st_size, most_bytes, cure)
    try:
        text = data.decode(_encoding(file, data[:4]))
    except UnicodeDecodeError as error:
        raise _no_text(file, error) from error
    _require_no_nul(file, text)
    return text.replace("\r\n", "\n").replace("\r", "\n")


def begins_with(file: Path, start: str) -> bool:
    """Whether a file is there and begins with a text."""
    try:
        with file.open("rb") as opened:
            head = opened.read(2 * len(start) + 4)
        return head.decode(_encoding(file, head[:4]), "ignore").startswith(start)
    except (OSError, InputError):
        return False


def text_lines(file: Path, cure: str) -> Iterator[str]:
    """Yield the lines of a file without line endings, long ones cut to `LONGEST_LINE` characters.

    Raises:
        InputError: as `read_text`.
    """
    try:
        if (size := file.stat().st_size) > _MOST_BYTES_BY_LINE:
            raise _too_large(file, size, _MOST_BYTES_BY_LINE, cure)
        with file.open("rb") as raw:
            encoding = _encoding(file, raw.read(4))
        with file.open(encoding=encoding) as opened:
            while line := opened.readline(LONGEST_LINE):
                whole = line.endswith("\n")
                _require_no_nul(file, line)
                yield line.rstrip("\n")
                while not whole and (rest := opened.readline(LONGEST_LINE)):
                    whole = rest.endswith("\n")
    except UnicodeDecodeError as error:
        raise _no_text(file, error) from error
    except OSError as error:
        raise unreadable(file, error, cure) from error


def read_json(file: Path, cure: str) -> Any:
    """Return the value of a JSON file; whole numbers of more than 18 digits become floats.

    Raises:
        InputError: as `read_text`, or the text is no JSON, names a key twice, is nested too deep, or has too many
            values.
    """
    text = read_text(file, cure, _MOST_JSON_BYTES)
    values = text.count(",") + text.count("[") + text.count("{")
    if values > _MOST_JSON_VALUES:
        problem = f"has about {values} values, and {_MOST_JSON_VALUES} are the most that are read"
        raise InputError(file, problem, "name each camera once, with its video or its folder of pictures")
    try:
        return json.loads(text, parse_int=_whole_number, object_pairs_hook=_unique)
    except RecursionError as error:
        raise _nested(file, cure) from error
    except ValueError as error:
        raise unreadable(file, error, cure) from error


def read_toml(file: Path, cure: str) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Raises:
        InputError: as `read_text`, or the text is no TOML, or is nested too deep.
    """
    text = read_text(file, cure)
    keys = (line.partition("=")[0] for line in text.split("\n"))
    if any(key.count(".") > _DEEPEST_KEY and "," not in key for key in keys):
        raise _nested(file, cure)
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise _nested(file, cure) from error
    except ValueError as error:
        raise unreadable(file, error, cure) from error


def _encoding(file: Path, head: bytes) -> str:
    if head.startswith(_MARK_OF_UTF32) or head == codecs.BOM_UTF32_BE:
        raise InputError(file, "is UTF-32, which is not read", "save it as UTF-8")
    return next((encoding for mark, encoding in _MARKS if head.startswith(mark)), "utf-8")


def _require_no_nul(file: Path, text: str) -> None:
    if "\0" in text:
        problem = "holds NUL bytes: it is no text, or UTF-16 without a byte order mark"
        raise InputError(file, problem, "save it as UTF-8")


def _no_text(file: Path, error: UnicodeDecodeError) -> InputError:
    place = f"byte {error.start} is 0x{error.object[error.start]:02x}"
    return InputError(file, f"is not UTF-8 ({place}: {error.reason})", "save it as UTF-8")


def _too_large(file: Path, size: int, most: int, cure: str) -> InputError:
    return InputError(file, f"has {size} bytes, and {most} are the most that are read", cure)


def _nested(file: Path, cure: str) -> InputError:
    return InputError(file, "its lists or tables are nested too deep to be read", cure)


def _whole_number(digits: str) -> int | float:
    return int(digits) if len(digits) <= _WHOLE_DIGITS else float(digits)


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for place, name in enumerate(names) if name in names[:place])
        raise ValueError(f"{twice!a} is there twice in one object")
    return found
