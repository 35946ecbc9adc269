from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hgs_core.camera import Camera
from hgs_core.codec import EncodeSettings, decode_scene, encode_scene, load_manifest, read_chunk
from hgs_core.errors import InputError
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats, evaluate, lifetime

BOUND = 1e-3
SETTINGS = EncodeSettings(position_error=BOUND, static_chunk_splats=64, dynamic_chunk_splats=64, small_chunk_splats=8)
TIMES = np.arange(60) / 30


def numbered(count: int) -> np.ndarray:
    """Colours that tell splats apart after they have been sorted."""
    index = np.arange(count)
    return np.stack([index % 256, index // 256, np.zeros(count)], axis=1).astype(np.float32) / 255


def numbers(rgb: np.ndarray) -> np.ndarray:
    codes = np.rint(rgb * 255).astype(int)
    return codes[:, 0] + 256 * codes[:, 1]


def statics(count: int, seed: int, spread: float = 1.0) -> StaticSplats:
    rng = np.random.default_rng(seed)
    return StaticSplats(
        rng.normal(0, spread, (count, 3)).astype(np.float32),
        rng.normal(-4, 1, (count, 3)).astype(np.float32),
        rng.normal(0, 1, (count, 4)).astype(np.float32),
        rng.normal(2, 2, count).astype(np.float32),
        numbered(count),
    )


def dynamics(count: int, seed: int) -> DynamicSplats:
    rng = np.random.default_rng(seed)
    still = statics(count, seed)
    motion = rng.normal(0, 0.5, (count, 4, 3)).astype(np.float32)
    rotation = rng.normal(0, 1, (count, 2, 4)).astype(np.float32)
    center = rng.uniform(-0.2, 1.2, count).astype(np.float32)
    precision = rng.normal(4, 3, count).astype(np.float32)
    return DynamicSplats(motion, rotation, still.log_scales, still.opacity_logits, center, precision, still.rgb)


def scene(static: int = 200, dynamic: int = 150) -> HybridScene:
    return HybridScene(
        statics(static, 0), (Segment(0.0, 29 / 30, dynamics(dynamic, 1)), Segment(1.0, 59 / 30, dynamics(dynamic, 2)))
    )


def encode(given: HybridScene, out: Path, cameras: list[Camera], **more: Any):
    return encode_scene(given, out, cameras=cameras, title="test", **({"times": TIMES, "settings": SETTINGS} | more))


def sigmoid(logit: np.ndarray) -> np.ndarray:
    return np.exp(-np.logaddexp(0, -logit.astype(np.float64)))


def check_statics(before: StaticSplats, after: StaticSplats) -> None:
    kept = numbers(after.rgb)
    assert sorted(kept) == np.flatnonzero(sigmoid(before.opacity_logits) >= 1 / 255).tolist()
    before = before.take(kept)
    assert np.abs(after.means - before.means).max(initial=0) <= BOUND
    floor = math.log(SETTINGS.smallest_scale * BOUND)
    assert (
        np.abs(after.log_scales - np.maximum(before.log_scales, floor)).max(initial=0)
        <= SETTINGS.log_scale_error + 1e-6
    )
    assert (
        np.abs(sigmoid(after.opacity_logits) - sigmoid(before.opacity_logits)).max(initial=0)
        <= SETTINGS.opacity_error + 2e-6
    )
    norm = np.linalg.norm(before.quats, axis=1, keepdims=True)
    quats = np.where(norm > 0, before.quats / np.where(norm > 0, norm, 1), (1, 0, 0, 0))
    assert (np.abs((after.quats * quats).sum(axis=1)) >= 1 - SETTINGS.rotation_error**2 / 2 - 1e-6).all()


def check_dynamics(before: DynamicSplats, after: DynamicSplats, until: float, frame: float) -> None:
    start, end = lifetime(before)
    kept = numbers(after.rgb)
    assert sorted(kept) == np.flatnonzero((start <= until) & (end >= 0)).tolist()
    before, start, end = before.take(kept), np.clip(start[kept], 0, until), np.clip(end[kept], 0, until)
    briefest = math.log(math.log(255)) - 2 * math.log(SETTINGS.shortest_life * frame)
    slower = dataclasses.replace(before, time_log_precisions=np.minimum(before.time_log_precisions, briefest))
    for share in np.linspace(0, 1, 7):
        moment = start + share * (end - start)
        positions, _, _ = evaluate(before, moment)
        coded, _, coded_opacities = evaluate(after, moment)
        assert np.abs(coded - positions).max(initial=0) <= BOUND * 1.001
        opacities = evaluate(slower, moment)[2]
        assert np.abs(coded_opacities - opacities).max(initial=0) <= SETTINGS.fade_error + SETTINGS.opacity_error + 2e-4


def test_every_splat_decodes_within_its_bounds(tmp_path: Path, cameras: list[Camera]) -> None:
    given = scene()
    encode(given, tmp_path, cameras)
    after = decode_scene(tmp_path)
    check_statics(given.static, after.static)
    assert [(s.start, s.end) for s in after.segments] == [(s.start, s.end) for s in given.segments]
    for segment, coded, until in zip(given.segments, after.segments, (30 / 29, 1.0), strict=True):
        check_dynamics(segment.dynamic, coded.dynamic, until, 1 / 29)


extreme = st.sampled_from([-np.inf, -1e30, -20.0, -5.54, 0.0, 3.0, 20.0, 1e30, np.inf])


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    count=st.sampled_from([0, 1, 2, 70]),
    seed=st.integers(0, 1000),
    logits=st.lists(extreme, min_size=70, max_size=70),
    precisions=st.lists(extreme, min_size=70, max_size=70),
    still=st.booleans(),
    scale=st.sampled_from([-np.inf, -50.0, -4.0, 2.0]),
)
def test_extreme_scenes_decode_within_their_bounds(
    tmp_path: Path, cameras: list[Camera], count: int, seed: int, logits: list[float], precisions: list[float],
    still: bool, scale: float,
) -> None:  # fmt: skip
    static, dynamic = statics(count, seed), dynamics(count, seed + 1)
    opacities = np.array(logits[:count], np.float32)
    static.log_scales[: count // 2] = scale
    static.quats[: count // 3] = 0
    dynamic.rotation[: count // 3, 0] = 0
    if still:
        dynamic.motion[:, 1:] = 0
    given = HybridScene(
        dataclasses.replace(static, opacity_logits=opacities),
        (
            Segment(
                0.0,
                29 / 30,
                dataclasses.replace(
                    dynamic,
                    opacity_logits=opacities[::-1].copy(),
                    time_log_precisions=np.array(precisions[:count], np.float32),
                ),
            ),
        ),
    )
    encode(given, tmp_path, cameras)
    after = decode_scene(tmp_path)
    check_statics(given.static, after.static)
    check_dynamics(given.segments[0].dynamic, after.segments[0].dynamic, 1.0, 1 / 29)


@pytest.mark.parametrize("size", [1e-20, 1e3, 1e8, 1e20])
def test_coordinates_of_any_size_are_kept_in_proportion(tmp_path: Path, cameras: list[Camera], size: float) -> None:
    given = HybridScene(statics(100, 3, spread=size), (Segment(0.0, 0.0, DynamicSplats.empty()),))
    manifest = encode(given, tmp_path, cameras)
    after = decode_scene(tmp_path).static
    before = given.static.take(numbers(after.rgb))
    distance = np.linalg.norm(before.means.astype(np.float64), axis=1, keepdims=True)
    limit = BOUND * np.maximum(1, distance / manifest.extent) + 1e-5 * distance
    assert (np.abs(after.means - before.means) <= limit).all()


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


def test_slices_cover_all_time_without_gaps(tmp_path: Path, cameras: list[Camera]) -> None:
    manifest = encode(scene(), tmp_path, cameras)
    assert manifest.slices[0].start == manifest.start
    assert manifest.slices[-1].end == manifest.end
    for before, after in zip(manifest.slices, manifest.slices[1:], strict=False):
        assert before.end == after.start


def test_the_box_holds_every_living_centre(tmp_path: Path, cameras: list[Camera]) -> None:
    manifest = encode(scene(), tmp_path, cameras)
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


def test_equal_splats_do_not_make_equal_chunks(tmp_path: Path, cameras: list[Camera]) -> None:
    one = statics(1, 0)
    given = HybridScene(one.take(np.zeros(200, int)), (Segment(0.0, 1.0, DynamicSplats.empty()),))
    manifest = encode(given, tmp_path, cameras)
    assert len({chunk.id for chunk in manifest.static}) == len(manifest.static) > 1
    assert len(decode_scene(tmp_path).static) == 200


def test_the_folder_holds_what_the_manifest_says_and_nothing_else(tmp_path: Path, cameras: list[Camera]) -> None:
    encode(scene(static=300), tmp_path, cameras, thumbnail=b"jpeg")
    manifest = encode(scene(static=100), tmp_path, cameras, training={"psnr": 30.5})
    assert load_manifest(tmp_path).to_json() == manifest.to_json()
    files = {path.name: path.read_bytes() for path in (tmp_path / "chunks").iterdir()}
    assert {name: len(data) for name, data in files.items()} == {chunk.id: chunk.bytes for chunk in manifest.chunks}
    assert all(hashlib.sha256(data).hexdigest() == name for name, data in files.items())
    assert {path.name for path in tmp_path.iterdir()} == {"manifest.json", "chunks"}


def test_a_changed_chunk_is_named_with_both_hashes(tmp_path: Path, cameras: list[Camera]) -> None:
    manifest = encode(scene(), tmp_path, cameras)
    file = tmp_path / "chunks" / manifest.static[0].id
    data = bytearray(file.read_bytes())
    data[100] ^= 1
    file.write_bytes(data)
    with pytest.raises(InputError) as caught:
        decode_scene(tmp_path)
    actual = hashlib.sha256(data).hexdigest()
    assert f"{file}: has the SHA-256 {actual}, the manifest says {manifest.static[0].id}" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("damage", ["missing", "short", "of the other kind", "of another count"])
def test_a_chunk_that_is_not_the_manifests_is_named(tmp_path: Path, cameras: list[Camera], damage: str) -> None:
    manifest = encode(scene(), tmp_path, cameras)
    document = json.loads((tmp_path / "manifest.json").read_text())
    file = tmp_path / "chunks" / manifest.static[0].id
    if damage == "missing":
        file.unlink()
    elif damage == "short":
        file.write_bytes(file.read_bytes()[:-1])
    elif damage == "of the other kind":
        document["static"][0], document["slices"][0]["chunks"][0] = (
            document["slices"][0]["chunks"][0],
            document["static"][0],
        )
        document["slices"] = [piece | {"needs": []} for piece in document["slices"]]
    else:
        document["static"][0]["splats"] += 1
    chunks = [chunk for piece in document["slices"] for chunk in piece["chunks"]]
    for kind, listed in (("static", document["static"]), ("dynamic", chunks)):
        for name in ("splats", "bytes"):
            document["totals"][f"{name}_{kind}"] = sum(chunk[name] for chunk in listed)
    (tmp_path / "manifest.json").write_text(json.dumps(document))
    problem = {"missing": "cannot be read", "short": "bytes, the manifest says", "of the other kind": "is a dynamic",
               "of another count": "splats, the manifest says"}[damage]  # fmt: skip
    with pytest.raises(InputError, match=problem):
        decode_scene(tmp_path)


@pytest.mark.parametrize(("field", "value"), [("means", np.nan), ("log_scales", np.inf), ("opacity_logits", np.nan)])
def test_a_number_that_is_not_finite_is_named_and_nothing_is_written(
    tmp_path: Path, cameras: list[Camera], field: str, value: float
) -> None:
    given = scene()
    getattr(given.static, field)[7] = value
    with pytest.raises(InputError, match=f"static splat 7: {field} is not a finite number"):
        encode(given, tmp_path / "out", cameras)
    assert not (tmp_path / "out").exists()


def test_a_splat_that_lives_far_from_its_segment_is_named(tmp_path: Path, cameras: list[Camera]) -> None:
    given = scene()
    given.segments[0].dynamic.time_centers[5] = 1e6
    given.segments[0].dynamic.time_log_precisions[5] = -1e4
    given.segments[0].dynamic.opacity_logits[5] = 3
    with pytest.raises(InputError, match="dynamic splat 5: time_centers reaches 1e"):
        encode(given, tmp_path, cameras)


@pytest.mark.parametrize("times", [[], [0.0, 0.0], [1.0, 0.0], [0.0, np.nan]])
def test_a_clock_that_does_not_run_is_refused(tmp_path: Path, cameras: list[Camera], times: list[float]) -> None:
    with pytest.raises(InputError, match="times: are not increasing"):
        encode_scene(scene(), tmp_path, cameras=cameras, times=np.array(times), title="")


def test_no_cameras_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cameras: there are none"):
        encode(scene(), tmp_path, [])


@pytest.mark.parametrize(
    "fields", [{"position_error": 0.0}, {"rgb_error": np.nan}, {"static_chunk_splats": 0}, {"compression_level": 23}]
)
def test_settings_out_of_range_are_named(fields: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=rf"encode\.{next(iter(fields))}: "):
        EncodeSettings(**fields)
