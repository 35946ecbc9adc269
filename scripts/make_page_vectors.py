"""Write tests/vectors/pages.json: a manifest, its index and pages, and bytes that are no page.

The codec and the viewer are both tested against the file. Run it after a change of docs/format.md, "Index and pages":

    .venv/bin/python scripts/make_page_vectors.py
"""

from __future__ import annotations

import dataclasses
import gzip
import json
from pathlib import Path
from typing import Any

from hgs_core.codec.format.audio import AudioEntry, AudioPiece
from hgs_core.codec.format.growth import first_segments
from hgs_core.codec.format.manifest import Manifest
from hgs_core.codec.format.paging import paged
from server.bench.bench_scene import made_up_scene

OUT = Path(__file__).resolve().parent.parent / "tests" / "vectors" / "pages.json"

FULL = 16  # chunks of a page: two segments


def scene() -> Manifest:
    """Three segments of two seconds with four slices each, and sound."""
    made_up = made_up_scene(6, static_bytes=1200, slice_bytes=90).manifest
    pieces = tuple(AudioPiece(f"{k:064x}", 100 + k, k - 0.5, k + 0.5) for k in range(7))
    return dataclasses.replace(made_up, audio=AudioEntry("opus", 48_000, 1, pieces))


def pages_of(manifest: Manifest) -> dict[str, Any]:
    found = paged(manifest, manifest.to_json(), FULL, 0)
    return {"index": found.index.hex(), "pages": {name: data.hex() for name, data in found.pages.items()}}


def document() -> dict[str, Any]:
    whole = scene()
    beginning = first_segments(whole, 1)
    (page,) = paged(beginning, beginning.to_json(), FULL, 0).pages.values()
    raw = gzip.decompress(page)
    return {
        "manifest": whole.to_json(),
        "whole": pages_of(whole),
        "beginning": pages_of(beginning),
        "refused": {
            "not-gzip": raw.hex(),
            "cut-off": page[:-9].hex(),
            "another-magic": gzip.compress(b"HGSC" + raw[4:], mtime=0).hex(),
            "too-short": gzip.compress(raw[:-1], mtime=0).hex(),
            "more-slices-than-segments-have": gzip.compress(_with(raw, _wholes(raw), 3), mtime=0).hex(),
            "need-of-no-chunk": gzip.compress(_with(raw, _wholes(raw) + 4 * 9, 99), mtime=0).hex(),
        },
    }


def _wholes(raw: bytes) -> int:
    """Where the whole numbers of a page begin: its only segment's slices; chunks and needs of the four; needs."""
    segments, slices, chunks, _, pieces = (int.from_bytes(raw[at : at + 4], "little") for at in range(4, 24, 4))
    return 24 + 16 * (segments + slices + pieces) + 24 * chunks


def _with(raw: bytes, at: int, number: int) -> bytes:
    return raw[:at] + number.to_bytes(4, "little") + raw[at + 4 :]


if __name__ == "__main__":
    OUT.write_text(json.dumps(document(), separators=(",", ":")) + "\n", encoding="utf-8")
