"""Random requests and control frames, some of their parts replaced by values that break programs."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any
from urllib.parse import quote, urlencode

import msgpack
from fastapi import FastAPI

__all__ = ["packed", "random_frame", "random_requests"]

HOSTILE: tuple[Any, ...] = (
    None,
    True,
    -1,
    0,
    2**31,
    2**63,
    2**64 - 1,
    10**400,
    1e308,
    float("nan"),
    float("inf"),
    "",
    "a" * 5000,
    "\x00",
    "\ud800",
    "..",
    "../../etc/passwd",
    "%00",
    "'; --",
    [],
    {},
    [[]] * 50,
    {"a": {"b": {}}},
    "0",
    "-1",
    "1e400",
    "\u202e",
    "🂡" * 20,
)
HEADERS = (
    ("Range", "bytes=0-"),
    ("Range", "bytes=" + "9" * 5000),
    ("If-None-Match", "*"),
    ("If-Range", '"x"'),
    ("Accept", "\xff"),
    ("Accept-Encoding", "gzip;q=" + "9" * 3000),
    ("Origin", "http://["),
    ("Content-Type", "text/plain"),
    ("Authorization", "Bearer hgs_x"),
    ("Last-Event-ID", "99999999999999999999"),
    ("Idempotency-Key", "a"),
    ("Idempotency-Key", "\xe4" * 300),
    ("Cookie", "hgs=\xff"),
    ("Host", "evil.example"),
    ("X-Request-Id", "\x7f"),
    ("Upload-Offset", "-1"),
    ("Content-Length", "5"),
)
MESSAGES: tuple[dict[str, Any], ...] = (
    {
        "type": "hello",
        "protocol": 1,
        "credits": 65536,
        "have": [b"x" * 32],
        "parts": [[b"y" * 32, 5]],
        "manifest_id": b"m" * 32,
        "time": 1.0,
        "rate": 1.0,
        "splats": 5000,
        "bytes_per_second": 9000,
        "follow": True,
    },
    {
        "type": "hello",
        "protocol": 1,
        "credits": 65536,
        "have": [b"x" * 32],
        "pages": [[b"z" * 32, b"\x05"]],
        "follow": True,
        "audio": True,
    },
    {"type": "credit", "bytes": 5000},
    {"type": "seek", "time": 1.5},
    {"type": "play", "time": 0.5, "rate": 1.0},
    {"type": "pause", "time": 0.25},
    {"type": "limits", "splats": 100, "bytes_per_second": 65536, "measured": 100000},
    {"type": "ping", "id": 1},
)


def random_requests(
    app: FastAPI, known: Mapping[str, Sequence[str]], dice: random.Random
) -> Iterator[tuple[str, str, list[tuple[str, str]], bytes]]:
    """Make requests of the server's description without end: method, target, headers and body."""
    described = json.loads(json.dumps(app.openapi()))
    operations = [
        (method.upper(), path, operation)
        for path, methods in described["paths"].items()
        for method, operation in methods.items()
    ]
    while True:
        method, path, operation = dice.choice(operations)
        parts = {name: _odd(dice, dice.choice(known.get(name, ["x"])), 0.2) for name in re.findall(r"{(\w+)}", path)}
        target = path.format(
            **{name: quote(_text(value), safe="", errors="surrogatepass") for name, value in parts.items()}
        )
        names = [one["name"] for one in operation.get("parameters", ()) if one["in"] == "query"]
        names += [name for name in ("limit", "after", "state", "label", "lines", "link", "x") if dice.random() < 0.15]
        if query := [(name, _text(_odd(dice, "1", 0.6))) for name in names if dice.random() < 0.7]:
            target += "?" + urlencode(query, errors="surrogatepass")
        headers = [dice.choice(HEADERS) for _ in range(dice.choice([0, 0, 1, 2]))]
        body = b""
        for kind, content in operation.get("requestBody", {}).get("content", {}).items():
            headers.insert(0, ("Content-Type", kind))
            body = _body(dice, content.get("schema", {}))
        yield dice.choice([method] * 9 + ["PUT"]), target, headers, body


def _body(dice: random.Random, schema: Mapping[str, Any]) -> bytes:
    value = _odd(dice, _value(dice, schema), 0.05)
    data = json.dumps(value).encode()
    if dice.random() < 0.1 and data:
        place = dice.randrange(len(data))
        data = data[:place] + dice.randbytes(dice.randrange(4)) + data[place + dice.randrange(3) :]
    return data


def _value(dice: random.Random, schema: Mapping[str, Any]) -> Any:
    """Return a value of a JSON schema, with odd parts here and there."""
    if "anyOf" in schema:
        schema = dice.choice(schema["anyOf"])
    value: Any = None
    match schema.get("type"):
        case "object":
            named = schema.get("properties", {})
            needed = schema.get("required", ())
            value = {name: _value(dice, named[name]) for name in named if name in needed or dice.random() < 0.4}
            if dice.random() < 0.1:
                value[_text(_odd(dice, "more", 0.5))] = 1
        case "array":
            value = [_value(dice, schema.get("items", {})) for _ in range(dice.choice([0, 1, 2, 30]))]
        case "string":
            value = dice.choice(schema.get("enum", ["x", "a" * dice.randrange(300), "train.iterations"]))
        case "integer" | "number":
            value = dice.choice([0, 1, -1, 7, 0.5, 10**9])
        case "boolean":
            value = dice.random() < 0.5
        case _:
            value = dice.choice(HOSTILE)
    return _odd(dice, value, 0.15)


def _odd(dice: random.Random, value: Any, share: float) -> Any:
    return dice.choice(HOSTILE) if dice.random() < share else value


def _text(value: Any) -> str:
    return value if isinstance(value, str) else f"{value!r:.400}"


def packed(value: Any) -> bytes:
    data: bytes = msgpack.packb(value, use_bin_type=True, unicode_errors="surrogatepass")
    return data


def random_frame(dice: random.Random) -> bytes:
    """Return a control message, three of four of which are mutated: a field, or bytes."""
    message: dict[Any, Any] = dict(dice.choice(MESSAGES[1:] if dice.random() < 0.8 else MESSAGES))
    how = dice.random()
    if how < 0.4:
        name = dice.choice(list(message))
        wild = dice.choice(HOSTILE)
        message[name] = 2**64 - 1 if wild == 10**400 else wild
    elif how < 0.5:
        message.pop(dice.choice(list(message)))
    elif how < 0.55:
        message[dice.choice(["new", 1, b"x"])] = 1
    data = packed(message)
    if dice.random() < 0.2:
        for _ in range(dice.randrange(1, 4)):
            place = dice.randrange(len(data))
            data = data[:place] + dice.randbytes(dice.randrange(3)) + data[place + dice.randrange(1, 3) :] or b"\0"
    return data
