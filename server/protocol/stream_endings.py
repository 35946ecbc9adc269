"""Endings of a stream: whether the client may reconnect, and a sentence for people."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["meaning", "passes"]

_VERSIONS = "this client and the server are of different versions"
_MEANINGS: Mapping[str, str] = {
    "not-binary": _VERSIONS,
    "message-too-large": _VERSIONS,
    "malformed": _VERSIONS,
    "protocol-unsupported": _VERSIONS,
    "credit-overflow": _VERSIONS,
    "flood": "the server has ended the stream of a client that reads too slowly",
    "access-ended": "the key or link that opened the stream is no longer valid",
    "scene-not-found": "there is no such scene; it may have been deleted",
    "scene-changed": "another scene has taken its place",
}
_BY_CODE: Mapping[int, str] = {  # fallback where no error code has arrived
    1003: "not-binary",
    1009: "message-too-large",
    4000: "malformed",
    4001: "protocol-unsupported",
    4003: "access-ended",
    4004: "scene-not-found",
    4009: "credit-overflow",
}
_OWN_CODES = 4000  # lowest close code of this protocol
_PASSING = frozenset({4008, "internal", "hello-timeout"})


def passes(code: int | str) -> bool:
    """Return whether a client reconnects after a close code, or after an `error` message with this code."""
    if isinstance(code, str):
        return code in _PASSING
    return code in _PASSING or (code < _OWN_CODES and code not in _BY_CODE)


def meaning(code: int | str) -> str:
    """Return the sentence for a close code or an error code; "" for one of a later version."""
    return _MEANINGS.get(_BY_CODE.get(code, "") if isinstance(code, int) else code, "")
