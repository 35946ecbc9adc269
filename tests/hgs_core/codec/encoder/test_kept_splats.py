"""Splats left out of an encoded scene: the others decode to the same bits."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.arrays import Mask
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.codec.encoder.kept_splats import kept_chunks
from hgs_core.scene import HybridScene
from hgs_core.scene.camera import Camera
from hgs_core.scene.temporal import evaluate, lifetime
from tests.hgs_core.codec.scenes import encode, scene


def masks(given: HybridScene, share: float) -> tuple[Mask, list[Mask]]:
    """Random splats of each set."""
    r = np.random.default_rng(7)
    return r.random(len(given.static)) < share, [r.random(len(one.dynamic)) < share for one in given.segments]


def same_bits(left: object, right: object) -> bool:
    pairs = [(getattr(left, one.name), getattr(right, one.name)) for one in dataclasses.fields(left)]  # type: ignore[arg-type]
    return all(a.tobytes() == b.tobytes() for a, b in pairs)


@pytest.mark.parametrize("coefficients", [4, 6])
@pytest.mark.parametrize("share", [0.5, 0.02])
def test_kept_splats_decode_to_the_same_bits(
    tmp_path: Path, cameras: list[Camera], coefficients: int, share: float
) -> None:
    encode(scene(coefficients=coefficients), tmp_path / "before", cameras)
    before = decode_scene(tmp_path / "before")
    static, moving = masks(before, share)
    encode(before, tmp_path / "after", cameras, chunks=kept_chunks(tmp_path / "before", static, moving))
    after = decode_scene(tmp_path / "after")
    assert 0 < len(after.static) < len(before.static)
    assert same_bits(after.static, before.static.take(static))
    for kept, segment, mask in zip(after.segments, before.segments, moving, strict=True):
        wanted = segment.dynamic.take(mask)
        length = kept.dynamic.motion.shape[1]  # the fifth order may be gone with its splats
        assert not wanted.motion[:, length:].any()
        assert same_bits(kept.dynamic, dataclasses.replace(wanted, motion=wanted.motion[:, :length]))


def test_boxes_fit_the_splats_that_are_left_and_needs_name_chunks_that_are_there(
    tmp_path: Path, cameras: list[Camera]
) -> None:
    encode(scene(), tmp_path / "before", cameras)
    before = decode_scene(tmp_path / "before")
    static = before.static.means[:, 0] > 0
    static[: load_manifest(tmp_path / "before").static[0].splats] = False  # a whole chunk
    moving = [one.dynamic.time_centers > 0.5 for one in before.segments]
    manifest = encode(before, tmp_path / "after", cameras, chunks=kept_chunks(tmp_path / "before", static, moving))
    assert all(chunk.box[0][0] > -1e-6 for chunk in manifest.static)
    there = {chunk.id for chunk in manifest.chunks}
    assert all(one in there for piece in manifest.slices for one in piece.needs)
    assert len(load_manifest(tmp_path / "before").chunks) > len(there) > 0
    after = decode_scene(tmp_path / "after")
    for number, segment in enumerate(after.segments):
        boxes = [chunk.box for piece in manifest.slices if piece.segment == number for chunk in piece.chunks]
        low, high = np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)
        start, end = (np.clip(t, 0.0, 1.0) for t in lifetime(segment.dynamic))
        for share in np.linspace(0, 1, 5):
            places = evaluate(segment.dynamic, start + share * (end - start))[0]
            assert (places >= low - 1e-5).all()
            assert (places <= high + 1e-5).all()
