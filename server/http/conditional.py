"""Conditional and range requests (RFC 9110, sections 13 and 14), and the choice of a content coding."""

from __future__ import annotations

import hashlib
import json
import re
from typing import Any

from fastapi import Request, Response

from server.http.content_coding import IDENTITY, MADE_CODINGS, compress, preferred_coding
from server.http.problems import ProblemError

__all__ = ["byte_range", "entity_tag", "respond", "respond_compressed", "respond_json"]

_RANGE = re.compile(r"bytes\s*=\s*([0-9]*)\s*-\s*([0-9]*)\s*", re.IGNORECASE)
_DIGITS = 18  # more than any body size has; Python refuses to parse more than 4300
_WORTH_COMPRESSING = 1024  # bytes: less fits into one packet anyway


def entity_tag(body: bytes) -> str:
    """Return the strong ETag of a body: its SHA-256 in quotes."""
    return f'"{hashlib.sha256(body).hexdigest()}"'


def respond_json(request: Request, value: Any) -> Response:
    """Respond to GET or HEAD with JSON, compressed if the client accepts it, or with 304 if the client has it."""
    body = json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode(errors="replace")
    return respond_compressed(request, body, "application/json")


def respond_compressed(request: Request, body: bytes, media_type: str) -> Response:
    """Respond to GET or HEAD with text of any size in the client's preferred coding, or with 304 if it has that."""
    available = MADE_CODINGS if len(body) >= _WORTH_COMPRESSING else ()
    coding = preferred_coding(request.headers.get("Accept-Encoding"), available)
    coded = body if coding == IDENTITY else compress(body, coding)
    return respond(request, coded, media_type, etag=entity_tag(coded), cache_control="no-cache", coding=coding)


def respond(
    request: Request,
    body: bytes,
    media_type: str,
    *,
    etag: str,
    cache_control: str,
    coding: str | None = None,
    ranges: bool = False,
) -> Response:
    """Respond to GET or HEAD with the body, the requested range (206), or 304 if the client has it.

    Args:
        request: the request.
        body: the bytes to send, in the content coding `coding`.
        media_type: media type of the body before coding.
        etag: entity tag of exactly these bytes.
        cache_control: value of the Cache-Control header.
        coding: coding negotiated by Accept-Encoding; None where there is no choice.
        ranges: whether range requests are allowed.

    Raises:
        ProblemError: 416, the range begins after the end.
    """
    headers = {"ETag": etag, "Cache-Control": cache_control}
    if coding is not None:
        headers["Vary"] = "Accept-Encoding"
    if ranges:
        headers["Accept-Ranges"] = "bytes"
    if _matches(request.headers.get("If-None-Match"), etag):
        return Response(status_code=304, headers=headers)
    asked = request.headers.get("Range") if ranges and request.method == "GET" else None
    if asked is not None and request.headers.get("If-Range", etag) == etag:
        part = byte_range(asked, len(body))
        if part is not None:
            headers["Content-Range"] = f"bytes {part.start}-{part.stop - 1}/{len(body)}"
            return Response(body[part.start : part.stop], 206, headers, media_type)
    if coding not in (None, IDENTITY):
        headers["Content-Encoding"] = coding
    return Response(body, 200, headers, media_type)


def byte_range(header: str, size: int) -> range | None:
    """Return the bytes requested by a Range header, or None to send the whole body.

    Several ranges, other units and malformed headers get the whole body, as RFC 9110 allows.

    Raises:
        ProblemError: 416, the range begins after the end of the `size` bytes, or is empty.
    """
    match = _RANGE.fullmatch(header)
    if match is None or not (match[1] or match[2]):
        return None
    if match[1]:
        first = _number(match[1])
        last = _number(match[2]) if match[2] else size - 1
        if match[2] and last < first:
            return None
    else:
        first, last = max(size - _number(match[2]), 0), size - 1
    if first >= size:
        raise ProblemError(
            416,
            "range-not-satisfiable",
            f"Range {header[:80]}: the body has {size} bytes",
            headers={"Content-Range": f"bytes */{size}"},
        )
    return range(first, min(last, size - 1) + 1)


def _number(digits: str) -> int:
    """Parse a position; positions too long for any body are cut, and still lie after its end."""
    return int(digits.lstrip("0")[: _DIGITS + 1] or "0")


def _matches(header: str | None, etag: str) -> bool:
    """Compare weakly, as If-None-Match requires."""
    if header is None:
        return False
    return header.strip() == "*" or etag in (tag.strip().removeprefix("W/") for tag in header.split(","))
