"""A whole scene becomes a folder: slices, boxes, order of layers, and the same bytes every time."""

from __future__ import annotations

import dataclasses
import hashlib
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec import decode_scene, encode_scene, load_manifest, read_chunk
from hgs_core.codec.encoder import encode as module
from hgs_core.scene import DynamicSplats, HybridScene, Segment, evaluate, lifetime
from hgs_core.scene.camera import Camera
from tests.hgs_core.codec.scenes import SETTINGS, TIMES, encode, important, opaque_and_brief, scene, sigmoid, statics
from tests.worker_threads import threads_of


def test_a_still_scene_has_one_slice_and_no_dynamic_chunk(tmp_path: Path, cameras: list[Camera]) -> None:
    given = HybridScene(statics(10, 0), (Segment(2.0, 2.0, DynamicSplats.empty()),))
    manifest = encode(given, tmp_path, cameras, times=np.array([2.0]))
    assert [(s.start, s.end, s.chunks, s.needs) for s in manifest.slices] == [(2.0, 2.0, (), ())]
    assert manifest.frame_rate == 30


def test_every_living_splat_is_in_the_chunks_and_needs_of_its_slice(tmp_path: Path, cameras: list[Camera]) -> None:
    manifest = encode(scene(), tmp_path, cameras)
    entries = {chunk.id: chunk for chunk in manifest.chunks}
    assert any(piece.needs for piece in manifest.slices)
    seen: dict[int, set[str]] = {}
    for piece in manifest.slices:
        segment = manifest.segments[piece.segment]
        at_hand = {chunk.id for chunk in piece.chunks} | set(piece.needs)
        of_segment = {c.id for s in manifest.slices if s.segment == piece.segment for c in s.chunks}
        length = segment.end - segment.start
        low, high = ((t - segment.start) / length for t in (piece.start, piece.end))
        for identity in of_segment - at_hand:
            start, end = lifetime(read_chunk(tmp_path, entries[identity]).dynamic())
            assert not ((start < high) & (end >= low)).any()
        for identity in piece.needs:
            assert identity in seen[piece.segment]
            start, end = lifetime(read_chunk(tmp_path, entries[identity]).dynamic())
            assert ((start < high) & (end >= low)).any()
        seen.setdefault(piece.segment, set()).update(chunk.id for chunk in piece.chunks)


@pytest.mark.parametrize("known", [False, True])
def test_opaque_splats_that_decode_to_live_longer_are_in_an_earlier_slice(
    tmp_path: Path, cameras: list[Camera], known: bool
) -> None:
    given = opaque_and_brief()
    settings = dataclasses.replace(SETTINGS, slice_seconds=0.1, dynamic_chunk_splats=4096)
    utility = important(given) if known else None
    manifest = encode(given, tmp_path, cameras, times=TIMES[:30], utility=utility, settings=settings)
    for piece in manifest.slices:
        for entry in piece.chunks:
            start, _ = lifetime(read_chunk(tmp_path, entry).dynamic())
            assert max(float(start.min()), 0.0) * 29 / 30 >= piece.start - 1e-9


def test_slices_cover_all_time_without_gaps(tmp_path: Path, cameras: list[Camera]) -> None:
    manifest = encode(scene(), tmp_path, cameras)
    assert manifest.slices[0].start == manifest.start
    assert manifest.slices[-1].end == manifest.end
    for before, after in zip(manifest.slices, manifest.slices[1:], strict=False):
        assert before.end == after.start


@pytest.mark.parametrize("coefficients", [4, 6])
def test_the_box_holds_every_living_centre(tmp_path: Path, cameras: list[Camera], coefficients: int) -> None:
    manifest = encode(scene(coefficients=coefficients), tmp_path, cameras)
    for piece in manifest.slices:
        for entry in piece.chunks:
            splats = read_chunk(tmp_path, entry).dynamic()
            start, end = (np.clip(t, 0, 1) for t in lifetime(splats))
            for share in np.linspace(0, 1, 5):
                positions = evaluate(splats, start + share * (end - start))[0]
                assert (positions >= entry.box[0]).all()
                assert (positions <= entry.box[1]).all()


def test_the_first_static_chunk_shows_the_most(tmp_path: Path, cameras: list[Camera]) -> None:
    manifest = encode(scene(static=200), tmp_path, cameras)

    def weight(number: int) -> float:
        splats = read_chunk(tmp_path, manifest.static[number]).static()
        return float((sigmoid(splats.opacity_logits) * np.exp(np.sort(splats.log_scales)[:, 1:].sum(axis=1))).mean())

    assert len(manifest.static) > 2
    assert weight(0) > 3 * weight(len(manifest.static) - 1)


def test_equal_scenes_give_equal_bytes(tmp_path: Path, cameras: list[Camera]) -> None:
    for name in "ab":
        encode(scene(), tmp_path / name, cameras)
    manifests = [(tmp_path / name / "manifest.json").read_bytes() for name in "ab"]
    assert manifests[0] == manifests[1]


@pytest.mark.parametrize("kind", ["static", "dynamic"])
def test_chunks_are_encoded_on_all_cores_to_the_same_bytes(
    tmp_path: Path, cameras: list[Camera], monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    threads = threads_of(monkeypatch, module, f"encode_{kind}_chunk")
    manifests = []
    for count in ("1", "4"):
        monkeypatch.setenv("HGS_THREADS", count)
        manifests.append(encode(scene(), tmp_path / count, cameras))
    assert manifests[0] == manifests[1]
    assert threads
    assert "MainThread" not in threads


def test_equal_splats_do_not_make_equal_chunks(tmp_path: Path, cameras: list[Camera]) -> None:
    one = statics(1, 0)
    given = HybridScene(one.take(np.zeros(200, int)), (Segment(0.0, 1.0, DynamicSplats.empty()),))
    manifest = encode(given, tmp_path, cameras)
    assert len({chunk.id for chunk in manifest.static}) == len(manifest.static) > 1
    assert len(decode_scene(tmp_path).static) == 200


def test_the_folder_holds_what_the_manifest_says_and_nothing_else(tmp_path: Path, cameras: list[Camera]) -> None:
    encode(scene(static=300), tmp_path, cameras, thumbnail=lambda alone: b"jpeg")
    manifest = encode(scene(static=100), tmp_path, cameras, training={"psnr": 30.5})
    assert load_manifest(tmp_path).to_json() == manifest.to_json()
    files = {path.name: path.read_bytes() for path in (tmp_path / "chunks").iterdir()}
    assert {name: len(data) for name, data in files.items()} == {chunk.id: chunk.bytes for chunk in manifest.chunks}
    assert all(hashlib.sha256(data).hexdigest() == name for name, data in files.items())
    assert {path.name for path in tmp_path.iterdir()} == {"manifest.json", "chunks"}


@pytest.mark.parametrize("times", [[], [0.0, 0.0], [1.0, 0.0], [0.0, np.nan]])
def test_a_clock_that_does_not_run_is_refused(tmp_path: Path, cameras: list[Camera], times: list[float]) -> None:
    with pytest.raises(InputError, match="times: are not increasing"):
        encode_scene(scene(), tmp_path, cameras=cameras, times=np.array(times), title="")


def test_no_cameras_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cameras: there are none"):
        encode(scene(), tmp_path, [])


def test_up_is_what_somebody_chose_or_else_what_the_cameras_tell(tmp_path: Path, cameras: list[Camera]) -> None:
    given = HybridScene(statics(10, 0), (Segment(0.0, 0.0, DynamicSplats.empty()),))
    told = encode(given, tmp_path, cameras, times=np.zeros(1))
    assert encode(given, tmp_path, cameras, times=np.zeros(1), up=(0.0, 0.6, 0.8)).up == (0.0, 0.6, 0.8)
    mean = -np.mean([camera.world_to_camera[1, :3] for camera in cameras], axis=0)
    assert told.up == pytest.approx(mean / np.linalg.norm(mean))
