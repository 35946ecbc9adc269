"""Texts that only a server with the secret can make, and that expire: links to scenes, and sessions of browsers."""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
from dataclasses import dataclass
from typing import Literal

__all__ = ["SignedToken", "read_token", "sign_token"]

LONGEST = 512  # characters


@dataclass(frozen=True)
class SignedToken:
    """What a token says."""

    kind: Literal["link", "session"]
    expires: int  # seconds since the epoch; from then on it says nothing
    key: str  # id of the key that it was made with, and is revoked with; "" for the command line
    scene: str = ""  # of a link


def sign_token(token: SignedToken, secret: bytes) -> str:
    """Return the token as text of URLs: its fields and their HMAC-SHA-256."""
    fields = json.dumps([token.kind, token.expires, token.key, token.scene], separators=(",", ":")).encode()
    return f"{_text(fields)}.{_text(hmac.digest(secret, fields, hashlib.sha256))}"


def read_token(text: str, secret: bytes, now: float) -> SignedToken | None:
    """Return what a text says; None if it was not signed with the secret, or has expired."""
    if len(text) > LONGEST:
        return None
    try:
        fields, signature = (base64.urlsafe_b64decode(part + "=" * (-len(part) % 4)) for part in text.split("."))
    except ValueError:
        return None
    if not hmac.compare_digest(signature, hmac.digest(secret, fields, hashlib.sha256)):
        return None
    token = SignedToken(*json.loads(fields))
    return token if now < token.expires else None


def _text(data: bytes) -> str:
    return base64.urlsafe_b64encode(data).rstrip(b"=").decode()
