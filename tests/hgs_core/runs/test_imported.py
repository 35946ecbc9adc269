"""An imported object, seen whole from anywhere and before anything, is the one in the file."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.interchange import export_scene, import_scene
from hgs_core.render.rasterize import rasterize
from hgs_core.runs.imported import import_run
from hgs_core.runs.run_config import RunConfig
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.camera import Camera, looking_at
from hgs_core.scene.files import load_scene
from hgs_core.scene.splats import joined
from tests.hgs_core.interchange.scenes import gaussian_ply_of

LEAST = 40.0  # dB, on black and on white
ORBITS = ((2.4, (-30, 0, 30, 60), 4), (3.4, (0, 45), 4))  # distance in radii, elevations, azimuths


def figure(count: int = 1500) -> StaticSplats[np.ndarray]:
    """A figure in black with a small pale head and feet far from most of its splats."""
    rng = np.random.default_rng(0)
    share = rng.uniform(size=count)
    body, head = share < 0.9, share > 0.95
    means = rng.normal(0, [0.16, 0.3, 0.1], (count, 3))
    means[head] = rng.normal([0, -1.5, 0], 0.06, (head.sum(), 3))
    feet = ~body & ~head
    means[feet] = rng.normal([0, 1.5, 0], 0.06, (feet.sum(), 3))
    rgb = np.where(body[:, None], 0.02, 0.8) + rng.uniform(0, 0.1, (count, 3))
    quats = rng.normal(size=(count, 4))
    arrays = means, rng.normal(-3.5, 0.4, (count, 3)), quats, rng.normal(1, 2, count), rgb
    return StaticSplats(*(array.astype(np.float32) for array in arrays))


def ball(count: int = 40) -> StaticSplats[np.ndarray]:
    """Opaque splats of many colours on a ball, which no picture can miss."""
    rng = np.random.default_rng(1)
    places = rng.normal(size=(count, 3))
    places /= np.linalg.norm(places, axis=1, keepdims=True)
    quats = rng.normal(size=(count, 4))
    quats /= np.linalg.norm(quats, axis=1, keepdims=True)
    arrays = places, rng.uniform(-2.5, -1.5, (count, 3)), quats, np.full(count, 3.0), rng.uniform(0.1, 0.9, (count, 3))
    return StaticSplats(*(array.astype(np.float32) for array in arrays))


def orbits(splats: StaticSplats[np.ndarray], size: int = 240) -> Iterator[Camera]:
    places = splats.means[splats.opacity_logits > -2]
    middle = (places.min(axis=0) + places.max(axis=0)) / 2
    radius = float(np.linalg.norm(places - middle, axis=1).max())
    for distance, elevations, count in ORBITS:
        for elevation in np.deg2rad(elevations):
            for azimuth in 2 * np.pi * np.arange(count) / count + 0.3:
                across = np.cos(elevation)
                aside = np.array([across * np.sin(azimuth), -np.sin(elevation), -across * np.cos(azimuth)])
                pose = looking_at(middle + distance * radius * aside, middle)
                yield Camera("", size, size, size, size, size / 2, size / 2, pose)


def on_black_and_white(splats: StaticSplats[np.ndarray], camera: Camera) -> tuple[torch.Tensor, torch.Tensor]:
    drawn = rasterize(splats.map(torch.from_numpy), None, camera, gradients="none")
    return drawn.rgb.clamp(0, 1), (drawn.rgb + 1 - drawn.alpha).clamp(0, 1)


def check(file: Path, run: Path) -> None:
    config = RunConfig.from_json({"preset": "imported"})
    found = import_run(file, run, lambda _: None, duration=1.0, capture=None, config=config, antialiased=False)
    source, coded = import_scene(file, 1.0).scene.static, decode_scene(run / "scene").static
    assert found.kept == len(coded)
    views = list(orbits(source))
    assert len(views) == 24
    for camera in views:
        for before, after in zip(on_black_and_white(source, camera), on_black_and_white(coded, camera), strict=True):
            assert -10 * math.log10(float(((before - after) ** 2).mean()) + 1e-12) >= LEAST
    manifest = load_manifest(run / "scene")
    assert manifest.captured_space is None  # nobody knows from where it was taken
    start = manifest.cameras[0]
    pixels, depth = start.project(source.means[source.opacity_logits > -2])
    assert (depth > start.near).all()
    assert ((pixels > 0) & (pixels < (start.width, start.height))).all()


def test_a_figure_is_whole_from_all_sides_on_black_and_on_white(tmp_path: Path) -> None:
    given = HybridScene(figure(), (Segment(0.0, 0.0, DynamicSplats.empty()),))
    export_scene(given, tmp_path / "x.ply", cameras=[])
    check(tmp_path / "x.ply", tmp_path / "run")


MAGNITUDES = (0.0, 1e-38, 1e-20, 1e-7, 0.1, 10, 20, 50, 1e3, 1e8, 1e19, 1e29, 3e38)
EXTREMES = [*sorted({sign * size for size in MAGNITUDES for sign in (-1, 1)}), np.inf, -np.inf, np.nan]


def imported(file: Path, run: Path) -> int | None:
    """Import a file as it stands; return how many splats are kept, None if it was refused, and no folder is left."""
    config = RunConfig.from_json({"preset": "imported", "encode.budget": "low"})
    try:
        return import_run(file, run, lambda _: None, capture=None, config=config).kept
    except InputError:
        assert not run.exists()
        return None


@pytest.mark.usefixtures("small_views")
@pytest.mark.parametrize("name", ["means", "log_scales", "opacity_logits", "rgb", "quats"])
@pytest.mark.slow
def test_extreme_numbers_leave_the_good_splats_as_they_are(tmp_path: Path, name: str) -> None:
    """One extreme number in the first component of a property, for every size and sign; and all of them in one file."""
    good = ball()
    extreme = good.take(np.zeros(len(EXTREMES), np.intp)).map(np.copy)
    getattr(extreme, name).reshape(len(EXTREMES), -1)[:, 0] = EXTREMES
    for number in (*range(0, len(EXTREMES), 9), None):
        chosen = slice(None) if number is None else slice(number, number + 1)
        (tmp_path / "x.ply").write_bytes(gaussian_ply_of(joined([good, extreme.take(chosen)])))
        kept = imported(tmp_path / "x.ply", tmp_path / f"run-{number}")
        assert kept is not None
        assert kept >= len(good)


@pytest.mark.usefixtures("small_views")
@pytest.mark.parametrize(
    "name",
    [
        "means",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("log_scales", "opacity_logits", "rgb", "quats")),
    ],
)
def test_a_splat_of_extreme_numbers_alone_is_a_scene_or_refused(tmp_path: Path, name: str) -> None:
    for number, value in enumerate(EXTREMES[::6]):
        one = ball().take(slice(0, 1)).map(np.copy)
        getattr(one, name)[...] = value
        (tmp_path / "x.ply").write_bytes(gaussian_ply_of(one))
        imported(tmp_path / "x.ply", tmp_path / f"run-{number}")


@pytest.mark.usefixtures("small_views")
def test_a_failure_of_any_kind_leaves_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "x.ply").write_bytes(gaussian_ply_of(ball()))

    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("hgs_core.runs.imported.encode", stopped)
    with pytest.raises(KeyboardInterrupt):
        imported(tmp_path / "x.ply", tmp_path / "run")
    assert [path.name for path in tmp_path.iterdir()] == ["x.ply"]


@pytest.mark.usefixtures("small_views")
def test_a_run_says_in_all_its_files_how_it_is_drawn(tmp_path: Path) -> None:
    given = HybridScene(ball(), (Segment(0.0, 0.0, DynamicSplats.empty()),), antialiased=True)
    export_scene(given, tmp_path / "x.ply", cameras=[])
    imported(tmp_path / "x.ply", tmp_path / "run")
    assert load_scene(tmp_path / "run" / "scene.npz").antialiased
    assert decode_scene(tmp_path / "run" / "scene").antialiased


@pytest.mark.data
def test_a_part_of_a_trained_object_is_whole_from_all_sides_on_black_and_on_white(
    tmp_path: Path, test_data: Callable[[str], Path]
) -> None:
    splats = import_scene(test_data("splats/biker.ply"), 1.0).scene.static
    height = splats.means[:, 1]
    part = splats.take(np.flatnonzero(height < np.quantile(height, 0.15)))
    given = HybridScene(part, (Segment(0.0, 0.0, DynamicSplats.empty()),))
    export_scene(given, tmp_path / "x.ply", cameras=[])
    check(tmp_path / "x.ply", tmp_path / "run")
