"""Content codings (RFC 9110, sections 8.4 and 12.5.3): negotiation and compression."""

from __future__ import annotations

import gzip
import re
from collections.abc import Sequence
from functools import lru_cache

import zstandard

__all__ = ["IDENTITY", "MADE_CODINGS", "compress", "preferred_coding"]

IDENTITY = "identity"
"""Name of an uncoded body."""

MADE_CODINGS = ("zstd", "gzip")
"""Codings supported by `compress`, best first."""

_OFFER = re.compile(r"\s*([!#$%&'*+.^_`|~0-9A-Za-z-]+)\s*(?:;\s*q\s*=\s*([01](?:\.[0-9]{0,3})?)\s*)?", re.IGNORECASE)


def preferred_coding(header: str | None, available: Sequence[str]) -> str:
    """Return the coding of the response: one of `available`, best first, or "identity".

    Args:
        header: the request's Accept-Encoding; None if absent, which requests nothing.
        available: available codings of the body, besides identity.
    """
    if header is None:
        return IDENTITY
    weights: dict[str, float] = {}
    for part in header.split(","):
        match = _OFFER.fullmatch(part)
        if match is not None:  # malformed parts request nothing
            weights[match[1].lower()] = min(float(match[2] or 1), 1.0)
    others = weights.get("*", 0.0)
    best = max(available, key=lambda coding: weights.get(coding, others), default=IDENTITY)
    # An uncoded body is always acceptable, and sent if it has the highest weight.
    weight = weights.get(best, others)
    return best if weight > 0 and weight >= weights.get(IDENTITY, 0.0) else IDENTITY


@lru_cache(maxsize=64)
def compress(body: bytes, coding: str) -> bytes:
    """Return `body` in a coding of `MADE_CODINGS`; recent results are cached, so a manifest is compressed once."""
    return zstandard.ZstdCompressor().compress(body) if coding == "zstd" else gzip.compress(body, 6, mtime=0)
