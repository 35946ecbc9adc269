"""Endings of a stream: close codes with their error codes, the right to reconnect, and a sentence for people."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum

__all__ = ["Closing", "meaning", "passes"]


class Closing(Enum):
    """The ways in which a server closes a stream: the close code, and the error code of the message before it."""

    NOT_BINARY = 1003, "not-binary"
    MESSAGE_TOO_LARGE = 1009, "message-too-large"
    INTERNAL = 1011, "internal"
    RESTARTING = 1012, None
    MALFORMED = 4000, "malformed"
    FLOOD = 4000, "flood"
    PROTOCOL_UNSUPPORTED = 4001, "protocol-unsupported"
    ACCESS_ENDED = 4003, "access-ended"
    SCENE_NOT_FOUND = 4004, "scene-not-found"
    SCENE_CHANGED = 4004, "scene-changed"
    HELLO_TIMEOUT = 4008, "hello-timeout"
    CREDIT_OVERFLOW = 4009, "credit-overflow"

    def __init__(self, code: int, error: str | None) -> None:
        """Keep the WebSocket close code, and the code of the `error` message; None where none is sent."""
        self.code = code
        self.error = error or ""

    @property
    def passes(self) -> bool:
        """Whether a client reconnects."""
        return self in (Closing.INTERNAL, Closing.RESTARTING, Closing.HELLO_TIMEOUT)


_VERSIONS = "this client and the server are of different versions"
_MEANINGS: Mapping[Closing, str] = {
    Closing.NOT_BINARY: _VERSIONS,
    Closing.MESSAGE_TOO_LARGE: _VERSIONS,
    Closing.MALFORMED: _VERSIONS,
    Closing.PROTOCOL_UNSUPPORTED: _VERSIONS,
    Closing.CREDIT_OVERFLOW: _VERSIONS,
    Closing.FLOOD: "the server has ended the stream of a client that reads too slowly",
    Closing.ACCESS_ENDED: "the key or link that opened the stream is no longer valid",
    Closing.SCENE_NOT_FOUND: "there is no such scene; it may have been deleted",
    Closing.SCENE_CHANGED: "another scene has taken its place",
}
_OWN_CODES = 4000  # lowest close code of this protocol


def _closing(code: int | str) -> Closing | None:
    """Return the way of an error code, or the first one of a close code that arrived without an error."""
    return next((one for one in Closing if code in (one.code, one.error) and code), None)


def passes(code: int | str) -> bool:
    """Return whether a client reconnects after a close code, or after an `error` message with this code."""
    closing = _closing(code)
    if closing is not None:
        return closing.passes
    return isinstance(code, int) and code < _OWN_CODES


def meaning(code: int | str) -> str:
    """Return the sentence for a close code or an error code; "" for one of a later version."""
    closing = _closing(code)
    return "" if closing is None else _MEANINGS.get(closing, "")
