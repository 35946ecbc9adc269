"""The pictures and prices of captures."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from server.captures.capture_preview import camera_picture, capture_preview, training_prices

FORM = "data:image/jpeg;base64,"


@pytest.fixture
def first(tmp_path: Path) -> Path:
    path = tmp_path / "0.png"
    Image.fromarray(np.full((300, 600, 3), (200, 40, 40), np.uint8)).save(path)
    return path


def test_the_picture_is_a_small_one_of_the_first_camera(first: Path) -> None:
    picture = capture_preview(first, 4, 30, 1.0)["picture"]
    with Image.open(io.BytesIO(base64.b64decode(picture.removeprefix(FORM)))) as shown:
        assert shown.size == (192, 96)
        assert np.allclose(np.asarray(shown).mean((0, 1)), (200, 40, 40), atol=4)


def test_a_camera_has_the_same_picture_and_a_damaged_one_none(first: Path) -> None:
    assert camera_picture(first) == capture_preview(first, 4, 30, 1.0)["picture"]
    first.write_bytes(b"\x89PNG")
    assert camera_picture(first) is None


def test_a_damaged_picture_leaves_both_unknown(tmp_path: Path) -> None:
    (tmp_path / "0.png").write_bytes(b"\x89PNG")
    assert capture_preview(tmp_path / "0.png", 4, 30, 1.0) == {"picture": None, "presets": None}


@pytest.mark.parametrize(
    ("frames", "seconds"), [(None, None), (30, None), (1 << 40, 1e9), (30, 0.0), (30, float("inf")), (-3, 1.0)]
)
def test_an_unknown_or_impossible_length_has_no_price(first: Path, frames: int | None, seconds: float | None) -> None:
    assert capture_preview(first, 4, frames, seconds)["presets"] is None


def test_a_still_scene_has_a_price(first: Path) -> None:
    assert capture_preview(first, 49, 1, 0.0)["presets"]["preview"]["minutes"] > 0


def test_finer_presets_cost_more() -> None:
    prices = training_prices(16, 60, 2.0, 512 * 384)
    minutes, sizes = (
        [prices[name][field] for name in ("preview", "standard", "best")] for field in ("minutes", "bytes")
    )
    assert minutes == sorted(minutes)
    assert sizes == sorted(sizes)
