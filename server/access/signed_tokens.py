"""Signed, expiring tokens for links to scenes and browser sessions."""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
from dataclasses import dataclass
from typing import Literal

__all__ = ["SignedToken", "read_token", "sign_token"]

LONGEST_TOKEN = 512  # characters


@dataclass(frozen=True)
class SignedToken:
    """Fields of a token."""

    kind: Literal["link", "session"]
    expires: int  # seconds since the epoch; invalid from then on
    key: str  # id of the key that made it and revokes it; "" for the command line
    scene: str = ""  # links only


def sign_token(token: SignedToken, secret: bytes) -> str:
    """Return the token as URL-safe text: its fields and their HMAC-SHA-256."""
    fields = json.dumps([token.kind, token.expires, token.key, token.scene], separators=(",", ":")).encode()
    return f"{_text(fields)}.{_text(hmac.digest(secret, fields, hashlib.sha256))}"


def read_token(text: str, secret: bytes, now: float) -> SignedToken | None:
    """Return the token in a text, or None if its signature is wrong or it has expired."""
    if len(text) > LONGEST_TOKEN:
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
