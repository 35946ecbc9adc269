"""Write tests/vectors/messages.json: the messages of docs/stream.md as bytes and values, and bytes to be refused.

The server and the viewer are both tested against the file. Run it after a change of the protocol:

    .venv/bin/python scripts/make_message_vectors.py
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import msgpack

from server.protocol.messages import chunk_header

OUT = Path(__file__).resolve().parent.parent / "tests" / "vectors" / "messages.json"

ID = bytes(range(32))
OTHER = bytes(reversed(range(32)))

# Written out rather than taken from the server's classes, which are tested against them.
CLIENT: dict[str, dict[str, Any]] = {
    "hello": {"type": "hello", "protocol": 1, "credits": 65536, "have": [], "parts": [], "rate": 1},
    "hello-of-a-weak-device": {
        "type": "hello",
        "protocol": 1,
        "credits": 65536,
        "have": [],
        "parts": [],
        "rate": 1,
        "splats": 100000,
        "bytes_per_second": 250000,
    },
    "hello-following": {
        "type": "hello",
        "protocol": 1,
        "credits": 65536,
        "have": [],
        "parts": [],
        "rate": 1,
        "follow": True,
    },
    "hello-that-listens": {
        "type": "hello",
        "protocol": 1,
        "credits": 65536,
        "have": [],
        "parts": [],
        "rate": 1,
        "audio": True,
    },
    "hello-resuming": {
        "type": "hello",
        "protocol": 1,
        "credits": 2097152,
        "have": [ID],
        "parts": [[OTHER, 300]],
        "manifest_id": OTHER,
        "time": 1.25,
        "rate": 0.5,
    },
    "hello-resuming-with-pages": {
        "type": "hello",
        "protocol": 1,
        "credits": 2097152,
        "have": [OTHER],
        "parts": [],
        "manifest_id": OTHER,
        "rate": 1,
        "pages": [[ID, b"\x05\x80"], [OTHER, b""]],
    },
    "credit": {"type": "credit", "bytes": 70000},
    "seek": {"type": "seek", "time": 2.5},
    "seek-to-a-whole-second": {"type": "seek", "time": 3},
    "play": {"type": "play", "time": 0.125, "rate": 2},
    "pause": {"type": "pause", "time": 4.75},
    "limits": {"type": "limits", "splats": 100000, "bytes_per_second": 250000, "measured": 180000},
    "limits-lifted": {"type": "limits"},
    "limits-that-listen": {"type": "limits", "measured": 180000, "audio": True},
    "ping": {"type": "ping", "id": 4294967296},
}
SERVER: dict[str, dict[str, Any]] = {
    "welcome": {
        "type": "welcome",
        "protocol": 1,
        "scene": "studio",
        "manifest": b"\x1f\x8b\x08\x00",
        "manifest_id": ID,
        "remaining": 1 << 33,
    },
    "welcome-back": {
        "type": "welcome",
        "protocol": 1,
        "scene": "Ünïcode-ok",
        "manifest": b"",
        "manifest_id": ID,
        "remaining": 0,
    },
    "grow": {"type": "grow", "manifest_id": OTHER, "remaining": 70000, "manifest": b"\x1f\x8b\x08\x00"},
    "slice-base": {"type": "slice", "index": 3, "start": 1.5, "end": 2.0, "layer": 0},
    "slice": {"type": "slice", "index": 3, "start": 1.5, "end": 2.0, "layer": 1},
    "missing": {"type": "missing", "id": OTHER},
    "pong": {"type": "pong", "id": 4294967296},
    "end": {"type": "end", "bytes": 1234567, "left_out": 7000},
    "error": {"type": "error", "code": "malformed", "detail": "hello.credits is missing"},
}
REFUSED_BY_SERVER: dict[str, bytes] = {
    "nothing": b"",
    "a-list": msgpack.packb([1]),
    "no-type": msgpack.packb({"bytes": 1}),
    "unknown-type": msgpack.packb({"type": "weather"}),
    "credit-negative": msgpack.packb({"type": "credit", "bytes": -1}),
    "credit-fraction": msgpack.packb({"type": "credit", "bytes": 1.5}),
    "seek-not-a-number": msgpack.packb({"type": "seek", "time": float("nan")}),
    "seek-null": msgpack.packb({"type": "seek", "time": None}),
    "play-too-fast": msgpack.packb({"type": "play", "time": 0.0, "rate": 17.0}),
    "hello-short-id": msgpack.packb({"type": "hello", "protocol": 1, "credits": 1, "have": [b"short"]}),
    "hello-too-slow": msgpack.packb({"type": "hello", "protocol": 1, "credits": 1, "bytes_per_second": 4095}),
    "hello-pages-without-bits": msgpack.packb({"type": "hello", "protocol": 1, "credits": 1, "pages": [[ID]]}),
    "hello-pages-with-short-id": msgpack.packb({"type": "hello", "protocol": 1, "credits": 1, "pages": [[b"i", b""]]}),
    "hello-follow-of-a-number": msgpack.packb({"type": "hello", "protocol": 1, "credits": 1, "follow": 1}),
    "limits-negative": msgpack.packb({"type": "limits", "splats": -1}),
    "hello-listening-to-a-number": msgpack.packb({"type": "hello", "protocol": 1, "credits": 1, "audio": 1}),
    "limits-listening-to-null": msgpack.packb({"type": "limits", "audio": None}),
    "cut-off": msgpack.packb({"type": "pause", "time": 1.0})[:-3],
    "two-messages": 2 * msgpack.packb({"type": "pause", "time": 1.0}),
}
REFUSED_BY_CLIENT: dict[str, bytes] = {
    "nothing": b"",
    "a-list": msgpack.packb([1]),
    "no-type": msgpack.packb({"bytes": 1}),
    "end-without-bytes": msgpack.packb({"type": "end"}),
    "end-with-text": msgpack.packb({"type": "end", "bytes": "1"}),
    "grow-without-manifest": msgpack.packb({"type": "grow", "manifest_id": ID, "remaining": 1}),
    "missing-with-text": msgpack.packb({"type": "missing", "id": "00"}),
    "cut-off": msgpack.packb({"type": "end", "bytes": 70000})[:-2],
}
# Every code with which a server closes a stream, with the error code before it, and whether a client comes back.
CLOSING: list[tuple[int, str | None, bool]] = [
    (1003, "not-binary", False),
    (1006, None, True),
    (1009, "message-too-large", False),
    (1011, "internal", True),
    (1012, None, True),
    (4000, "malformed", False),
    (4000, "flood", False),
    (4001, "protocol-unsupported", False),
    (4003, "access-ended", False),
    (4004, "scene-not-found", False),
    (4004, "scene-changed", False),
    (4008, "hello-timeout", True),
    (4009, "credit-overflow", False),
]
FRAME = {"id": ID, "offset": 4096, "size": 70000, "payload": b"splats"}


def plain(value: Any) -> Any:
    """Bytes as {"hex": …}, the rest as JSON has it."""
    if isinstance(value, bytes):
        return {"hex": value.hex()}
    if isinstance(value, list):
        return [plain(item) for item in value]
    if isinstance(value, dict):
        return {name: plain(item) for name, item in value.items()}
    return value


def packed(messages: dict[str, dict[str, Any]]) -> list[dict[str, Any]]:
    return [
        {"name": name, "bytes": msgpack.packb(message, use_bin_type=True).hex(), "message": plain(message)}
        for name, message in messages.items()
    ]


def refused(cases: dict[str, bytes]) -> list[dict[str, str]]:
    return [{"name": name, "bytes": message.hex()} for name, message in cases.items()]


def document() -> dict[str, Any]:
    frame = chunk_header(FRAME["id"], FRAME["offset"], FRAME["size"]) + FRAME["payload"]
    return {
        "protocol": 1,
        "client": packed(CLIENT),
        "server": packed(SERVER),
        "refused_by_server": refused(REFUSED_BY_SERVER),
        "refused_by_client": refused(REFUSED_BY_CLIENT),
        "closing": [{"code": code, "error": error, "retry": retry} for code, error, retry in CLOSING],
        "chunk_frame": {"bytes": frame.hex(), "frame": plain(FRAME)},
    }


if __name__ == "__main__":
    OUT.write_text(json.dumps(document(), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
