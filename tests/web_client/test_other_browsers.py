"""The player and the console in Firefox and WebKitGTK, judged as in Chromium."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pytest

from benchmarks.viewers.browser import canvas_floats, canvas_pixels, psnr
from tests.web_client.other_browsers import HINTS, OPENERS, DrivenPage, xvfb
from tests.web_client.relay import relayed
from tests.web_client.test_browser import CANVAS_PSNR, FLOAT_PSNR, Reference, exact, reference, reference_picture
from tests.web_client.test_embedding import HEAD, SCRIPT, STOOD, host, player

if TYPE_CHECKING:
    from tests.web_client.conftest import Site
    from tests.web_client.test_embedding import Host

__all__ = ["host", "reference"]

pytestmark = [pytest.mark.browser, pytest.mark.timeout(400)]

READY = "() => window.hgs?.ready.then(() => true)"


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    if shutil.which("Xvfb") is None:
        pytest.skip("no Xvfb: apt-get install xvfb")
    with xvfb() as name:
        yield name


@pytest.fixture(scope="module", params=sorted(OPENERS))
def opened(
    request: pytest.FixtureRequest, display: str, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[DrivenPage]:
    """One process of each browser for all tests."""
    find, opening = OPENERS[request.param]
    if find() is None:
        pytest.skip(HINTS[request.param])
    with opening(display, tmp_path_factory.mktemp(request.param)) as page:
        yield page


@pytest.fixture
def page(opened: DrivenPage) -> Iterator[DrivenPage]:
    """The browser's page; a test fails with every error that no script caught."""
    before = len(opened.errors())
    yield opened
    assert opened.errors()[before:] == []


def show(page: DrivenPage, address: str) -> DrivenPage:
    page.goto(address)
    page.wait_for_function(READY)
    return page


@pytest.mark.parametrize("camera", ["side", "above", "askew"])
def test_canvas_shows_the_reference_picture(page: DrivenPage, site: Site, reference: Reference, camera: str) -> None:
    show(page, exact(site, camera, 0.4))
    floats, canvas = (psnr(take(page), reference(camera, 0.4)) for take in (canvas_floats, canvas_pixels))
    print(f"{page.name} {page.version}, {camera}, 0.4 s: float picture {floats:.1f} dB, canvas {canvas:.1f} dB")
    assert floats >= FLOAT_PSNR
    assert canvas >= CANVAS_PSNR


def test_splats_thinner_than_a_pixel_are_drawn_with_antialiasing(page: DrivenPage, dust: Site) -> None:
    show(page, exact(dust, "far", 0.4))
    truth = reference_picture(dust, "far", 0.4, antialiased=True)
    assert psnr(canvas_floats(page), truth) >= FLOAT_PSNR
    assert psnr(canvas_pixels(page), truth) >= CANVAS_PSNR


def test_play_moves_the_picture_and_seek_holds_it_at_its_time(
    page: DrivenPage, site: Site, reference: Reference
) -> None:
    show(page, exact(site, "side", 0.0))
    before = canvas_pixels(page)
    page.evaluate("() => window.hgs.play()")
    page.wait_for_function("() => window.hgs.state.time > 0.3")
    assert psnr(before, canvas_pixels(page)) < 35
    page.evaluate("() => { window.hgs.pause(); return window.hgs.seek(1.7) }")
    assert page.evaluate("() => [window.hgs.state.playing, window.hgs.state.time]") == [False, 1.7]
    assert psnr(canvas_pixels(page), reference("side", 1.7)) >= CANVAS_PSNR


def test_a_connection_that_the_server_closes_is_taken_up_again(
    page: DrivenPage, site: Site, reference: Reference
) -> None:
    with relayed(site.address) as relay:
        relay.cut("/stream", after=20_000)
        show(page, exact(site, "side", 0.4).replace(site.address, relay.address))
        assert sum("/stream" in path for path in relay.requests) == 2
        assert psnr(canvas_pixels(page), reference("side", 0.4)) >= CANVAS_PSNR


def test_lost_context_is_told_and_comes_back_with_the_same_picture(page: DrivenPage, site: Site) -> None:
    show(page, exact(site, "side", 0.4))
    before = canvas_pixels(page)
    page.evaluate(
        """() => {
          const [host] = [...document.querySelectorAll("*")].filter(({ shadowRoot }) => shadowRoot);
          window.shadow = host.shadowRoot;
          window.lose = shadow.querySelector("canvas").getContext("webgl2").getExtension("WEBGL_lose_context");
          window.lose.loseContext();
        }"""
    )
    told = "() => shadow.textContent.includes('The graphics card was reset')"
    page.wait_for_function(told)
    page.evaluate("() => window.lose.restoreContext()")
    page.wait_for_function(f"() => !({told})()")
    page.evaluate("() => window.hgs.seek(0.4)")
    assert np.array_equal(canvas_pixels(page), before)


def test_the_element_is_as_a_video(page: DrivenPage, host: Host, reference: Reference) -> None:
    """Events and properties of media elements, and the picture."""
    listen = """<script>
      window.heard = [];
      addEventListener("DOMContentLoaded", () => {
        for (const type of ["manifest", "ready", "play", "pause", "ended", "error"])
          one.addEventListener(type, () => heard.push(type));
      });
    </script>"""
    (host.folder / "index.html").write_text(HEAD + listen + SCRIPT + player('camera="side" t="0.4"'))
    page.goto(f"{host.address}/index.html")
    page.wait_for_function("() => heard.includes('ready')")
    page.evaluate("() => { window.hgs = one.player; one.currentTime = 0.4 }")
    page.evaluate(STOOD, "one")
    assert psnr(canvas_pixels(page), reference("side", 0.4)) >= CANVAS_PSNR
    page.evaluate("() => { one.currentTime = 1.9; one.play() }")
    page.wait_for_function("() => heard.includes('ended')")
    assert page.evaluate("() => [one.paused, one.currentTime, one.duration, one.ended]") == [True, 2, 2, True]
    assert page.evaluate("() => heard") == ["manifest", "ready", "play", "pause", "ended"]


@pytest.mark.parametrize(
    ("path", "words"), [("/", "Clouds"), ("/new", "New scene"), ("/job/none", "There is no such job")]
)
def test_pages_of_the_console_show_what_they_are_for(page: DrivenPage, site: Site, path: str, words: str) -> None:
    page.goto(site.address + path)
    page.wait_for_function("(words) => document.querySelector('main')?.innerText.includes(words)", words)
