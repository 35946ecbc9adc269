"""Thin lines do not shimmer as the head moves: an eye's pictures, frame by frame, against finely sampled truth."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pytest

from hgs_core.codec import encode_scene
from hgs_core.scene.camera import Camera, looking_at
from tests.shimmer import drawn, grid, shimmer, truth
from tests.web_client.conftest import Site, serving, site_of
from tests.web_client.emulated_headset import headset_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

SIZE = 96  # pixels of an eye
FRAMES = 11


@pytest.fixture(scope="module")
def grid_site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    run = tmp_path_factory.mktemp("runs") / "grid"
    camera = Camera("front", SIZE, SIZE, SIZE, SIZE, SIZE / 2, SIZE / 2, looking_at((0, 0, -2.5), (0, 0, 0)))
    encode_scene(grid(), run / "scene", cameras=[camera], times=np.zeros(1), title="Grid")
    with serving([run], tmp_path_factory.mktemp("home")) as (page,):
        yield site_of(page, run / "scene")


def test_thin_lines_shimmer_half_as_much_as_without_compensation(browser: Browser, grid_site: Site) -> None:
    """The head moves by a tenth of a pixel a frame, aside and up."""
    scene = grid_site.scene
    pictures, plain, truths = [], [], []
    with headset_page(browser, grid_site, "", size=(SIZE, SIZE)) as headset:
        headset.enter("Show in this room")  # no backdrop, as in the truth
        camera = grid_site.cameras[0]
        units = headset.scene_from_room(camera)[1]
        pixel = 2.5 / units / (SIZE / 1.5)  # metres that the head moves while the grid moves by a pixel
        for frame in range(FRAMES):
            head = (0.1 * pixel * frame, 1.6 + 0.05 * pixel * frame, 0.0)
            headset.look(head)
            headset.settle()
            eye = headset.cameras(camera, head)[0]
            pictures.append(headset.pictures()[0][..., :3])
            plain.append(drawn(scene, eye, antialiased=False))
            truths.append(truth(scene, eye))
    with_it, without = shimmer(pictures, truths), shimmer(plain, truths)
    print(f"shimmer: {with_it:.4f} with compensation, {without:.4f} without; of the truth itself {_own(truths):.4f}")
    assert with_it <= without / 2


def _own(truths: list[np.ndarray]) -> float:
    return shimmer(truths, [np.zeros_like(picture) for picture in truths])
