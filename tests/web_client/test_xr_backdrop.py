"""The backdrop of the scene in a headset, and the way back to it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.web_client.emulated_headset import headset_page
from tests.web_client.test_xr_pictures import STANDING
from tests.web_client.test_xr_session import aim_at_panel

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from tests.web_client.conftest import Site
    from tests.web_client.emulated_headset import Doubles, Headset

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

STEP = 1 / 255
ROUND = math.pi  # radians


def wait(headset: Headset, milliseconds: int) -> None:
    """Let a headset that shows its scene be looked into for so long."""
    headset.page.evaluate("(time) => { headset.frame(); headset.skip(time); headset.frame(); }", milliseconds)


def test_behind_the_scene_is_a_soft_gradient_of_its_own_colours(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.enter()
        for backdrop in headset.backdrops():
            rows = backdrop.mean(axis=1)  # [H, 3]; the horizon is at 7/15 of the height
            horizon = rows[len(rows) * 7 // 15]
            # The colours of the clouds are even between 0 and 1, and 0.45 of them are left.
            assert horizon == pytest.approx([0.225] * 3, abs=0.03)
            assert np.abs(np.diff(rows, axis=0)).max() < STEP
            assert np.all(rows[0] < horizon - 4 * STEP)
            assert np.all(rows[-1] < horizon - 4 * STEP)


def test_a_disc_lies_on_the_floor_at_the_feet(browser: Browser, site: Site) -> None:
    head, pitch = (0.3, 1.6, 0.2), -1.3
    with headset_page(browser, site) as headset:
        headset.enter()
        headset.look(head, pitch=pitch)
        headset.settle()
        turn, units, shift = headset.scene_from_room(site.cameras[0])
        cameras = headset.cameras(site.cameras[0], head, pitch=pitch)
        for backdrop, camera in zip(headset.backdrops(), cameras, strict=True):

            def light(x: float, z: float, backdrop: Doubles = backdrop, camera=camera) -> float:  # type: ignore[no-untyped-def]
                place = units * turn @ [head[0] + x, 0.0, head[2] + z] + shift
                [(column, row)], _ = camera.project(place[None])
                return float(backdrop[int(row) - 1 : int(row) + 2, int(column) - 1 : int(column) + 2].mean())

            for x, z in ((0.6, 0.0), (-0.6, 0.0), (0.0, -0.6)):
                assert light(x, z) > light(4 / 3 * x, 4 / 3 * z) + 4 * STEP


def test_who_looks_away_is_shown_the_way_back(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.enter()
        first = headset.pictures()
        wait(headset, 2000)
        assert np.array_equal(headset.pictures()[0], first[0])  # the scene is in sight
        headset.look(STANDING, ROUND)
        headset.settle()
        wait(headset, 2000)
        for eye, backdrop in zip(headset.pictures(), headset.backdrops(), strict=True):
            arrow = eye[:, :, :3] - backdrop > 0.4
            height = headset.height * 7 // 15  # eye level; the panel is below
            assert arrow[height - 30 : height + 30].any()
            assert arrow[height + 30 :].any()
        aim_at_panel(headset, 174, 226, ROUND)
        headset.frame()
        headset.press("trigger")
        headset.aim(np.array([0.2, 1.2, 1.0]))
        headset.settle()
        for eye, before in zip(headset.pictures(), first, strict=True):
            assert np.abs(eye - before).mean() < STEP  # the scene is where they look


def test_where_the_room_is_seen_nothing_shows_the_way(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.enter("Show in this room")
        headset.look(STANDING, ROUND)
        headset.settle()
        wait(headset, 2000)
        assert all(eye.max() == 0 for eye in headset.pictures())
