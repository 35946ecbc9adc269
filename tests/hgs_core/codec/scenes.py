"""Random scenes to encode, and checks of decoded scenes against them."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.codec import EncodeSettings, SetUtility, Utility, encode_scene, load_manifest, read_chunk
from hgs_core.codec.encoder.rotation_coding import shape_error
from hgs_core.codec.format.attributes import Kind
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats, evaluate, lifetime
from hgs_core.scene.camera import Camera

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


def opaque_and_brief() -> HybridScene:
    """One second of splats that decode to live longer than their grades foresee: their chunks have coarser steps."""
    brief = np.random.default_rng(0).normal(5, 1, 3000).astype(np.float32)
    logits = np.full(3000, 7.0, np.float32)
    opaque = dataclasses.replace(dynamics(3000, 0), opacity_logits=logits, time_log_precisions=brief)
    return HybridScene(statics(20, 0), (Segment(0.0, 29 / 30, opaque),))


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


def swinging(count: int) -> DynamicSplats:
    """Splats that live all through their segment and swing to and fro, in the fifth order and no lower one."""
    quintic = np.polynomial.chebyshev.cheb2poly([0, 0, 0, 0, 0, 1])  # T_5 over [-1, 1]
    swing = (quintic * 2.0 ** np.arange(6))[:, None] * (1.0, 0.5, -0.5)
    base = dynamics(count, 3, coefficients=6)
    motion = np.where(np.arange(6)[:, None] == 0, base.motion, swing).astype(np.float32)
    return dataclasses.replace(
        base,
        motion=motion,
        opacity_logits=np.full(count, 3, np.float32),
        time_centers=np.full(count, 0.5, np.float32),
        time_log_precisions=np.full(count, -3, np.float32),
    )
