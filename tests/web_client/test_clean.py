"""Visible splats selected, hidden, deleted and listed; tests/web_client/test_edit_application.py applies them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from benchmarks.viewers.browser import canvas_pixels
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.edit.splat_list import SplatList
from tests.web_client.test_view_page import PHONE, viewing

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

DESKTOP = {"width": 960, "height": 600}  # three times the pictures of the cameras
REDDER = """(before) => window.hgs.readPixels().then(({ width, height, data }) => {
  const at = 4 * (width * (height >> 1) + (width >> 1));
  return data[at] - data[at + 1] > before;
})"""


def counts(page: Page) -> dict[str, int]:
    """The numbers of splats in the panel, by their kind."""
    text = page.locator(".clean-counts").text_content() or ""
    return {kind: int(count.replace(",", "")) for count, kind in re.findall(r"([\d,]+) (\w+)", text)}


def begin(page: Page) -> None:
    page.keyboard.press("e")
    page.locator(".clean-panel").wait_for()


def wait_for(page: Page, kind: str) -> int:
    page.locator(".clean-counts", has_text=kind).wait_for()
    return counts(page)[kind]


def box(page: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    page.get_by_role("button", name="Box").click()
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(*end, steps=3)
    page.mouse.up()


def listed(page: Page, folder: Path) -> SplatList:
    with page.expect_download() as download:
        page.get_by_role("button", name="Save the list").click()
    download.value.save_as(folder / "splats.json")
    return SplatList.load(folder / "splats.json")


def test_a_brush_selects_and_deletes_what_it_covers_and_steps_back(browser: Browser, site: Site) -> None:
    with viewing(browser, site, viewport=DESKTOP) as page:
        loaded: list[str] = []
        page.on("request", lambda request: loaded.append(request.url))
        before = canvas_pixels(page)
        begin(page)
        assert any("clean_tool" in url for url in loaded)  # not before it was asked for
        page.mouse.move(480, 300)
        page.mouse.down()
        page.mouse.move(500, 310, steps=3)
        page.mouse.up()
        selected = wait_for(page, "selected")
        page.wait_for_function(REDDER, arg=40)
        page.keyboard.press("Delete")
        assert wait_for(page, "deleted") == selected
        page.wait_for_function(f"() => ({REDDER})(40).then((red) => !red)")
        assert np.abs(canvas_pixels(page).astype(int) - before).max() > 20
        page.keyboard.press("Control+z")
        assert wait_for(page, "selected") == selected
        page.keyboard.press("Control+z")
        page.locator(".clean-counts", has_text="Nothing is marked").wait_for()
        page.keyboard.press("Control+Shift+z")
        assert wait_for(page, "selected") == selected
        assert "crosshair" in page.locator(".stage").evaluate("(stage) => getComputedStyle(stage).cursor")
        page.keyboard.press("Escape")
        assert "crosshair" not in page.locator(".stage").evaluate("(stage) => getComputedStyle(stage).cursor")
        page.wait_for_function(f"() => ({REDDER})(40).then((red) => !red)")  # the scene as it is


def test_a_saved_list_holds_the_splats_of_a_box_alone(browser: Browser, site: Site, tmp_path: Path) -> None:
    with viewing(browser, site, viewport=DESKTOP) as page:
        begin(page)
        page.get_by_label("Also what is hidden behind").check()
        box(page, (30, 100), (480, 460))
        selected = wait_for(page, "selected")
        page.get_by_role("button", name="Delete").click()
        assert wait_for(page, "deleted") == selected
        found = listed(page, tmp_path)
    manifest, scene = load_manifest(site.folder), decode_scene(site.folder)
    keep, start = np.ones(len(scene.static), np.bool_), 0
    for chunk in manifest.static:
        for first, last in found.chunks.get(chunk.id, ()):
            keep[start + first : start + last + 1] = False
        start += chunk.splats
    camera = site.cameras[0]
    pixels, depth = camera.project(scene.static.means)
    across, down = 3 * pixels.T
    inside = (across > 35) & (across < 475) & (down > 105) & (down < 455) & (depth > camera.near)
    outside = (across < 25) | (across > 485) | (down < 95) | (down > 465)
    visible = 1 / (1 + np.exp(-scene.static.opacity_logits)) > 0.05
    assert inside.any()
    assert not keep[inside & visible].any()
    assert keep[outside].all()
    assert sum(last - first + 1 for ranges in found.chunks.values() for first, last in ranges) == selected
    assert any(chunk.id in found.chunks for piece in manifest.slices for chunk in piece.chunks)  # moving ones, too


def test_one_tool_is_open_at_a_time(browser: Browser, site: Site) -> None:
    with viewing(browser, site, viewport=DESKTOP) as page:
        begin(page)
        for key, panel, gone in (("v", ".crop-panel", ".clean-panel"), ("n", ".path-panel", ".crop-panel")):
            page.keyboard.press(key)
            page.locator(panel).wait_for()
            assert page.locator(gone).count() == 0


def test_strokes_in_quick_succession_all_count(browser: Browser, site: Site) -> None:
    with viewing(browser, site, viewport=DESKTOP) as page:
        begin(page)
        for x in (300, 400, 500):
            page.mouse.move(x, 150)
            page.mouse.down()
            page.mouse.move(x, 400, steps=2)
            page.mouse.up()
        undo = page.get_by_role("button", name="Undo")
        for _ in range(3):
            undo.click()
        page.locator(".clean-counts", has_text="Nothing is marked").wait_for()
        assert undo.is_disabled()


def test_the_hidden_come_back_and_a_selection_is_taken_back(browser: Browser, site: Site) -> None:
    with viewing(browser, site, viewport=DESKTOP) as page:
        begin(page)
        page.get_by_role("button", name="At the middle").press("Enter")  # no pointer
        selected = wait_for(page, "selected")
        page.get_by_role("button", name="Hide", exact=True).click()
        assert wait_for(page, "hidden") == selected
        page.get_by_role("button", name="At the middle").click()  # splats behind the hidden ones
        wait_for(page, "selected")
        page.get_by_label("Deselect instead").check()
        page.get_by_role("button", name="At the middle").click()
        page.wait_for_function(
            "() => !document.querySelector('.player-host').shadowRoot"
            ".querySelector('.clean-counts').textContent.includes('selected')"
        )
        page.get_by_role("button", name="Show hidden").click()
        page.locator(".clean-counts", has_text="Nothing is marked").wait_for()
        assert page.get_by_role("button", name="Apply").is_disabled()


def test_a_finger_draws_and_the_camera_stays(browser: Browser, site: Site) -> None:
    with viewing(browser, site, **PHONE) as page:
        page.get_by_role("button", name="Settings").tap()
        page.get_by_role("button", name="Clean").tap()
        page.locator(".clean-panel").wait_for()
        page.get_by_role("button", name="Look").tap()
        page.get_by_role("button", name="Brush").tap()
        devices = page.context.new_cdp_session(page)
        for kind, x in (("touchStart", 80), ("touchMove", 180), ("touchMove", 320), ("touchEnd", None)):
            points = [] if x is None else [{"x": x, "y": 250}]
            devices.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        wait_for(page, "selected")
        assert page.get_by_role("button", name="Back to the view").count() == 0  # the camera has not moved
        panel = page.locator(".clean-panel").bounding_box()
        assert panel is not None
        assert panel["y"] > 0.4 * 844  # the upper part of the picture is free
