from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats, load_scene, save_scene


def random_scene(seed: int = 0, coefficients: int = 4) -> HybridScene:
    rng = np.random.default_rng(seed)

    def fill(empty, count):
        return type(empty)(*(rng.normal(size=(count, *a.shape[1:])).astype(np.float32) for _, a in empty.items()))

    return HybridScene(
        fill(StaticSplats.empty(), 7),
        (Segment(0.0, 1.5, fill(DynamicSplats.empty(coefficients), 3)), Segment(1.5, 2.0, DynamicSplats.empty())),
    )


@pytest.mark.parametrize("coefficients", [4, 6])
def test_the_same_bits_come_back(tmp_path: Path, coefficients: int) -> None:
    scene = random_scene(coefficients=coefficients)
    save_scene(tmp_path / "scene.npz", scene)
    back = load_scene(tmp_path / "scene.npz")
    assert [(s.start, s.end) for s in back.segments] == [(0.0, 1.5), (1.5, 2.0)]
    pairs = [(scene.static, back.static)]
    pairs += [(a.dynamic, b.dynamic) for a, b in zip(scene.segments, back.segments, strict=True)]
    for before, after in pairs:
        for (_, x), (_, y) in zip(before.items(), after.items(), strict=True):
            assert y.dtype == np.float32
            assert x.shape == y.shape
            assert x.tobytes() == y.tobytes()


def test_how_it_is_drawn_comes_back_and_files_that_do_not_say_it_are_read(tmp_path: Path) -> None:
    path = tmp_path / "scene.npz"
    save_scene(path, dataclasses.replace(random_scene(), background=(0.1, 0.2, 1.0), antialiased=True))
    back = load_scene(path)
    assert (back.background, back.antialiased) == ((0.1, 0.2, 1.0), True)
    entries = dict(np.load(path))
    del entries["background"], entries["antialiased"]
    np.savez(path, **entries)
    older = load_scene(path)
    assert (older.background, older.antialiased) == ((0.0, 0.0, 0.0), False)


def test_nothing_is_left_when_saving_fails(tmp_path: Path) -> None:
    scene = random_scene()
    broken = dataclasses.replace(scene, static=dataclasses.replace(scene.static, means=object()))
    with pytest.raises(TypeError):
        save_scene(tmp_path / "scene.npz", broken)
    assert list(tmp_path.iterdir()) == []


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.npz: no such file"):
        load_scene(tmp_path / "absent.npz")


@pytest.mark.parametrize("keep", [0, 10, 500, -1])
def test_a_truncated_file_is_refused(tmp_path: Path, keep: int) -> None:
    path = tmp_path / "scene.npz"
    save_scene(path, random_scene())
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(InputError, match=r"scene\.npz: unreadable"):
        load_scene(path)


def test_a_wrong_shape_is_named(tmp_path: Path) -> None:
    path = tmp_path / "scene.npz"
    scene = random_scene()
    save_scene(path, dataclasses.replace(scene, static=dataclasses.replace(scene.static, quats=np.zeros((6, 4)))))
    with pytest.raises(InputError, match=r"entry static\.quats is float32 \(6, 4\), expected 7x4"):
        load_scene(path)


def test_motion_of_the_fourth_order_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scene.npz"
    save_scene(path, random_scene(coefficients=5))
    with pytest.raises(InputError, match=r"entry segment0\.motion is float32 \(3, 5, 3\), expected Nx4x3"):
        load_scene(path)


def test_a_missing_entry_is_named(tmp_path: Path) -> None:
    path = tmp_path / "scene.npz"
    np.savez(path, format=np.array(1))
    with pytest.raises(InputError, match="has no entry segments"):
        load_scene(path)


def test_another_kind_of_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "array.npy"
    np.save(path, np.zeros(3))
    with pytest.raises(InputError, match="has no entry format"):
        load_scene(path)
