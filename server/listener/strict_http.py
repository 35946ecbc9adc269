"""Strict request heads (RFC 9112), without the liberties that let a proxy and a server see different requests.

h11 accepts lines that end with LF alone, lines that go on in the next, and a length beside chunks; and it counts bytes
only while something is missing. A rejected request ends its connection, since its end is unknown.
"""

from __future__ import annotations

import re

import h11
from h11._receivebuffer import ReceiveBuffer

__all__ = ["BadRequestError", "StrictConnection"]

HEAD_BYTES = 64 << 10  # the request line and all headers
HEADER_LINES = 128
REQUEST_LINE_BYTES = 8 << 10

_BROKEN_LINE = re.compile(rb"(?<!\r)\n|\r(?!\n|\Z)")
_END = b"\r\n\r\n"


class BadRequestError(h11.RemoteProtocolError):
    """A rejected request; the message is a sentence for the client's developer."""

    def __init__(self, sentence: str, status: int = 400) -> None:
        super().__init__(sentence, error_status_hint=status)


class StrictConnection(h11.Connection):
    """h11's server side, which keeps the reason for its rejection."""

    def __init__(self) -> None:
        super().__init__(h11.SERVER, HEAD_BYTES)
        self._receive_buffer = _StrictLines()
        self.refusal: BadRequestError | None = None

    def next_event(self) -> h11.Event | type[h11.NEED_DATA] | type[h11.PAUSED]:
        """Return the next event.

        Raises:
            RemoteProtocolError: the data is not a request.
        """
        try:
            return super().next_event()
        except BadRequestError as error:
            self.refusal = error
            raise


class _StrictLines(ReceiveBuffer):
    """The receive buffer, from which h11 extracts request heads and trailers."""

    def maybe_extract_lines(self) -> list[bytearray] | None:
        """Return the lines before the first empty one, or None if it has not arrived."""
        if self._data.startswith(b"\r\n"):
            return super().maybe_extract_lines()
        seen = max(0, self._multiple_lines_search - len(_END))
        end = self._data.find(_END, seen)
        head_end = len(self._data) if end < 0 else end
        if _BROKEN_LINE.search(self._data, seen, head_end):
            raise BadRequestError("a line of the request's head does not end with CR LF")
        if head_end > HEAD_BYTES:
            raise BadRequestError(f"the request's head has more than {HEAD_BYTES >> 10} KiB", 431)
        if self._data.find(b"\r\n", 0, REQUEST_LINE_BYTES + 2) < 0 and len(self._data) > REQUEST_LINE_BYTES:
            raise BadRequestError(f"the request's first line has more than {REQUEST_LINE_BYTES >> 10} KiB", 414)
        if self._data.count(b"\r\n", 0, head_end) > HEADER_LINES:
            raise BadRequestError(f"the request has more than {HEADER_LINES} header lines", 431)
        if end < 0:
            self._multiple_lines_search = len(self._data)
            return None
        lines = self._extract(end + len(_END))[: -len(_END)].split(b"\r\n")
        _check(lines)
        return lines


def _check(lines: list[bytearray]) -> None:
    """Reject a head if proxies and servers might disagree about its end or its body's end.

    Raises:
        BadRequestError: the reason.
    """
    if any(line.startswith((b" ", b"\t")) for line in lines):
        raise BadRequestError("a header continues on the next line, which HTTP has not allowed since 2014")
    names = {bytes(line.partition(b":")[0]).strip().lower() for line in lines[1:]}
    if b"transfer-encoding" in names:
        if b"content-length" in names:
            raise BadRequestError("the request has Content-Length and Transfer-Encoding, and may have only one")
        if lines[0].endswith(b"HTTP/1.0"):
            raise BadRequestError("the request has Transfer-Encoding, which HTTP/1.0 does not have")
