"""Quality of the first part of a scene's bytes: chunks in the order of the manifest, against any order."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hgs_core.codec.format.manifest import ChunkEntry
from hgs_core.codec.format.scene_folder import load_manifest, read_chunk
from hgs_core.fit.encoding_loss import Loss
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats, joined

__all__ = ["PREFIX_SHARE", "prefix_losses"]

PREFIX_SHARE = 0.25  # share of the static chunks' bytes, and of every slice's
SHUFFLES = 3


def prefix_losses(folder: Path, loss: Loss, seed: int = 0) -> tuple[float, float]:
    """Return the loss in dB of the first quarter of a scene's bytes, in order and, as a mean, shuffled."""
    manifest = load_manifest(folder)
    rng = np.random.default_rng(seed)

    def shown(shuffle: bool) -> float:
        static = [read_chunk(folder, entry).static() for entry in _first(manifest.static, rng if shuffle else None)]
        moving: list[list[DynamicSplats[NDArray[np.float32]]]] = [[] for _ in manifest.segments]
        for piece in manifest.slices:
            chosen = _first(piece.chunks, rng if shuffle else None)
            moving[piece.segment] += [read_chunk(folder, entry).dynamic() for entry in chosen]
        segments = tuple(
            Segment(segment.start, segment.end, joined([DynamicSplats.empty(), *sets]))
            for segment, sets in zip(manifest.segments, moving, strict=True)
        )
        still = joined([StaticSplats.empty(), *static])
        return loss.of(HybridScene(still, segments, manifest.background, manifest.antialiased)).whole

    return shown(False), float(np.mean([shown(True) for _ in range(SHUFFLES)]))


def _first(entries: Sequence[ChunkEntry], rng: np.random.Generator | None) -> list[ChunkEntry]:
    """Return the chunks that fit into the share of all bytes; the first always does."""
    order = list(entries) if rng is None else [entries[i] for i in rng.permutation(len(entries))]
    left = PREFIX_SHARE * sum(entry.bytes for entry in entries)
    found: list[ChunkEntry] = []
    for entry in order:
        if found and entry.bytes > left:
            break
        found.append(entry)
        left -= entry.bytes
    return found
