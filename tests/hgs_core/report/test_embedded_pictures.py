from __future__ import annotations

import base64
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from hgs_core.report.embedded_pictures import data_uri, reduced, reduced_size


@pytest.mark.parametrize(
    ("size", "expected"), [((1280, 720), (640, 360)), ((512, 384), (512, 384)), ((10_000, 1), (640, 1))]
)
def test_pictures_are_at_most_640_pixels_wide(size: tuple[int, int], expected: tuple[int, int]) -> None:
    assert reduced_size(*size) == expected


def test_reduced_pictures_are_averages() -> None:
    stripes = np.zeros((4, 1280, 3), np.uint8)
    stripes[:, ::2] = 200
    assert (reduced(stripes) == 100).all()


def test_a_picture_survives_its_uri() -> None:
    rows = np.linspace(0, 255, 32).astype(np.uint8)
    pixels = np.stack([np.tile(rows, (16, 1))] * 3, axis=2)
    kind, _, body = data_uri(pixels).partition(",")
    assert kind == "data:image/jpeg;base64"
    with Image.open(BytesIO(base64.b64decode(body))) as image:
        assert np.abs(np.asarray(image).astype(int) - pixels).max() < 12
