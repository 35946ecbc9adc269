"""*Apply* of the tools on a scene's page: a worker makes the new scene, and the page leads to it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from hgs_core.codec import decode_scene, encode_scene
from hgs_core.scene.camera import Camera, looking_at
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats
from tests.web_client.conftest import Site, serving, site_of
from tests.web_client.test_clean import begin, box, wait_for
from tests.web_client.test_crop import box as crop_box
from tests.web_client.test_view_page import viewing

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = [pytest.mark.browser, pytest.mark.timeout(300)]

WINDOW = {"width": 960, "height": 600}  # six times the pictures of the cameras
WALL, MOVING = 150, 40
WAIT = 200_000  # ms, for what a worker does on a busy machine
SHOWN = "() => [window.hgs.state.splats, window.hgs.state.dynamicSplats]"


@dataclass(frozen=True)
class Edited:
    """A scene on a server with a worker."""

    site: Site
    home: Path

    def made(self, page: Page) -> HybridScene[np.ndarray]:
        """Open the new scene by the panel's link; return its splats as it was encoded."""
        page.get_by_role("link", name="Open the new scene").wait_for(timeout=WAIT)
        page.get_by_role("link", name="Open the new scene").click()
        page.wait_for_url(re.compile(r"/view/studio-[0-9a-f]{8}$"))
        page.wait_for_function("() => window.hgs !== undefined")
        page.evaluate("() => window.hgs.ready")
        assert page.title() == "Studio · HGS"
        return decode_scene(self.home / "runs" / page.url.rpartition("/")[2] / "scene")


def walled() -> HybridScene[np.ndarray]:
    """A wall, a floater before it, and a row of splats that moves upwards before both halves of it."""
    rng = np.random.default_rng(1)
    wall = np.stack([*rng.uniform(-1, 1, (2, WALL)), np.zeros(WALL)], axis=1)
    still = StaticSplats(
        np.concatenate([wall, [[0.0, 0.0, -1.5]]]).astype(np.float32),
        np.full((WALL + 1, 3), np.log(0.12), np.float32),
        np.tile(np.float32([1, 0, 0, 0]), (WALL + 1, 1)),
        np.full(WALL + 1, 4.0, np.float32),
        np.concatenate([np.tile([0.2, 0.5, 0.8], (WALL, 1)), [[1.0, 1.0, 0.0]]]).astype(np.float32),
    )
    motion = np.zeros((MOVING, 4, 3), np.float32)
    motion[:, 0] = np.stack([np.linspace(-0.9, 0.9, MOVING), np.full(MOVING, 0.3), np.full(MOVING, -0.3)], axis=1)
    motion[:, 1, 1] = -0.6
    turns = np.zeros((MOVING, 2, 4), np.float32)
    turns[:, 0, 0] = 1.0
    moving = DynamicSplats(
        motion,
        turns,
        np.full((MOVING, 3), np.log(0.06), np.float32),
        np.full(MOVING, 3.0, np.float32),
        np.full(MOVING, 0.5, np.float32),
        np.full(MOVING, -2.0, np.float32),
        np.tile(np.float32([0.9, 0.3, 0.1]), (MOVING, 1)),
    )
    return HybridScene(still, (Segment(0.0, 1.0, moving),))


@pytest.fixture(scope="module")
def edited(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Edited]:
    run, home = tmp_path_factory.mktemp("runs") / "studio", tmp_path_factory.mktemp("home")
    cameras = [
        Camera(name, 160, 100, 150.0, 150.0, 80.0, 50.0, looking_at((x, 0.0, -3.0), np.zeros(3)))
        for name, x in (("left", -0.4), ("middle", 0.0), ("right", 0.4))
    ]
    encode_scene(walled(), run / "scene", cameras=cameras, times=np.linspace(0, 1, 7), title="Studio", trained=cameras)
    with serving([run], home, workers=1) as (address,):
        yield Edited(site_of(address, run / "scene"), home)


def test_a_cleaning_makes_a_new_scene_without_the_deleted_splats(browser: Browser, edited: Edited) -> None:
    before = edited.site.scene.static
    with viewing(browser, edited.site, "?camera=middle&paused=1", viewport=WINDOW) as page:
        begin(page)
        box(page, (440, 260), (520, 340))
        wait_for(page, "selected")
        page.get_by_role("button", name="Delete").click()
        deleted = wait_for(page, "deleted")
        page.get_by_role("button", name="Apply").click()
        made = edited.made(page)
    assert deleted < 20  # the wall behind the floater is not seen, but for its rim
    assert made.static.means[:, 2].min() > -1.0
    assert len(made.static) + made.dynamic_splats == len(before) + MOVING - deleted


def test_a_crop_makes_a_new_scene_of_the_splats_in_the_box(browser: Browser, edited: Edited) -> None:
    with viewing(browser, edited.site, "?camera=middle&paused=1", viewport=WINDOW) as page:
        page.keyboard.press("v")
        for name, number in {"X": 0.5, "Y": 0, "Z": 0, "Width": 1, "Height": 4, "Depth": 4}.items():
            page.get_by_label(name, exact=True).fill(str(number))
            page.get_by_label(name, exact=True).press("Enter")
        region = crop_box(page)
        page.get_by_role("button", name="Apply").click()
        made = edited.made(page)
        shown = page.evaluate(SHOWN)
    before = edited.site.scene.static.means
    kept = before[region.contains(before)]
    assert 0 < len(kept) < WALL
    assert shown == [len(kept) + MOVING // 2, MOVING // 2]
    np.testing.assert_array_equal(made.static.means, kept)
    assert made.dynamic_splats == MOVING // 2
