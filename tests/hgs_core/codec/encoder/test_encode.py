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

from hgs_core.base.errors import InputError
from hgs_core.codec import EncodeSettings, SetUtility, Utility, decode_scene, encode_scene, load_manifest, read_chunk
from hgs_core.codec.encoder.rotations import shape_error
from hgs_core.codec.format.attributes import Kind
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats, evaluate, lifetime
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import joined

SETTINGS = EncodeSettings(static_chunk_splats=64, dynamic_chunk_splats=64, small_chunk_splats=8)
TIMES = np.arange(60) / 30


def statics(count: int, seed: int, spread: float = 1.0) -> StaticSplats:
    rng = np.random.default_rng(seed)
    return StaticSplats(
        rng.normal(0, spread, (count, 3)).astype(np.float32),
        rng.normal(-4, 1, (count, 3)).astype(np.float32),
        rng.normal(0, 1, (count, 4)).astype(np.float32),
        rng.normal(2, 2, count).astype(np.float32),
        rng.uniform(0, 1, (count, 3)).astype(np.float32),
    )


def dynamics(count: int, seed: int, coefficients: int = 4) -> DynamicSplats:
    rng = np.random.default_rng(seed)
    still = statics(count, seed)
    motion = rng.normal(0, 0.5, (count, coefficients, 3)).astype(np.float32)
    rotation = rng.normal(0, 1, (count, 2, 4)).astype(np.float32)
    center = rng.uniform(-0.2, 1.2, count).astype(np.float32)
    precision = rng.normal(4, 3, count).astype(np.float32)
    return DynamicSplats(motion, rotation, still.log_scales, still.opacity_logits, center, precision, still.rgb)


def scene(static: int = 200, dynamic: int = 150, coefficients: int = 4) -> HybridScene:
    first, second = (dynamics(dynamic, seed, coefficients) for seed in (1, 2))
    return HybridScene(statics(static, 0), (Segment(0.0, 29 / 30, first), Segment(1.0, 59 / 30, second)))


def encode(given: HybridScene, out: Path, cameras: list[Camera], **more: Any):
    return encode_scene(given, out, cameras=cameras, title="test", **({"times": TIMES, "settings": SETTINGS} | more))


def sigmoid(logit: np.ndarray) -> np.ndarray:
    return np.exp(-np.logaddexp(0, -logit.astype(np.float64)))


def nearest(places: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return for each place [N, K] the index of the nearest of the others [M, K]."""
    return np.argmin(np.abs(places[:, None] - others[None]).max(axis=2), axis=1)


def important(given: HybridScene) -> Utility:
    """So much utility that colours tell splats apart after they have been sorted."""
    sets = (given.static, *(segment.dynamic for segment in given.segments))
    static, *dynamic = (SetUtility(np.full(len(splats), 64.0), np.full(len(splats), 64.0)) for splats in sets)
    return Utility(static, tuple(dynamic))


def chunks_of(folder: Path):
    manifest = load_manifest(folder)
    return [read_chunk(folder, entry) for entry in manifest.chunks]


def check_statics(before: StaticSplats, folder: Path) -> int:
    """Check every decoded splat against the nearest original, by the bounds of its chunk; return how many there are."""
    found = 0
    opacities = sigmoid(before.opacity_logits)
    visible = np.flatnonzero(opacities >= 1 / 255)
    for chunk in chunks_of(folder):
        if chunk.kind != Kind.STATIC:
            continue
        bounds, arrays = chunk.bounds, {name: a.astype(np.float64) for name, a in chunk.arrays.items()}
        place = np.concatenate([before.means / max(bounds.position, 1e-30), before.rgb / bounds.rgb], axis=1)[visible]
        coded = np.concatenate([arrays["means"] / max(bounds.position, 1e-30), arrays["rgb"] / bounds.rgb], axis=1)
        origin = visible[nearest(coded, place)]
        found += len(set(origin))
        assert np.abs(arrays["means"] - before.means[origin]).max() <= bounds.position
        assert np.abs(arrays["rgb"] - before.rgb[origin]).max() <= bounds.rgb
        assert np.abs(arrays["opacities"] - opacities[origin]).max() <= bounds.opacity
        norm = np.linalg.norm(before.quats[origin], axis=1, keepdims=True)
        quats = np.where(norm > 0, before.quats[origin] / np.where(norm > 0, norm, 1), (1, 0, 0, 0)).astype(np.float64)
        scales = np.minimum(before.log_scales[origin].astype(np.float64), 30)
        unit = arrays["quats"] / np.linalg.norm(arrays["quats"], axis=1, keepdims=True)
        assert shape_error(quats, scales, unit, arrays["log_scales"], bounds.blur).max() <= bounds.shape * 1.001 + 1e-6
    assert found <= len(visible)
    return found


def check_dynamics(before: DynamicSplats, folder: Path, segment: int, until: float, frame: float) -> int:
    """Do the same for the dynamic splats of a segment, at many moments of their lives."""
    manifest = load_manifest(folder)
    start, end = lifetime(before)
    alive = np.flatnonzero((start <= until) & (end >= 0))
    briefest = math.log(math.log(255)) - 2 * math.log(SETTINGS.shortest_life * frame)
    slower = dataclasses.replace(before, time_log_precisions=np.minimum(before.time_log_precisions, briefest))
    start, end = (np.clip(side, 0, until) for side in lifetime(slower))
    found = 0
    for piece in manifest.slices:
        for entry in piece.chunks if piece.segment == segment else ():
            chunk = read_chunk(folder, entry)
            bounds, coded = chunk.bounds, chunk.dynamic()
            origin = alive[nearest(chunk.arrays["rgb"].astype(np.float64), before.rgb[alive].astype(np.float64))]
            found += len(set(origin))
            assert np.abs(chunk.arrays["rgb"] - before.rgb[origin]).max() <= bounds.rgb
            original = slower.take(origin)
            for share in np.linspace(0, 1, 9):
                moment = start[origin] + share * (end - start)[origin]
                positions, _, opacities = evaluate(original, moment)
                coded_positions, _, coded_opacities = evaluate(coded, moment)
                fade = opacities / np.maximum(sigmoid(original.opacity_logits), 1e-9)
                assert (np.abs(coded_positions - positions).max(axis=1) * fade).max() <= bounds.position * 1.001 + 1e-9
                assert np.abs(coded_opacities - opacities).max() <= bounds.opacity + 2e-4
    return found


@pytest.mark.parametrize("coefficients", [4, 6])
def test_every_splat_decodes_within_the_bounds_of_its_chunk(
    tmp_path: Path, cameras: list[Camera], coefficients: int
) -> None:
    given = scene(coefficients=coefficients)
    manifest = encode(given, tmp_path, cameras, utility=important(given))
    assert check_statics(given.static, tmp_path) == manifest.totals.splats_static
    after = decode_scene(tmp_path)
    assert [(s.start, s.end) for s in after.segments] == [(s.start, s.end) for s in given.segments]
    found = 0
    for number, (segment, until) in enumerate(zip(given.segments, (30 / 29, 1.0), strict=True)):
        found += check_dynamics(segment.dynamic, tmp_path, number, until, 1 / 29)
    assert found == manifest.totals.splats_dynamic > 250


extreme = st.sampled_from([-np.inf, -1e30, -20.0, -5.54, 0.0, 3.0, 20.0, 1e30, np.inf])


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    count=st.sampled_from([0, 1, 2, 70]),
    seed=st.integers(0, 1000),
    logits=st.lists(extreme, min_size=70, max_size=70),
    precisions=st.lists(extreme, min_size=70, max_size=70),
    still=st.booleans(),
    coefficients=st.sampled_from([4, 6]),
    scale=st.sampled_from([-np.inf, -50.0, -4.0, 2.0]),
)
def test_extreme_scenes_decode_within_their_bounds(
    tmp_path: Path, cameras: list[Camera], count: int, seed: int, logits: list[float], precisions: list[float],
    still: bool, coefficients: int, scale: float,
) -> None:  # fmt: skip
    static, dynamic = statics(count, seed), dynamics(count, seed + 1, coefficients)
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
    encode(given, tmp_path, cameras, utility=important(given))
    check_statics(given.static, tmp_path)
    check_dynamics(given.segments[0].dynamic, tmp_path, 0, 1.0, 1 / 29)


@pytest.mark.parametrize("size", [1e-20, 1e3, 1e8, 1e20])
def test_coordinates_of_any_size_are_kept_in_proportion(tmp_path: Path, cameras: list[Camera], size: float) -> None:
    given = HybridScene(statics(100, 3, spread=size), (Segment(0.0, 0.0, DynamicSplats.empty()),))
    encode(given, tmp_path, cameras)
    after = decode_scene(tmp_path).static.means.astype(np.float64)
    before = given.static.means.astype(np.float64)
    error = np.abs(after - before[nearest(after / size, before / size)]).max(axis=1)
    assert (error <= 0.02 + 2e-3 * np.linalg.norm(after, axis=1)).all()


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


def swinging(count: int) -> DynamicSplats:
    """Splats that live all through their segment and swing to and fro, in the fifth order and no lower one."""
    quintic = np.polynomial.chebyshev.cheb2poly([0, 0, 0, 0, 0, 1])  # T_5 over [-1, 1]
    swing = (quintic * 2.0 ** np.arange(6))[:, None] * (1.0, 0.5, -0.5)
    base = dynamics(count, 3, coefficients=6)
    motion = np.where(np.arange(6)[:, None] == 0, base.motion, swing).astype(np.float32)
    return dataclasses.replace(
        base, motion=motion, opacity_logits=np.full(count, 3, np.float32), time_centers=np.full(count, 0.5, np.float32),
        time_log_precisions=np.full(count, -3, np.float32),
    )  # fmt: skip


def test_motion_of_the_fifth_order_makes_version_3_and_only_where_it_is_needed(
    tmp_path: Path, cameras: list[Camera]
) -> None:
    base = scene(dynamic=60)
    given = dataclasses.replace(
        base, segments=(dataclasses.replace(base.segments[0], dynamic=swinging(20)), base.segments[1])
    )
    manifest = encode(given, tmp_path, cameras, utility=important(given))
    assert json.loads((tmp_path / "manifest.json").read_text())["version"] == manifest.version == 3
    fifth = {chunk.time_range[0] for chunk in chunks_of(tmp_path) if chunk.version == 3}
    assert fifth == {0.0}
    after = decode_scene(tmp_path).segments
    assert [segment.dynamic.motion.shape[1] for segment in after] == [6, 4]
    assert after[0].dynamic.motion[:, 5].any(axis=1).all()
    check_dynamics(given.segments[0].dynamic, tmp_path, 0, 30 / 29, 1 / 29)


def test_a_path_far_from_its_centre_in_time_is_kept(tmp_path: Path, cameras: list[Camera]) -> None:
    count, base = 40, scene(dynamic=20)
    far = dataclasses.replace(
        dynamics(count, 4), opacity_logits=np.full(count, 6, np.float32),
        time_centers=np.linspace(-4, -2, count, dtype=np.float32), time_log_precisions=np.full(count, -3.2, np.float32),
        rotation=np.tile(np.eye(4, dtype=np.float32)[:1], (count, 1, 1)).repeat(2, 1) * (np.arange(2) == 0)[:, None],
    )  # fmt: skip
    from_first = np.polynomial.polynomial.polyfromroots([3.2, 3.7, 4.3])[:, None] * (
        20.0,
        -3.0,
        1.0,
    )  # as if from t = 0
    far = dataclasses.replace(
        far, motion=(from_first + (np.arange(4) == 0)[:, None]).astype(np.float32)[None].repeat(count, 0)
    )
    given = dataclasses.replace(base, segments=(dataclasses.replace(base.segments[0], dynamic=far), base.segments[1]))
    encode(given, tmp_path, cameras, utility=important(given))
    check_dynamics(far, tmp_path, 0, 30 / 29, 1 / 29)


def test_coefficients_of_zero_cost_nothing(tmp_path: Path, cameras: list[Camera]) -> None:
    given = scene()
    fifth = DynamicSplats.empty(6)
    wider = tuple(Segment(s.start, s.end, joined([fifth, s.dynamic])) for s in given.segments)
    narrow = encode(given, tmp_path / "4", cameras)
    wide = encode(dataclasses.replace(given, segments=wider), tmp_path / "6", cameras)
    assert wide.version == narrow.version == 2
    assert sum(chunk.bytes for chunk in wide.chunks) <= 1.02 * sum(chunk.bytes for chunk in narrow.chunks)


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
    "fields",
    [
        {"position_step": 0.0},
        {"rgb_step": np.nan},
        {"prune": -1.0},
        {"prune_dynamic": -1.0},
        {"static_chunk_splats": 0},
        {"compression_level": 23},
    ],
)
def test_settings_out_of_range_are_named(fields: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=rf"encode\.{next(iter(fields))}: "):
        EncodeSettings(**fields)
