from __future__ import annotations

from pathlib import Path

import numpy as np

from hgs_core.codec import EncodeSettings, SetUtility, Utility, decode_scene, encode_scene
from hgs_core.codec.encoder.decoded_preview import quantised_scene
from hgs_core.scene import HybridScene, Segment
from hgs_core.scene.camera import Camera
from tests.hgs_core.codec.scenes import dynamics, opaque_and_brief, statics

TIMES = np.arange(60) / 30


def measured(rng: np.random.Generator, count: int) -> SetUtility:
    return SetUtility(rng.lognormal(0, 2, count), rng.lognormal(-4, 2, count))


def rows(splats: object) -> np.ndarray:
    """All numbers of a set, one row a splat, in an order that its numbers decide."""
    table = np.concatenate([np.asarray(a).reshape(len(a), -1) for _, a in splats.items()], axis=1)
    return table[np.lexsort(table.T)]


def test_it_is_what_encoding_and_decoding_give(tmp_path: Path, cameras: list[Camera]) -> None:
    given = HybridScene(
        statics(300, 0),
        (Segment(0.0, 29 / 30, dynamics(200, 1)), Segment(1.0, 59 / 30, dynamics(200, 2))),
        antialiased=True,
    )
    rng = np.random.default_rng(0)
    utility = Utility(measured(rng, 300), tuple(measured(rng, 200) for _ in range(2)))
    settings = EncodeSettings(dynamic_share=0.6, static_chunk_splats=100, small_chunk_splats=20)
    encode_scene(given, tmp_path, cameras=cameras, times=TIMES, title="", settings=settings, utility=utility)
    decoded = decode_scene(tmp_path)
    found = quantised_scene(given, cameras, TIMES, utility, settings)
    quantised = found.decoded
    np.testing.assert_array_equal(rows(quantised.static), rows(decoded.static))
    for mine, other in zip(quantised.segments, decoded.segments, strict=True):
        assert (mine.start, mine.end) == (other.start, other.end)
        np.testing.assert_array_equal(rows(mine.dynamic), rows(other.dynamic))


def test_splats_that_decode_to_live_longer_are_cut_as_they_are_encoded(tmp_path: Path, cameras: list[Camera]) -> None:
    given = opaque_and_brief()
    rng = np.random.default_rng(0)
    utility = Utility(measured(rng, 20), (measured(rng, 3000),))
    settings = EncodeSettings(slice_seconds=0.1)
    encode_scene(given, tmp_path, cameras=cameras, times=TIMES[:30], title="", settings=settings, utility=utility)
    decoded = decode_scene(tmp_path).segments[0].dynamic
    quantised = quantised_scene(given, cameras, TIMES[:30], utility, settings).decoded.segments[0].dynamic
    np.testing.assert_array_equal(rows(quantised), rows(decoded))


def test_the_splats_before_quantisation_are_those_given_in_the_order_of_the_decoded(cameras: list[Camera]) -> None:
    given = HybridScene(statics(300, 0), (Segment(0.0, 29 / 30, dynamics(200, 1)),), antialiased=True)
    rng = np.random.default_rng(0)
    utility = Utility(measured(rng, 300), (measured(rng, 200),))
    settings = EncodeSettings(coarseness=0.01, static_chunk_splats=100, small_chunk_splats=20)
    found = quantised_scene(given, cameras, TIMES, utility, settings)
    assert sorted(set(found.static_rows)) == sorted(found.static_rows)
    np.testing.assert_array_equal(found.exact.static.means, given.static.means[found.static_rows])
    moving, coded = found.exact.segments[0].dynamic, found.decoded.segments[0].dynamic
    np.testing.assert_array_equal(moving.time_centers, given.segments[0].dynamic.time_centers[found.dynamic_rows[0]])
    np.testing.assert_array_equal(moving.rgb, given.segments[0].dynamic.rgb[found.dynamic_rows[0]])
    # Axes are named alike, so that what quantisation changes is small number by number.
    assert np.median(np.abs(found.exact.static.quats - found.decoded.static.quats)) < 0.01
    assert np.median(np.abs(moving.rotation[:, 0] - coded.rotation[:, 0])) < 0.01
    assert np.median(np.abs(moving.log_scales - coded.log_scales)) < 0.01


def test_dynamic_splats_have_a_coarseness_of_their_own(cameras: list[Camera]) -> None:
    given = HybridScene(statics(300, 0), (Segment(0.0, 29 / 30, dynamics(200, 1)),), antialiased=True)
    rng = np.random.default_rng(0)
    utility = Utility(measured(rng, 300), (measured(rng, 200),))
    alike, finer, fine = (
        quantised_scene(given, cameras, TIMES, utility, EncodeSettings(coarseness=coarseness, dynamic_share=share))
        for coarseness, share in ((2.0, 1.0), (2.0, 0.25), (0.5, 1.0))
    )
    np.testing.assert_array_equal(finer.decoded.static.means, alike.decoded.static.means)
    np.testing.assert_array_equal(finer.decoded.segments[0].dynamic.rgb, fine.decoded.segments[0].dynamic.rgb)
    np.testing.assert_array_equal(finer.dynamic_rows[0], fine.dynamic_rows[0])
