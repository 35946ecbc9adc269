"""Sound and picture in a real browser: in step, and silent until a visitor wants to hear it."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from hgs_core.codec import load_manifest
from tests.web_client.clicking_scene import FARTHEST, TAP, ahead, publish_clicks
from tests.web_client.test_console_pages import violations

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

UNTOUCHED = """(() => {
  let touched = false;
  for (const type of ["pointerdown", "keydown"]) addEventListener(type, () => { touched = true; }, true);
  Object.defineProperty(navigator, "userActivation", { value: { get hasBeenActive() { return touched; } } });
})()"""
PICTURED = "() => document.querySelector('hgs-player')?.player?.statistics?.firstFrame != null"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A published scene of six seconds with clicks."""
    return publish_clicks(tmp_path_factory.mktemp("runs") / "run")


@pytest.fixture
def site(folder: Path) -> Iterator[str]:
    """Its address."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *_: object) -> None:
            """Say nothing."""

    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def test_sound_is_in_step_with_the_picture_after_a_seek_and_at_other_rates(browser: Browser, site: str) -> None:
    page = browser.new_page()
    try:
        page.add_init_script(path=str(TAP))
        page.goto(site)
        page.wait_for_function(PICTURED)
        page.evaluate("""() => {
          window.samples = [];
          const element = document.querySelector("hgs-player");
          element.muted = false;
          element.player.addEventListener("frame", () => {
            window.samples.push([document.timeline.currentTime, element.currentTime]);
          });
        }""")
        measured = {"from the start": ahead(page, 1.0)}
        page.evaluate("() => { document.querySelector('hgs-player').currentTime = 2.9; }")
        measured["after a seek"] = ahead(page, 1.0)
        for rate in (0.5, 2.0):
            page.evaluate("(rate) => { document.querySelector('hgs-player').playbackRate = rate; }", rate)
            page.wait_for_timeout(100)
            measured[f"at rate {rate}"] = ahead(page, rate)
        page.evaluate("() => { document.querySelector('hgs-player').pause(); }")
        page.wait_for_function("() => window.context.state === 'suspended'")  # nothing sounds, nothing costs power
    finally:
        page.close()
    assert all(abs(milliseconds) <= FARTHEST for milliseconds in measured.values()), measured


def test_a_scene_is_silent_until_a_visitor_wants_to_hear_it(browser: Browser, site: str, folder: Path) -> None:
    audio = load_manifest(folder).audio
    assert audio is not None
    asked: list[str] = []
    page = browser.new_page()
    try:
        page.on("request", lambda request: asked.append(request.url.rpartition("/")[2]))
        page.add_init_script(UNTOUCHED)
        page.goto(site)
        page.wait_for_function(PICTURED)
        sound_on = page.get_by_role("button", name="Sound on")
        sound_on.wait_for()
        assert page.evaluate("() => document.querySelector('hgs-player').muted")
        assert set(audio.sizes).isdisjoint(asked)
        sound_on.click()
        page.get_by_role("button", name="Mute").wait_for()
        page.get_by_role("slider", name="Volume").fill("0.5")
        assert page.evaluate("() => document.querySelector('hgs-player').volume") == 0.5
        page.keyboard.press("m")
        sound_on.wait_for()
        page.keyboard.press("m")
        page.get_by_role("button", name="Mute").wait_for()
        assert violations(page) == []
        page.evaluate("() => document.querySelector('hgs-player').toggleAttribute('muted', true)")
        sound_on.wait_for()
        assert not set(audio.sizes).isdisjoint(asked)
    finally:
        page.close()


def test_sound_that_cannot_be_decoded_is_told_and_the_scene_plays_on(browser: Browser, site: str, folder: Path) -> None:
    audio = load_manifest(folder).audio
    assert audio is not None
    page = browser.new_page()
    try:
        for name in audio.sizes:
            page.route(f"**/chunks/{name}", lambda route: route.fulfill(body=b"no sound"))
        page.goto(site)
        page.wait_for_function(PICTURED)
        page.evaluate("() => { document.querySelector('hgs-player').muted = false; }")
        page.get_by_text("This browser cannot play the scene's sound.").wait_for()
        page.wait_for_function("(time) => document.querySelector('hgs-player').currentTime > time", arg=1.0)
    finally:
        page.close()
