"""The first message of the Python client on every connection: its chunks, its playhead, its wishes."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from hgs_core.codec.format.paged_manifest import PagedManifest
from server.protocol.messages import MAX_HAVE, PROTOCOL_VERSION, Hello

__all__ = ["hello_of"]


def hello_of(
    credits: int,
    *,
    paged: PagedManifest | None,
    have: Collection[str],
    parts: Mapping[str, bytearray],
    **wishes: Any,
) -> Hello:
    """Return the hello of a client that has these chunks, and these first bytes of others.

    Chunks that a page lists are named by the page, all others by their ids: of more than a hello may name, those that
    came last. `wishes` are further fields.
    """
    listed = {} if paged is None else paged.listed()
    by_page = {name for names in listed.values() for name in names}
    pages = [] if paged is None else [page.id for page in paged.pages if not paged.lacks(page.id)]
    others = [name for name in (*have, *pages) if name not in by_page and name not in listed]
    return Hello(
        PROTOCOL_VERSION,
        credits,
        have=frozenset(map(bytes.fromhex, others[-MAX_HAVE:])),
        pages={bytes.fromhex(page): _bits(names, have) for page, names in listed.items()},
        parts={bytes.fromhex(name): len(part) for name, part in parts.items()},
        follow=True,
        **wishes,
    )


def _bits(names: Sequence[str], have: Collection[str]) -> bytes:
    """Return which of the names are there, the lowest bit first."""
    whole = sum((name in have) << place for place, name in enumerate(names))
    return whole.to_bytes(-(-len(names) // 8), "little")
