"""Parsing and validation of clients' control messages; docs/stream.md is normative."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import msgpack

from server.protocol.messages import (
    DEFAULT_RATE,
    MAX_HAVE,
    MAX_MESSAGE_BYTES,
    MAX_PAGES,
    MAX_PARTS,
    MAX_RATE,
    MIN_RATE_LIMIT,
    PROTOCOL_VERSION,
    ClientMessage,
    Credit,
    Hello,
    Limits,
    Pause,
    Ping,
    Play,
    ProtocolError,
    Seek,
)
from server.protocol.stream_endings import Closing

__all__ = ["decode"]


def decode(message: bytes) -> ClientMessage:
    """Parse a client's control message.

    Raises:
        ProtocolError: too large, not a msgpack map, an unknown type, or a field that is missing or out of range.
    """
    if len(message) > MAX_MESSAGE_BYTES:
        raise ProtocolError(Closing.MESSAGE_TOO_LARGE, f"{len(message)} bytes; at most {MAX_MESSAGE_BYTES} are allowed")
    try:
        fields = msgpack.unpackb(message, raw=False, strict_map_key=True, max_ext_len=0)
    # msgpack's own exceptions are ValueErrors.
    except (ValueError, UnicodeDecodeError) as error:
        raise _malformed(f"not one msgpack value: {type(error).__name__}") from error
    if not isinstance(fields, dict):
        raise _malformed(f"a {type(fields).__name__} instead of a map")
    kind = fields.get("type")
    reader = _READERS.get(kind) if isinstance(kind, str) else None
    if reader is None:
        raise _malformed(f"unknown type {kind!r:.80}")
    return reader(fields)


def _malformed(detail: str) -> ProtocolError:
    return ProtocolError(Closing.MALFORMED, detail)


def _uint(fields: Mapping[str, Any], name: str) -> int:
    return _unsigned(_required(fields, name), f"{fields['type']}.{name}:")


def _optional_uint(fields: Mapping[str, Any], name: str) -> int | None:
    return _uint(fields, name) if name in fields else None


def _rate_limit(fields: Mapping[str, Any]) -> int | None:
    limit = _optional_uint(fields, "bytes_per_second")
    if limit is not None and limit < MIN_RATE_LIMIT:
        raise _malformed(f"{fields['type']}.bytes_per_second: {limit} is less than {MIN_RATE_LIMIT}")
    return limit


def _unsigned(value: Any, name: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise _malformed(f"{name} {value!r:.80} is not an unsigned integer")
    return value


def _number(fields: Mapping[str, Any], name: str) -> float:
    value = _required(fields, name)
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        raise _malformed(f"{fields['type']}.{name}: {value!r:.80} is not a finite number")
    return float(value)


def _rate(fields: Mapping[str, Any]) -> float:
    rate = _number(fields, "rate")
    if not 0 <= rate <= MAX_RATE:
        raise _malformed(f"{fields['type']}.rate: {rate} is not between 0 and {MAX_RATE:g}")
    return rate


def _required(fields: Mapping[str, Any], name: str) -> Any:
    if name not in fields:
        raise _malformed(f"{fields['type']}.{name} is missing")
    return fields[name]


def _have(fields: Mapping[str, Any]) -> frozenset[bytes]:
    value = fields.get("have", [])
    if not isinstance(value, list) or len(value) > MAX_HAVE:
        raise _malformed(f"hello.have is not a list of at most {MAX_HAVE} chunk ids")
    if not all(isinstance(chunk, bytes) and len(chunk) == 32 for chunk in value):
        raise _malformed("hello.have: an id is not 32 bytes of binary")
    return frozenset(value)


def _parts(fields: Mapping[str, Any]) -> dict[bytes, int]:
    value = fields.get("parts", [])
    if not isinstance(value, list) or len(value) > MAX_PARTS:
        raise _malformed(f"hello.parts is not a list of at most {MAX_PARTS} pairs")
    parts = {}
    for pair in value:
        if not isinstance(pair, list) or len(pair) != 2 or not isinstance(pair[0], bytes) or len(pair[0]) != 32:
            raise _malformed("hello.parts: an entry is not a pair of an id of 32 bytes and an offset")
        parts[pair[0]] = _unsigned(pair[1], "hello.parts: an offset")
    return parts


def _pages(fields: Mapping[str, Any]) -> dict[bytes, bytes]:
    value = fields.get("pages", [])
    if not isinstance(value, list) or len(value) > MAX_PAGES:
        raise _malformed(f"hello.pages is not a list of at most {MAX_PAGES} pairs")
    for pair in value:
        two = isinstance(pair, list) and len(pair) == 2 and all(isinstance(part, bytes) for part in pair)
        if not two or len(pair[0]) != 32:
            raise _malformed("hello.pages: an entry is not a pair of an id of 32 bytes and binary")
    return dict(value)


def _manifest_id(fields: Mapping[str, Any]) -> bytes | None:
    value = fields.get("manifest_id")
    if "manifest_id" in fields and not (isinstance(value, bytes) and len(value) == 32):
        raise _malformed("hello.manifest_id is not 32 bytes of binary")
    return value


def _flag(fields: Mapping[str, Any], name: str) -> bool:
    value = fields.get(name, False)
    if not isinstance(value, bool):
        raise _malformed(f"{fields['type']}.{name}: {value!r:.80} is not true or false")
    return value


def _hello(fields: Mapping[str, Any]) -> Hello:
    # The version is checked first: another version may define the other fields differently.
    version = _uint(fields, "protocol")
    if version != PROTOCOL_VERSION:
        detail = f"protocol {version}; this server speaks {PROTOCOL_VERSION} alone"
        raise ProtocolError(Closing.PROTOCOL_UNSUPPORTED, detail)
    return Hello(
        protocol=version,
        credits=_uint(fields, "credits"),
        have=_have(fields),
        parts=_parts(fields),
        pages=_pages(fields),
        manifest_id=_manifest_id(fields),
        time=_number(fields, "time") if "time" in fields else None,
        rate=_rate(fields) if "rate" in fields else DEFAULT_RATE,
        splats=_optional_uint(fields, "splats"),
        bytes_per_second=_rate_limit(fields),
        audio=_flag(fields, "audio"),
        follow=_flag(fields, "follow"),
    )


_READERS: dict[str, Callable[[Mapping[str, Any]], ClientMessage]] = {
    Hello.type: _hello,
    Credit.type: lambda fields: Credit(_uint(fields, "bytes")),
    Seek.type: lambda fields: Seek(_number(fields, "time")),
    Play.type: lambda fields: Play(_number(fields, "time"), _rate(fields)),
    Pause.type: lambda fields: Pause(_number(fields, "time")),
    Limits.type: lambda fields: Limits(
        _optional_uint(fields, "splats"),
        _rate_limit(fields),
        _optional_uint(fields, "measured"),
        _flag(fields, "audio"),
    ),
    Ping.type: lambda fields: Ping(_uint(fields, "id")),
}
