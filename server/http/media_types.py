"""Content types of the files of the viewer and of published scenes."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["MEDIA_TYPES", "OCTET_STREAM"]

OCTET_STREAM = "application/octet-stream"
"""Media type of chunks, pages and indexes, which have none of their own."""

# The system's table may lack .wasm or call .js text/plain, and browsers then refuse both.
MEDIA_TYPES: Mapping[str, str] = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".ico": "image/x-icon",
    ".jpg": "image/jpeg",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".map": "application/json",
    ".mjs": "text/javascript; charset=utf-8",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8",
    ".wasm": "application/wasm",
    ".webp": "image/webp",
    ".woff2": "font/woff2",
}
"""Media types by file suffix."""
