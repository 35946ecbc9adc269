"""The pictures of tests/vectors, which clients in other languages are compared with, are those of the renderers."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image

from hgs_core.codec import decode_scene
from hgs_core.render import rasterize
from hgs_core.scene.camera import Camera
from scripts.make_picture_vectors import BACKGROUND, OUT, VECTORS, document, magnifications, rig
from tests.hgs_core.render.comparison import every_backend

CASES: list[dict[str, Any]] = json.loads((OUT / "pictures.json").read_text())


def test_the_file_is_what_the_script_writes() -> None:
    assert json.loads(json.dumps(document())) == CASES


def test_the_magnifications_are_what_the_script_writes() -> None:
    vectors = json.loads((VECTORS / "magnification.json").read_text())
    made = magnifications()
    assert made["rig"] == vectors["rig"]
    for view, vector in zip(made["views"], vectors["views"], strict=True):
        assert view["camera"] == vector["camera"]
        np.testing.assert_allclose(view["magnification"], vector["magnification"], rtol=0, atol=1e-12)


@every_backend
@pytest.mark.parametrize("case", CASES, ids=[case["picture"] for case in CASES])
def test_a_picture_is_the_renderers(backend: str, case: dict[str, Any]) -> None:
    camera = Camera.from_json(case["camera"])
    scene = decode_scene(OUT).map(torch.from_numpy)
    segment = scene.segment_at(case["time"])
    render = rasterize(
        scene.static,
        segment.dynamic,
        camera,
        segment.normalised(case["time"]),
        background=BACKGROUND,
        backend=backend,
        gradients="none",
        antialiased=case["antialiased"],
        rig=rig() if case["magnified"] else (),
    )
    expected = np.asarray(Image.open(OUT / case["picture"])) / 255.0
    shown = render.rgb.permute(1, 2, 0).numpy().clip(0, 1)
    assert np.abs(shown - expected).max() <= 0.5 / 255 + 1e-5
