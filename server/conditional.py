"""Conditional and range requests (RFC 9110, sections 13 and 14) for bodies that are named by their SHA-256."""

from __future__ import annotations

import hashlib
import re

from fastapi import Request, Response

from server.problems import ProblemError

__all__ = ["byte_range", "entity_tag", "respond"]

_RANGE = re.compile(r"bytes\s*=\s*(\d*)\s*-\s*(\d*)\s*", re.IGNORECASE)


def entity_tag(body: bytes) -> str:
    """Return the strong ETag of a body: its SHA-256 in quotes."""
    return f'"{hashlib.sha256(body).hexdigest()}"'


def respond(
    request: Request, body: bytes, media_type: str, *, etag: str, cache_control: str, ranges: bool = False
) -> Response:
    """Answer GET or HEAD with the body, the asked part of it (206), or 304 if the client has it.

    Raises:
        ProblemError: 416, a range that begins behind the end.
    """
    headers = {"ETag": etag, "Cache-Control": cache_control}
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
    return Response(body, 200, headers, media_type)


def byte_range(header: str, size: int) -> range | None:
    """Return the bytes that a Range header asks for, or None where the whole body is the answer.

    Several ranges, other units and what does not parse are answered with the whole, as RFC 9110 allows.

    Raises:
        ProblemError: 416, the range begins behind the end of the `size` bytes, or is empty.
    """
    match = _RANGE.fullmatch(header)
    if match is None or not (match[1] or match[2]):
        return None
    if match[1]:
        first = int(match[1])
        last = int(match[2]) if match[2] else size - 1
        if match[2] and last < first:
            return None
    else:
        first, last = max(size - int(match[2]), 0), size - 1
    if first >= size:
        raise ProblemError(
            416,
            "range-not-satisfiable",
            f"Range {header}: the body has {size} bytes",
            headers={"Content-Range": f"bytes */{size}"},
        )
    return range(first, min(last, size - 1) + 1)


def _matches(header: str | None, etag: str) -> bool:
    """Compare weakly, as If-None-Match asks for."""
    if header is None:
        return False
    return header.strip() == "*" or etag in (tag.strip().removeprefix("W/") for tag in header.split(","))
