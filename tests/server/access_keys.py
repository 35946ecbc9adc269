"""Keys in memory that behave as `jobs.records.keys.KeyTable` does."""

from __future__ import annotations

import hashlib
import secrets

from jobs.records.keys import Key, Scope


class FakeKeys:
    """Keys by name; raises `fault` where one is set."""

    def __init__(self) -> None:
        self.keys: dict[str, Key] = {}
        self.fault: Exception | None = None

    def add(self, name: str, *scopes: Scope, expires: float | None = None) -> str:
        identity = secrets.token_hex(6)
        text = f"hgs_{identity}_{secrets.token_urlsafe(32)}"
        digest = hashlib.sha256(text.encode()).hexdigest()
        self.keys[name] = Key(identity, name, frozenset(scopes), digest, 0.0, expires)
        return text

    def all(self) -> list[Key]:
        if self.fault is not None:
            raise self.fault
        return list(self.keys.values())

    def secret(self) -> bytes:
        return b"s" * 32
