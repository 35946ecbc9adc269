"""Strange files: every file of a capture changed in many ways, the same ways in every run."""

from __future__ import annotations

import copy
import json
import random
import re
from collections.abc import Iterator
from typing import Any

__all__ = ["changed"]

STRANGE_VALUES: tuple[Any, ...] = (
    None,
    True,
    "",
    "x",
    "a\0b",
    "a\nb",
    "\ud800",
    "../../x",
    "/etc/passwd",
    "C:\\x\\y.png",
    "n" * 5000,
    -1,
    0,
    1e-320,
    1e308,
    -1e40,
    10**30,
    10**400,
    float("nan"),
    float("inf"),
    [],
    {},
    [[]],
    [None],
    {"a": {"b": []}},
    [1.0] * 4000,
)
STRANGE_WORDS = (
    "nan",
    "inf",
    "-inf",
    "1e308",
    "1e999",
    "-1",
    "0",
    "9" * 400,
    "9" * 5000,
    "x",
    "",
    "#",
    "[",
    "]",
    "{",
    '"',
    "'''",
    ":",
    "a\tb",
    "\u2028",
    "\ud7ff",
    "é",
    "0x10",
    "1_000",
    "1,5",
    "%s",
    "..",
    "[" * 300,
)
_NUMBER = re.compile(r"[-+]?\d[\d.eE+-]*")


def changed(data: bytes, seed: str, count: int) -> Iterator[tuple[str, bytes]]:
    """Yield the name of a change and the changed file, for text and bytes of any kind."""
    chance = random.Random(seed)
    yield from _encodings(data)
    ways = [_cut, _flipped, _inserted, _removed, _doubled]
    text = _text(data)
    if text is not None:
        ways += [_other_number, _other_number, _without_line, _line_twice, _lines_swapped]
        if _is_json(text):
            ways += [_other_value] * 6 + [_without_value] * 2
    for number in range(count):
        way = ways[number % len(ways)]
        yield f"{way.__name__[1:]} {number}", way(chance, data)


def _encodings(data: bytes) -> Iterator[tuple[str, bytes]]:
    yield "empty", b""
    yield "zeros", bytes(len(data))
    yield "mark", b"\xef\xbb\xbf" + data
    yield "nested lists", b"[" * 100_000
    yield "nested objects", b'{"a":' * 100_000
    yield "a dotted key", b"[a" + b".a" * 100_000 + b"]\nb = 1"
    text = _text(data)
    if text is not None:
        for encoding in ("utf-16", "utf-16-be", "utf-32"):
            yield encoding, text.encode(encoding)
        yield "windows", b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode()
        yield "macintosh", text.replace("\n", "\r").encode()
        yield "latin", (text + "# \xe4").encode("latin-1")


def _is_json(text: str) -> bool:
    try:
        json.loads(text)
    except ValueError:
        return False
    return True


def _text(data: bytes) -> str | None:
    try:
        return None if b"\0" in data else data.decode()
    except UnicodeDecodeError:
        return None


def _cut(chance: random.Random, data: bytes) -> bytes:
    return data[: chance.randrange(len(data) + 1)]


def _flipped(chance: random.Random, data: bytes) -> bytes:
    found = bytearray(data)
    for _ in range(chance.choice((1, 1, 2, 8))):
        found[chance.randrange(len(found))] ^= 1 << chance.randrange(8)
    return bytes(found)


def _inserted(chance: random.Random, data: bytes) -> bytes:
    place = chance.randrange(len(data) + 1)
    return data[:place] + chance.randbytes(chance.choice((1, 3, 40))) + data[place:]


def _removed(chance: random.Random, data: bytes) -> bytes:
    place = chance.randrange(len(data) + 1)
    return data[:place] + data[place + chance.choice((1, 4, 60)) :]


def _doubled(chance: random.Random, data: bytes) -> bytes:
    place, end = sorted(chance.randrange(len(data) + 1) for _ in range(2))
    return data[:end] + data[place:]


def _other_number(chance: random.Random, data: bytes) -> bytes:
    text = data.decode()
    places = list(_NUMBER.finditer(text))
    if not places:
        return data
    place = chance.choice(places)
    return (text[: place.start()] + chance.choice(STRANGE_WORDS) + text[place.end() :]).encode()


def _without_line(chance: random.Random, data: bytes) -> bytes:
    lines = data.split(b"\n")
    del lines[chance.randrange(len(lines))]
    return b"\n".join(lines)


def _line_twice(chance: random.Random, data: bytes) -> bytes:
    lines = data.split(b"\n")
    lines.insert(chance.randrange(len(lines) + 1), chance.choice(lines))
    return b"\n".join(lines)


def _lines_swapped(chance: random.Random, data: bytes) -> bytes:
    lines = data.split(b"\n")
    first, second = chance.randrange(len(lines)), chance.randrange(len(lines))
    lines[first], lines[second] = lines[second], lines[first]
    return b"\n".join(lines)


def _other_value(chance: random.Random, data: bytes) -> bytes:
    document = json.loads(data)
    holder, key = _place(chance, document)
    if holder is None:
        return json.dumps(chance.choice(STRANGE_VALUES)).encode()
    holder[key] = copy.deepcopy(chance.choice(STRANGE_VALUES))
    return json.dumps(document).encode()


def _without_value(chance: random.Random, data: bytes) -> bytes:
    document = json.loads(data)
    holder, key = _place(chance, document)
    if holder is not None:
        del holder[key]
    return json.dumps(document).encode()


def _place(chance: random.Random, document: Any) -> tuple[Any, Any]:
    """Return where a value lies that is chosen at any depth, fields near the top as often as those below."""
    holder, key, value = None, None, document
    while isinstance(value, dict | list) and value and (holder is None or chance.random() < 0.75):
        holder = value
        key = chance.choice(list(value)) if isinstance(value, dict) else chance.randrange(len(value))
        value = holder[key]
    return holder, key
