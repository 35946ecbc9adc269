"""Content codings (RFC 9110, sections 8.4 and 12.5.3): which one a client asks for, and bodies in it."""

from __future__ import annotations

import gzip
import re
from collections.abc import Sequence
from functools import lru_cache

import zstandard

__all__ = ["IDENTITY", "MADE_CODINGS", "compress", "preferred_coding"]

IDENTITY = "identity"
"""The name of a body as it is."""

MADE_CODINGS = ("zstd", "gzip")
"""The codings that `compress` makes, the better one first."""

_OFFER = re.compile(r"\s*([!#$%&'*+.^_`|~0-9A-Za-z-]+)\s*(?:;\s*q\s*=\s*([01](?:\.[0-9]{0,3})?)\s*)?", re.IGNORECASE)


def preferred_coding(header: str | None, available: Sequence[str]) -> str:
    """Return the coding to answer with: one of `available`, best first, or "identity".

    Args:
        header: the request's Accept-Encoding; None where it has none, which asks for nothing.
        available: the codings that there are of the body, beside the body as it is.
    """
    if header is None:
        return IDENTITY
    weights: dict[str, float] = {}
    for part in header.split(","):
        match = _OFFER.fullmatch(part)
        if match is not None:  # what does not parse asks for nothing
            weights[match[1].lower()] = min(float(match[2] or 1), 1.0)
    others = weights.get("*", 0.0)
    best = max(available, key=lambda coding: weights.get(coding, others), default=IDENTITY)
    # A body as it is may always be sent, and is where it is asked for more than any other.
    weight = weights.get(best, others)
    return best if weight > 0 and weight >= weights.get(IDENTITY, 0.0) else IDENTITY


@lru_cache(maxsize=64)
def compress(body: bytes, coding: str) -> bytes:
    """Return `body` in a coding of `MADE_CODINGS`; the last ones are kept, so that a manifest is compressed once."""
    return zstandard.ZstdCompressor().compress(body) if coding == "zstd" else gzip.compress(body, 6, mtime=0)
