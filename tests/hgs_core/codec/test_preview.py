from __future__ import annotations

from pathlib import Path

import numpy as np

from hgs_core.camera import Camera
from hgs_core.codec import EncodeSettings, Utility, decode_scene, encode_scene
from hgs_core.codec.preview import quantised_scene
from hgs_core.scene import HybridScene, Segment
from tests.hgs_core.codec.test_encode import dynamics, statics

TIMES = np.arange(60) / 30


def rows(splats: object) -> np.ndarray:
    """All numbers of a set, one row a splat, in an order that its numbers decide."""
    table = np.concatenate([np.asarray(a).reshape(len(a), -1) for _, a in splats.items()], axis=1)
    return table[np.lexsort(table.T)]


def test_it_is_what_encoding_and_decoding_give(tmp_path: Path, cameras: list[Camera]) -> None:
    given = HybridScene(
        statics(300, 0), (Segment(0.0, 29 / 30, dynamics(200, 1)), Segment(1.0, 59 / 30, dynamics(200, 2)))
    )
    rng = np.random.default_rng(0)
    utility = Utility(rng.lognormal(0, 2, 300), tuple(rng.lognormal(0, 2, 200) for _ in range(2)))
    settings = EncodeSettings(static_chunk_splats=100, small_chunk_splats=20)
    encode_scene(
        given, tmp_path, cameras=cameras, times=TIMES, title="", settings=settings, utility=utility, antialiased=True
    )
    decoded = decode_scene(tmp_path)
    quantised = quantised_scene(given, cameras, TIMES, utility, settings, antialiased=True)
    np.testing.assert_array_equal(rows(quantised.static), rows(decoded.static))
    for mine, other in zip(quantised.segments, decoded.segments, strict=True):
        assert (mine.start, mine.end) == (other.start, other.end)
        np.testing.assert_array_equal(rows(mine.dynamic), rows(other.dynamic))
