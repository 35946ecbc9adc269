"""Key frames of a camera path: set in the player, kept in its address, played, and saved for `hgs render`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from hgs_core.film import CameraPath, load_camera_path
from tests.web_client.test_view_page import PHONE, viewing

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

DESKTOP = {"width": 1280, "height": 800}


def saved(page: Page, folder: Path) -> CameraPath:
    """The path of the file that the page saves, as `hgs render` reads it."""
    with page.expect_download() as download:
        page.get_by_role("button", name="Save for hgs render").click()
    file = folder / download.value.suggested_filename
    download.value.save_as(file)
    assert file.name == "camera-path.json"
    return load_camera_path(file)


def shown_camera(page: Page) -> np.ndarray:
    """The camera's place and target, by the link that the page copies."""
    page.evaluate("() => { navigator.clipboard.writeText = async (text) => { window.copied = text; }; }")
    page.evaluate("() => { window.copied = null; }")
    page.keyboard.press("c")
    page.wait_for_function("() => window.copied !== null")
    view = page.evaluate("() => new URL(window.copied).searchParams.get('view')")
    return np.array([float(number) for number in view.split(",")[:6]])


def key(path: CameraPath, number: int) -> np.ndarray:
    return np.array([*path.keys[number].position, *path.keys[number].target])


def add_two(page: Page) -> None:
    """Set one key frame at 0.2 s and, after a turn, one at 0.8 s."""
    page.keyboard.press("n")
    page.locator(".path-panel").wait_for()
    page.evaluate("() => window.hgs.seek(0.2)")
    page.get_by_role("button", name="Add a key frame here").click()
    page.get_by_role("button", name="Set this key frame anew").wait_for()
    page.evaluate("() => window.hgs.seek(0.8)")
    page.locator(".stage").focus()
    for _ in range(4):
        page.keyboard.press("Shift+ArrowLeft")
    page.get_by_role("button", name="Add a key frame here").click()


def test_key_frames_are_kept_in_the_address_played_and_saved(browser: Browser, site: Site, tmp_path: Path) -> None:
    with viewing(browser, site, "?paused=1&t=0", viewport=DESKTOP) as page:
        loaded: list[str] = []
        page.on("request", lambda request: loaded.append(request.url))
        add_two(page)
        assert any("key_frame_tool" in url for url in loaded)  # not before it was asked for
        assert page.locator(".path-mark").count() == 2
        given = saved(page, tmp_path)
        assert [one.time for one in given.keys] == pytest.approx([0.2, 0.8])
        assert np.linalg.norm(key(given, 1)[:3] - key(given, 0)[:3]) > 0.1
        link = page.url

    with viewing(browser, site, link.partition(site.page)[2], viewport=DESKTOP) as page:
        page.locator(".path-mark").nth(1).wait_for(state="attached")
        for time in (0.2, 0.5, 0.65, 0.8):  # the camera follows the time
            page.evaluate("(time) => window.hgs.seek(time)", time)
            expected = given.camera(time, (1280, 800), tuple(page_up(site)))
            two_frames(page)
            found = shown_camera(page)
            np.testing.assert_allclose(found[:3], expected.position, atol=1e-4)
        page.evaluate("() => window.hgs.seek(0.2)")
        page.evaluate("() => window.hgs.play()")
        page.wait_for_function("() => window.hgs.state.time > 0.85 || window.hgs.state.time < 0.19")
        page.evaluate("() => window.hgs.pause()")
        page.keyboard.press("n")
        assert page.get_by_role("button", name="Play along").get_attribute("aria-pressed") == "true"
        assert saved(page, tmp_path).to_json() == given.to_json()
        page.evaluate("() => window.hgs.seek(0.8)")
        two_frames(page)
        page.get_by_role("button", name="Set this key frame anew").click()
        np.testing.assert_allclose(key(saved(page, tmp_path), 1), key(given, 1), atol=1e-3)  # the same again


def two_frames(page: Page) -> None:
    page.evaluate("() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)))")


def page_up(site: Site) -> list[float]:
    return list(json.loads((site.folder / "manifest.json").read_text())["up"])


def test_a_hand_on_the_picture_lets_go_of_the_path_and_key_frames_are_removed(browser: Browser, site: Site) -> None:
    with viewing(browser, site, "?paused=1&t=0", viewport=DESKTOP) as page:
        add_two(page)
        follow = page.get_by_role("button", name="Play along")
        follow.click()
        assert follow.get_attribute("aria-pressed") == "true"
        page.mouse.move(400, 300)
        page.mouse.down()
        page.mouse.move(460, 300, steps=3)
        page.mouse.up()
        assert follow.get_attribute("aria-pressed") == "false"
        page.get_by_role("button", name="Remove the key frame").first.click()
        assert page.locator(".path-mark").count() == 1
        assert page.evaluate("() => new URL(location.href).searchParams.get('keys').split(',').length") == 8
        page.get_by_role("button", name="Remove the key frame").click()
        assert "keys" not in page.url
        assert page.get_by_role("button", name="Save for hgs render").is_disabled()
        page.keyboard.press("Escape")
        page.locator(".path-panel").wait_for(state="detached")


def test_on_a_phone_the_panel_leaves_the_picture_and_the_time_free(browser: Browser, site: Site) -> None:
    with viewing(browser, site, **PHONE) as page:
        page.get_by_role("button", name="Settings").tap()
        page.get_by_role("button", name="Camera path").tap()
        page.get_by_role("button", name="Add a key frame here").tap()
        panel, bar = page.locator(".path-panel").bounding_box(), page.locator(".timeline").bounding_box()
        assert panel is not None
        assert bar is not None
        assert panel["y"] > 0.5 * 844
        assert panel["y"] + panel["height"] <= bar["y"]
        assert page.evaluate("() => document.documentElement.scrollWidth") <= 390
