"""Neither the page nor an eye of a headset shows the scene mirrored."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pytest

from benchmarks.viewers.browser import canvas_pixels, open_viewer
from hgs_core.codec import encode_scene
from tests.chirality import assert_not_mirrored, letters, views
from tests.web_client.conftest import Site, serving, site_of
from tests.web_client.emulated_headset import headset_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

WIDTH, HEIGHT = 320, 240


@pytest.fixture(scope="module")
def letters_site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    run = tmp_path_factory.mktemp("runs") / "letters"
    cameras = views(WIDTH, HEIGHT)
    scene, times = letters(moving=True), np.linspace(0, 1, 5)
    encode_scene(scene, run / "scene", cameras=cameras, times=times, title="Letters", metres_per_unit=0.4)
    with serving([run], tmp_path_factory.mktemp("home")) as (page,):
        yield site_of(page, run / "scene")


def test_the_page_is_not_mirrored(browser: Browser, letters_site: Site) -> None:
    for camera in letters_site.cameras:
        address = f"{letters_site.page}?camera={camera.name}&t=0.5&width={WIDTH}&height={HEIGHT}&paused=1&exact=1"
        with open_viewer(browser, address, width=WIDTH, height=HEIGHT) as page:
            assert_not_mirrored(canvas_pixels(page), camera)


@pytest.mark.parametrize("place", ["Show in the headset", "Show in this room"])
def test_no_eye_sees_it_mirrored(browser: Browser, letters_site: Site, place: str) -> None:
    head = ((0.1, 1.5, 0.6), 0.1, 0.05)
    with headset_page(browser, letters_site, "paused=1&t=0.5", size=(WIDTH, HEIGHT)) as headset:
        headset.enter(place)
        headset.look(*head)
        headset.settle()
        for eye, camera in zip(headset.pictures(), headset.cameras(letters_site.cameras[0], *head), strict=True):
            assert_not_mirrored(eye[..., :3], camera)
