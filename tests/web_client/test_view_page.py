"""The page around the picture: taps, notices, statistics, and rest when nothing changes."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from benchmarks.viewers.browser import canvas_pixels

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Page, Route

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

SIZE = {"width": 640, "height": 480}
PHONE = {"viewport": {"width": 390, "height": 844}, "device_scale_factor": 3, "has_touch": True, "is_mobile": True}
STILL_MOTION = "?paused=1&t=0.4"
LATER = 10**10  # seconds since 1970, after the date of any test


@contextmanager
def viewing(
    browser: Browser,
    site: Site,
    query: str = "?paused=1&t=0.4",
    *,
    prepare: Callable[[Page], None] = lambda page: None,
    ready: bool = True,
    **options: Any,
) -> Iterator[Page]:
    """The scene's page, prepared before it is opened; with `ready`, once everything alive at its time is drawn."""
    context = browser.new_context(**({"viewport": SIZE} | options))
    try:
        page = context.new_page()
        prepare(page)
        page.goto(site.page + query)
        page.wait_for_function("() => window.hgs !== undefined")
        if ready:
            page.evaluate("() => window.hgs.ready")
        yield page
    finally:
        context.close()


def playing(page: Page) -> bool:
    return bool(page.evaluate("() => window.hgs.state.playing"))


def wait_until_playing(page: Page, expected: bool) -> None:
    page.wait_for_function("(expected) => window.hgs.state.playing === expected", arg=expected)


def notice(page: Page) -> Locator:
    return page.locator(".notice:visible")


def assert_quiet_line(page: Page) -> None:
    """Words over the picture are small and leave the middle free."""
    box = notice(page).bounding_box()
    assert box is not None
    height = page.evaluate("() => innerHeight")
    assert box["y"] > 0.6 * height
    assert box["height"] < 0.15 * height


def test_a_click_plays_and_pauses(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        page.mouse.click(320, 200)
        wait_until_playing(page, True)
        page.mouse.click(320, 200)
        wait_until_playing(page, False)


def test_a_tap_plays_and_pauses(browser: Browser, site: Site) -> None:
    with viewing(browser, site, **PHONE) as page:
        page.touchscreen.tap(200, 400)
        wait_until_playing(page, True)
        page.touchscreen.tap(200, 400)
        wait_until_playing(page, False)


def test_a_double_click_looks_at_what_is_there_and_never_plays(browser: Browser, site: Site) -> None:
    """The point under the pointer comes to the middle of the picture: compared where only its place changes."""
    with viewing(browser, site, STILL_MOTION, reduced_motion="reduce") as page:
        before = canvas_pixels(page)
        page.clock.install()
        page.clock.pause_at(LATER)  # however slow the machine is, the second click comes in time
        page.mouse.dblclick(400, 300)
        page.clock.run_for(1000)
        page.clock.resume()
        for _ in range(100):  # the part of the player that finds the point is loaded at the first double click
            page.evaluate("() => window.hgs.seek(0.4)")
            after = canvas_pixels(page)
            if not np.array_equal(after, before):
                break
            page.wait_for_timeout(100)
        patch = before[280:320, 380:420].astype(float)
        errors = {
            (x, y): float(np.abs(after[y - 20 : y + 20, x - 20 : x + 20] - patch).mean())
            for x in range(260, 440, 2)
            for y in range(180, 320, 2)
        }
        x, y = min(errors, key=errors.__getitem__)
        assert max(abs(x - 320), abs(y - 240)) <= 30, (x, y)
        assert page.evaluate("() => window.hgs.state.framesDropped") == 0  # those are counted while a scene plays
        assert not playing(page)


def test_a_drag_does_not_play(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        page.clock.install()
        page.mouse.move(320, 200)
        page.mouse.down()
        page.mouse.move(380, 200, steps=3)
        page.mouse.up()
        page.clock.fast_forward(1000)
        assert not playing(page)


def drag(page: Page) -> None:
    page.mouse.move(320, 200)
    page.mouse.down()
    page.mouse.move(380, 220, steps=4)
    page.mouse.up()


def test_a_moved_camera_is_offered_the_way_back(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        back = page.get_by_role("button", name="Back to the camera (R)")
        assert not back.is_visible()
        drag(page)
        back.click()
        back.wait_for(state="hidden")


def test_a_first_visitor_is_told_that_the_view_turns(browser: Browser, site: Site) -> None:
    """The hint goes with the first turn, and is not in the page when it is opened again."""
    with viewing(browser, site) as page:
        hint = page.get_by_text("Drag to look around")
        hint.wait_for()
        drag(page)
        hint.wait_for(state="hidden")
        page.reload()
        page.get_by_role("button", name="Settings").wait_for()
        assert hint.count() == 0


def test_the_link_to_a_view_is_on_the_bar(browser: Browser, site: Site) -> None:
    with viewing(browser, site, permissions=["clipboard-read", "clipboard-write"]) as page:
        page.get_by_role("button", name="Copy a link to this view (C)").click()
        page.get_by_text("Link copied").wait_for()
        assert "t=0.4" in page.evaluate("() => navigator.clipboard.readText()")


def test_two_fingers_do_not_play(browser: Browser, site: Site) -> None:
    with viewing(browser, site, **PHONE) as page:
        page.clock.install()
        devices = page.context.new_cdp_session(page)
        for fingers in ([(150, 400), (250, 400)], []):
            touches = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(fingers)]
            kind = "touchStart" if fingers else "touchEnd"
            devices.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})
        page.clock.fast_forward(1000)
        assert not playing(page)


def test_controls_are_large_enough_for_fingers(browser: Browser, site: Site) -> None:
    with viewing(browser, site, **PHONE) as page:
        page.get_by_role("button", name="Settings").tap()
        page.get_by_role("group", name="Settings").wait_for()
        controls = page.locator("button:visible, a:visible, select:visible, input:visible").all()
        boxes = [control.bounding_box() for control in controls]
        assert len(boxes) >= 16
        assert all(box and box["width"] >= 44 and box["height"] >= 44 for box in boxes), boxes


def test_a_phone_shows_the_title(browser: Browser, site: Site) -> None:
    with viewing(browser, site, **PHONE) as page:
        title = page.locator("h1")
        title.evaluate("(title) => { title.textContent = 'A scene with a title of some length' }")
        assert title.evaluate("(title) => title.scrollWidth <= title.clientWidth")


def test_a_lost_context_is_told_until_it_is_back(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        page.locator("canvas").evaluate(
            """(canvas) => {
              window.lose = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
              window.lose.loseContext();
            }"""
        )
        page.get_by_role("status").filter(has_text="graphics card").wait_for()
        assert page.get_by_role("button", name="Play").is_visible()
        assert not page.locator("canvas").is_visible()  # browsers draw a broken image on white in its place
        page.evaluate("() => window.lose.restoreContext()")
        notice(page).wait_for(state="detached")
        assert page.locator("canvas").is_visible()


def test_a_context_that_never_comes_back_offers_to_load_again(browser: Browser, site: Site) -> None:
    with viewing(browser, site) as page:
        page.clock.install()
        lose = "(canvas) => canvas.getContext('webgl2').getExtension('WEBGL_lose_context').loseContext()"
        page.locator("canvas").evaluate(lose)
        notice(page).wait_for()
        assert page.get_by_role("button", name="Reload").count() == 0
        page.clock.fast_forward(10_000)
        page.get_by_role("button", name="Reload").click()
        page.wait_for_function("() => window.hgs?.ready.then(() => true)")
        assert notice(page).count() == 0


def test_the_picture_follows_the_pixels_of_the_device(browser: Browser, site: Site) -> None:
    """The window moves to a monitor with twice the pixels: the canvas keeps its size in CSS pixels."""
    with viewing(browser, site) as page:
        page.locator("canvas").evaluate("({ style }) => { style.width = '300px'; style.height = '200px' }")
        page.wait_for_function("() => window.hgs.state.width === 300 && window.hgs.state.height === 200")
        monitor = {"width": 641, "height": 480, "deviceScaleFactor": 2, "mobile": False}
        page.context.new_cdp_session(page).send("Emulation.setDeviceMetricsOverride", monitor)
        page.wait_for_function("() => window.hgs.state.width === 600 && window.hgs.state.height === 400")


def test_reduced_motion_does_not_play_by_itself(browser: Browser, site: Site) -> None:
    with viewing(browser, site, "", reduced_motion="reduce") as page:
        assert not playing(page)
        page.get_by_role("button", name="Play").click()
        wait_until_playing(page, True)


def test_an_address_can_ask_for_motion(browser: Browser, site: Site) -> None:
    with viewing(browser, site, "?paused=0", reduced_motion="reduce") as page:
        assert playing(page)


def test_a_complete_scene_needs_no_server(browser: Browser, site: Site) -> None:
    """Its connection is closed by the page, so that no restart of the server can disturb it."""
    watch = """(() => {
      const Original = WebSocket;
      window.closings = [];
      window.connections = 0;
      window.WebSocket = class extends Original {
        constructor(url) {
          super(url);
          window.connections++;
          this.addEventListener("close", ({ code, wasClean }) => window.closings.push([code, wasClean]));
        }
      };
    })()"""
    with viewing(browser, site, prepare=lambda page: page.add_init_script(watch)) as page:
        page.wait_for_function("() => window.closings.length > 0")
        assert page.evaluate("() => [window.closings, window.connections]") == [[[1000, True]], 1]
        assert page.evaluate("() => window.hgs.state.complete")
        assert notice(page).count() == 0


def test_a_lost_connection_is_a_quiet_line_over_a_picture(browser: Browser, site: Site) -> None:
    """The connection breaks after 40 of 55 kB, the bases of all before it, and no other is let in."""
    cut = """(() => {
      const Original = WebSocket;
      window.connections = 0;
      window.WebSocket = class extends Original {
        constructor(url) {
          super(window.connections++ ? url.replace("/v1/", "/nowhere/") : url);
          let bytes = 0;
          this.addEventListener("message", ({ data }) => {
            bytes += data.byteLength;
            if (bytes > 40_000) this.close(3000);
          });
        }
      };
    })()"""
    with viewing(browser, site, prepare=lambda page: page.add_init_script(cut), ready=False) as page:
        page.wait_for_function("() => window.connections > 1 && window.hgs.state.firstFrame !== null")
        page.get_by_role("status").filter(has_text="Connection lost").wait_for()
        assert_quiet_line(page)


def test_a_damaged_part_is_told_in_words_and_can_be_put_away(browser: Browser, site: Site) -> None:
    """The last chunk of the stream is damaged, and so are its replacements."""
    damage = """(() => {
      const Original = WebSocket;
      window.WebSocket = class extends Original {
        constructor(url) {
          super(url);
          let frames = 0;
          this.addEventListener("message", ({ data }) => {
            const bytes = new Uint8Array(data);
            if (bytes[0] === 1 && ++frames === 4) bytes[100] ^= 1;
          });
        }
      };
    })()"""
    waiting: list[Route] = []
    console: list[str] = []

    def prepare(page: Page) -> None:
        page.add_init_script(damage)
        page.route("**/v1/scenes/*/chunks/*", lambda route: waiting.append(route))
        page.on("pageerror", lambda error: console.append(error.message))
        page.on("console", lambda message: console.append(message.text))

    with viewing(browser, site, prepare=prepare, ready=False) as page:
        page.wait_for_function("() => window.hgs.state.firstFrame !== null")
        for _ in range(2):
            while not waiting:
                page.wait_for_timeout(20)
            waiting.pop().fulfill(body=b"damaged, too")
        problem = page.get_by_role("alert")
        problem.wait_for()
        assert "damaged" in problem.inner_text()
        assert "hash" not in problem.inner_text()  # the hash is for the console
        assert len([line for line in console if "hash" in line]) == 1
        assert_quiet_line(page)
        problem.get_by_role("button", name="Close").click()
        assert not problem.is_visible()


def test_statistics_tell_rates_below_one(browser: Browser, site: Site) -> None:
    """A device that is done with a picture 1.3 seconds after the last one."""
    slow = """(() => {
      const prototype = WebGL2RenderingContext.prototype;
      let last = 0;
      prototype.clientWaitSync = function () {
        if (performance.now() - last < 1300) return this.TIMEOUT_EXPIRED;
        last = performance.now();
        return this.CONDITION_SATISFIED;
      };
    })()"""
    with viewing(browser, site, "?paused=0", prepare=lambda page: page.add_init_script(slow), ready=False) as page:
        page.wait_for_function("() => window.hgs.state.firstFrame !== null")
        page.keyboard.press("s")
        panel = page.locator(".stats")
        value = "xpath=//dt[.='{}']/following-sibling::dd[1]"
        page.locator(".stats", has_text=re.compile(r"Frames/s\s*0\.\d\d")).wait_for()
        dropped, total = panel.locator(value.format("Dropped frames")).inner_text().split(" of ")
        assert 0 < int(dropped) < int(total)
        assert panel.locator(value.format("Quality")).inner_text() == "auto"
        for name, unit in [("Order age", " ms"), ("Sort time", " ms")]:
            assert panel.locator(value.format(name)).inner_text().endswith(unit)


def test_nothing_runs_when_nothing_changes(browser: Browser, site: Site) -> None:
    count = """(() => {
      window.work = 0;
      const request = requestAnimationFrame;
      window.requestAnimationFrame = (callback) => { window.work++; return request.call(window, callback); };
      const style = CSSStyleDeclaration.prototype;
      for (const [owner, name] of [[Element.prototype, "setAttribute"], [style, "setProperty"]]) {
        const original = owner[name];
        owner[name] = function (...values) { window.work++; return original.apply(this, values); };
      }
    })()"""
    at_rest = """() => {
      if (window.work !== window.before) window.since = performance.now();
      window.before = window.work;
      return performance.now() - window.since > 1000;
    }"""
    with viewing(browser, site, prepare=lambda page: page.add_init_script(count)) as page:
        page.wait_for_function(at_rest, polling=100)  # a loop of animation frames would never end
        work = page.evaluate("() => window.work")
        page.keyboard.press("Shift+ArrowLeft")  # and a change wakes it
        page.wait_for_function("(work) => window.work > work", arg=work)
        page.wait_for_function(at_rest, polling=100)
