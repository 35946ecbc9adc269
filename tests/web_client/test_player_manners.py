"""The manners of the player: limits of the camera, keys, the timeline, links, pictures, settings, help."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from PIL import Image

from benchmarks.viewers.browser import canvas_pixels, psnr
from tests.web_client.test_console_pages import violations
from tests.web_client.test_delivery import ALL_DRAWN
from tests.web_client.test_view_page import PHONE, playing, viewing

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

# A scene that says from where it was captured, around its first camera's direction.
ARC = """(() => {
  const parse = JSON.parse;
  JSON.parse = (text, ...more) => {
    const read = parse(text, ...more);
    if (read?.world_to_camera || read?.cameras) {
      const [, , [x, y, z]] = read.cameras[0].world_to_camera;  // the view axis
      const along = x * read.up[0] + y * read.up[1] + z * read.up[2];
      const front = [0, 1, 2].map((i) => along * read.up[i] - [x, y, z][i]);
      const size = Math.hypot(...front);
      read.captured_space = {
        front: front.map((value) => value / size), azimuth: 0.4, elevation: [-0.3, 0.3], distance: [2, 5],
      };
    }
    return read;
  };
})()"""


def time_of(page: Page) -> float:
    return float(page.evaluate("() => window.hgs.state.time"))


def wait_for_time(page: Page, time: float) -> None:
    page.wait_for_function("(time) => Math.abs(window.hgs.state.time - time) < 1e-6", arg=time)


def message(page: Page) -> str:
    return page.locator(".message").inner_text()


def settled(page: Page) -> np.ndarray:
    """The picture once it has stopped moving by itself."""
    page.evaluate("() => window.hgs.seek(window.hgs.state.time)")
    before = canvas_pixels(page)
    while True:
        page.wait_for_timeout(300)
        after = canvas_pixels(page)
        if np.array_equal(before, after):
            return after
        before = after


def drag(page: Page, dx: int) -> None:
    page.mouse.move(320, 240)
    page.mouse.down()
    page.mouse.move(320 + dx, 240, steps=6)


@pytest.mark.slow
def test_a_quarter_turn_ends_softly_and_springs_back(browser: Browser, site: Site) -> None:
    """Held at its end the rubber band shows a little more than after letting go; a longer drag no more."""
    with viewing(browser, site, prepare=lambda page: page.add_init_script(ARC)) as page:
        drag(page, -262)  # 90 degrees
        held = settled(page)
        page.mouse.up()
        rest = settled(page)
        assert psnr(held, rest) < 40
        drag(page, -262)
        page.mouse.up()
        assert psnr(settled(page), rest) > 45
        for _ in range(30):
            page.keyboard.press("Shift+ArrowRight")
        assert psnr(settled(page), rest) > 45
        page.keyboard.press("r")
        first = settled(page)
        assert psnr(first, rest) < 40
        page.mouse.move(320, 240)
        for _ in range(12):
            page.mouse.wheel(0, 600)
        far = settled(page)
        page.mouse.wheel(0, 600)
        assert psnr(settled(page), far) > 45
        assert psnr(first, far) < 40


def test_flying_moves_and_looks_around(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        before = settled(page)
        page.keyboard.press("w")
        assert np.array_equal(settled(page), before)
        page.keyboard.press("g")
        assert "Flying" in message(page)
        page.keyboard.down("w")
        page.wait_for_timeout(300)
        page.keyboard.up("w")
        ahead = settled(page)
        assert psnr(ahead, before) < 40
        page.keyboard.press("s")  # goes back, and shows no statistics
        assert not page.locator(".stats").is_visible()
        page.keyboard.press("g")
        page.keyboard.press("s")
        assert page.locator(".stats").is_visible()


def test_keys_seek_step_and_change_the_rate(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        page.keyboard.press("ArrowRight")  # a tenth of two seconds
        wait_for_time(page, 0.6)
        page.keyboard.press("j")
        wait_for_time(page, 0.2)
        page.keyboard.press("7")
        wait_for_time(page, 1.4)
        page.keyboard.press(",")
        wait_for_time(page, 1.4 - 1 / 15)
        page.keyboard.press("End")
        wait_for_time(page, 2)
        page.keyboard.press(">")
        assert message(page).startswith("Speed 1.25")
        page.keyboard.press("k")
        page.wait_for_function("() => window.hgs.state.playing")


def test_a_stretch_is_repeated_until_it_is_cleared(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        stretch = page.locator(".loop-range")
        assert not stretch.is_visible()
        page.keyboard.press("i")
        page.keyboard.press("3")
        page.keyboard.press("o")
        stretch.wait_for()
        bar, shown = page.locator(".timeline").bounding_box(), stretch.bounding_box()
        assert bar
        assert shown
        track = bar["width"] - 16  # the knob's halves
        assert shown["x"] == pytest.approx(bar["x"] + 8 + 0.2 * track, abs=1)
        assert shown["width"] == pytest.approx(0.1 * track, abs=1)
        page.evaluate("() => { window.times = [] }")
        page.keyboard.press("k")
        page.wait_for_function(
            """() => {
              window.times.push(window.hgs.state.time);
              return window.times.filter((time, i) => time < window.times[i - 1]).length >= 2;
            }"""
        )
        times = page.evaluate("() => window.times")
        assert min(times) >= 0.4 - 1e-6
        assert max(times) <= 0.6 + 1e-6
        page.keyboard.press("x")
        stretch.wait_for(state="hidden")
        page.wait_for_function("() => window.hgs.state.time > 0.7")


def test_bookmarks_are_shown_reached_and_kept_in_the_address(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        page.keyboard.press("b")
        page.keyboard.press("8")
        page.keyboard.press("b")
        page.locator(".mark").nth(1).wait_for()
        assert page.locator(".mark").count() == 2
        page.keyboard.press("PageUp")
        wait_for_time(page, 0.4)
        page.reload()
        page.wait_for_function(ALL_DRAWN)
        page.locator(".mark").nth(1).wait_for()
        assert page.locator(".mark").count() == 2
        page.get_by_role("button", name="Settings").click()
        page.get_by_role("button", name="To the bookmark at 0:01.60").click()
        wait_for_time(page, 1.6)
        page.keyboard.press("b")  # takes it away
        page.locator(".mark").nth(1).wait_for(state="detached")
        assert page.locator(".mark").count() == 1
        assert page.url.endswith("marks=0.4")


def test_the_time_under_the_pointer_is_shown_and_is_where_a_click_goes(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        bar = page.locator(".seek").bounding_box()
        assert bar
        bubble = page.locator(".bubble")
        assert not bubble.is_visible()
        page.mouse.move(bar["x"] + 8 + 0.75 * (bar["width"] - 16), bar["y"] + bar["height"] / 2)
        assert bubble.inner_text() == "0:01.50"
        page.mouse.down()
        page.mouse.up()
        page.wait_for_function("() => Math.abs(window.hgs.state.time - 1.5) < 0.02")
        page.mouse.move(320, 100)
        assert not bubble.is_visible()


def test_on_a_large_screen_controls_grow_and_the_picture_does_not(browser: Browser, site: Site) -> None:
    with viewing(browser, site, viewport={"width": 1920, "height": 480}) as page:
        settings = page.get_by_role("button", name="Settings").bounding_box()
        assert settings
        assert settings["width"] == pytest.approx(1.18 * 44, abs=0.5)
        assert page.evaluate("() => window.hgs.state.width") == 1920
        bar = page.locator(".seek").bounding_box()
        assert bar
        knob = 1.18 * 8
        page.mouse.move(bar["x"] + knob + 0.05 * (bar["width"] - 2 * knob), bar["y"] + bar["height"] / 2)
        share = page.locator(".bubble").evaluate("(bubble) => Number(bubble.style.getPropertyValue('--at'))")
        assert share == pytest.approx(0.05, abs=2e-4)


def test_a_copied_link_opens_on_the_same_picture(browser: Browser, site: Site) -> None:
    with viewing(browser, site, permissions=["clipboard-read", "clipboard-write"]) as page:
        drag(page, 90)
        page.mouse.up()
        page.mouse.move(320, 240)
        page.mouse.wheel(0, -200)
        page.keyboard.press("ArrowRight")
        wait_for_time(page, 0.6)
        page.keyboard.press("i")
        shared = settled(page)
        page.keyboard.press("c")
        page.locator(".message", has_text="Link copied").wait_for()
        link = page.evaluate("() => navigator.clipboard.readText()")
        page.goto(link)
        page.wait_for_function(ALL_DRAWN)
        assert not playing(page)
        page.locator(".loop-range").wait_for()
        assert psnr(settled(page), shared) >= 45


def test_a_saved_picture_is_the_canvas_at_its_best(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        expected = settled(page)
        page.get_by_role("button", name="Settings").click()
        page.get_by_label("Quality").select_option("low")
        assert psnr(settled(page), expected) < 50
        with page.expect_download() as download:
            page.get_by_role("button", name="Save picture").click()
        assert download.value.suggested_filename == "Clouds 0m00.40s.png"
        with Image.open(BytesIO(download.value.path().read_bytes())) as picture:
            assert psnr(np.asarray(picture.convert("RGB")), expected[..., :3]) > 60


def test_settings_choose_camera_and_speed_and_close_with_escape(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        before = settled(page)
        button = page.get_by_role("button", name="Settings")
        button.click()
        page.get_by_label("Camera", exact=True).select_option("Above")
        assert psnr(settled(page), before) < 40
        page.get_by_label("Speed").select_option("0.75")
        assert page.get_by_role("button", name="Repeat", exact=True).get_attribute("aria-pressed") == "true"
        page.keyboard.press("Escape")
        assert not page.get_by_label("Speed").is_visible()
        assert button.get_attribute("aria-expanded") == "false"
        page.keyboard.press("Enter")  # the focus is on the button again
        assert page.get_by_label("Speed").is_visible()
        page.mouse.click(100, 300)
        assert not page.get_by_label("Speed").is_visible()


def test_the_help_lists_keys_and_keeps_the_focus(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        page.keyboard.press("?")
        help_box = page.get_by_role("dialog", name="Keys and gestures")
        help_box.wait_for()
        assert "Play or pause" in help_box.inner_text()
        for _ in range(4):
            page.keyboard.press("Tab")
            focused = "() => document.activeElement.shadowRoot?.activeElement?.closest('dialog, .controls')?.tagName"
            assert page.evaluate(focused) in (None, "DIALOG")
        page.keyboard.press("7")  # nothing is obeyed behind it
        assert time_of(page) == pytest.approx(0.4)
        page.keyboard.press("Escape")
        assert not help_box.is_visible()


def test_an_upright_phone_is_covered_by_what_the_capture_shows(browser: Browser, site: Site) -> None:
    """As in the middle of the capture's picture, enlarged to the screen's height."""
    with viewing(browser, site, **PHONE | {"device_scale_factor": 1}) as page:
        picture = settled(page)
        page.goto(site.page + "?paused=1&t=0.4&exact=1&width=1350&height=844")
        page.wait_for_function(ALL_DRAWN)
        whole = canvas_pixels(page)
        assert psnr(picture, whole[:, 480:870]) > 30


@pytest.mark.parametrize("options", [{}, PHONE], ids=["desk", "phone"])
@pytest.mark.parametrize("opened", ["nothing", "settings", "help"])
def test_nothing_keeps_anybody_out(browser: Browser, site: Site, opened: str, options: dict[str, Any]) -> None:
    with viewing(browser, site, **options) as page:
        if opened == "settings":
            page.get_by_role("button", name="Settings").click()
            page.get_by_role("group", name="Settings").wait_for()
        elif opened == "help":
            page.keyboard.press("?")
            page.get_by_role("dialog").wait_for()
        assert violations(page) == []


def test_the_page_of_a_missing_scene_keeps_nobody_out(browser: Browser, site: Site) -> None:
    page = browser.new_page()
    page.goto(f"{site.address}/view/nothing-here?paused=1")
    page.get_by_role("heading", name="There is no such scene here").wait_for()
    assert page.locator("main").count() == 1
    assert violations(page) == []
    page.close()
