from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.bench.codec.partial_pictures import BEST, partial_psnr
from hgs_core.codec.format.scene_folder import CHUNKS
from tests.hgs_core.codec.scenes import encode, scene
from tests.synthetic import ring_of_cameras


def test_pictures_are_whole_with_all_chunks_and_lose_more_the_more_are_missing(tmp_path: Path) -> None:
    manifest = encode(scene(120, 60), tmp_path, ring_of_cameras(2, 32, 24))
    chunks = {entry.id: (tmp_path / CHUNKS / entry.id).read_bytes() for entry in manifest.chunks}
    still = [entry.id for entry in manifest.static]
    moment = 0.25
    shown = [
        (moment, set(chunks)),
        (moment, set(chunks) - {still[-1]}),
        (moment, set(chunks) - set(still)),
        (moment, set()),
    ]
    whole, less, moving, nothing = partial_psnr(manifest, chunks, shown)
    assert whole == BEST
    assert whole > less > moving
    assert nothing < less


def test_chunks_that_a_moment_does_not_show_are_not_missed(tmp_path: Path) -> None:
    manifest = encode(scene(60, 40), tmp_path, ring_of_cameras(2, 32, 24))
    chunks = {entry.id: (tmp_path / CHUNKS / entry.id).read_bytes() for entry in manifest.chunks}
    later = {entry.id for piece in manifest.slices if piece.segment == 1 for entry in piece.chunks}
    assert partial_psnr(manifest, chunks, [(0.1, set(chunks) - later)]) == pytest.approx([BEST])
