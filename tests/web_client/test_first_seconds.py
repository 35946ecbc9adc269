"""The first seconds: a scene's poster, painted before any script, and a clock at rest."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from PIL import Image

from benchmarks.viewers.browser import canvas_pixels, open_viewer
from hgs_core.codec import encode_scene
from hgs_core.codec.format.scene_folder import load_manifest
from server.publishing.web_folder import publish_to_folder
from tests.web_client.conftest import HEIGHT, WIDTH, serving
from tests.web_client.test_embedding import PLAYER, SCRIPT, embedding, host, hosting, player, wait_for_picture
from tests.web_client.test_view_page import PHONE

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page, Route

    from tests.web_client.conftest import Site
    from tests.web_client.test_embedding import Host

__all__ = ["host"]

pytestmark = [pytest.mark.browser, pytest.mark.timeout(180)]

FIRST = "() => (window.hgs?.state ?? document.querySelector('hgs-player')?.player?.statistics)?.firstFrame != null"
ARRIVED = """() => performance.getEntriesByType("resource").some(
  ({ name, responseEnd }) => name.includes("thumbnail") && responseEnd > 0)"""
GROUND = (90, 60, 120)  # colour of the clouds' thumbnail
DARK_TIMES = """(() => {
  window.dark = [];
  const look = () => {
    const state = window.hgs?.state;
    if (state && state.time !== null && state.firstFrame === null) dark.push(state.time);
    requestAnimationFrame(look);
  };
  look();
})()"""


def middle(page: Page) -> np.ndarray:
    """The colour in the middle of the page, above the line about loading."""
    with Image.open(BytesIO(page.screenshot())) as shot:
        return np.asarray(shot.convert("RGB").getpixel((shot.width // 2, shot.height // 4)), dtype=float)


def is_poster(colour: np.ndarray) -> bool:
    return bool(np.abs(colour - GROUND).max() < 12)


def wait_for_poster(page: Page) -> None:
    while not is_poster(middle(page)):
        page.wait_for_timeout(50)


@contextmanager
def held_scripts(browser: Browser, address: str, **options: Any) -> Iterator[tuple[Page, list[Route]]]:
    """A page of which no script has come, and the requests for them, as the browser makes them."""
    context = browser.new_context(**({"viewport": {"width": 800, "height": 600}, "reduced_motion": "reduce"} | options))
    held: list[Route] = []
    try:
        page = context.new_page()
        page.route("**/*.js", lambda route: held.append(route))
        page.goto(address, wait_until="commit")
        page.wait_for_function("() => document.body")  # a picture needs a frame
        yield page, held
    finally:
        context.close()


def let_go(page: Page, held: list[Route]) -> None:
    page.route("**/*.js", lambda route: route.continue_())
    for route in held:
        route.continue_()


@pytest.mark.parametrize("options", [{}, PHONE], ids=["desk", "phone"])
@pytest.mark.parametrize("where", ["server", "folder"])
def test_the_poster_is_painted_before_any_script_and_goes_with_the_first_picture(
    browser: Browser, site: Site, tmp_path: Path, where: str, options: dict[str, Any]
) -> None:
    publish_to_folder(site.folder.parent, tmp_path / "site", player=PLAYER)
    with hosting(tmp_path / "site") as folder:
        address = f"{site.page}?paused=1" if where == "server" else folder.address
        with held_scripts(browser, address, **options) as (page, held):
            wait_for_poster(page)
            assert page.evaluate("() => !window.hgs && !document.querySelector('hgs-player')?.player")
            let_go(page, held)
            page.wait_for_function(FIRST)
            page.wait_for_function("() => new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)))")
            assert not is_poster(middle(page))


@pytest.mark.slow
def test_the_poster_is_framed_as_the_first_picture(browser: Browser, site: Site, tmp_path: Path) -> None:
    """A scene with its own first picture as thumbnail: nothing moves when the scene takes the poster's place."""
    size = {"width": WIDTH, "height": HEIGHT}
    with open_viewer(browser, f"{site.page}?paused=1&width={WIDTH}&height={HEIGHT}&exact=1", **size) as page:
        picture = canvas_pixels(page)
    thumbnail = BytesIO()
    Image.fromarray(picture[..., :3]).save(thumbnail, "JPEG", quality=95)
    run = tmp_path / "framed"
    manifest = load_manifest(site.folder)
    encode_scene(
        site.scene,
        run / "scene",
        cameras=manifest.cameras,
        times=np.linspace(0.0, 2.0, 31),
        title="Framed",
        thumbnail=lambda alone: thumbnail.getvalue(),
    )
    publish_to_folder(run, tmp_path / "site", player=PLAYER)
    (tmp_path / "home").mkdir()
    with serving([run], tmp_path / "home") as [address], hosting(tmp_path / "site") as folder:
        for width, height in ((800, 600), (1000, 300), (300, 600)):
            for opened in (f"{address}?paused=1", folder.address):
                viewport = {"width": width, "height": height}
                with held_scripts(browser, opened, viewport=viewport) as (page, held):
                    page.wait_for_function(ARRIVED)
                    page.wait_for_timeout(200)
                    poster = shown(page)
                    let_go(page, held)
                    page.wait_for_function(FIRST)
                    page.evaluate("() => (window.hgs?.ready)")
                    page.wait_for_timeout(500)
                    assert similar(poster, shown(page)) > 0.9, (width, height, opened)


def shown(page: Page) -> np.ndarray:
    """The upper middle of the page, small and grey, clear of bars."""
    with Image.open(BytesIO(page.screenshot())) as shot:
        box = (0, int(0.2 * shot.height), shot.width, int(0.7 * shot.height))
        return np.asarray(shot.convert("L").crop(box).resize((64, 32)), dtype=float)


def similar(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.corrcoef(one.ravel(), other.ravel())[0, 1])


def test_a_scene_without_a_thumbnail_has_no_poster_and_nothing_is_missing(
    browser: Browser, dust: Site, tmp_path: Path
) -> None:
    publish_to_folder(dust.folder.parent, tmp_path / "site", player=PLAYER)
    missing: list[str] = []
    errors: list[str] = []
    with hosting(tmp_path / "site") as folder:
        for address in (dust.page, folder.address):
            page = browser.new_page()
            page.on("response", lambda answer: missing.append(answer.url) if answer.status >= 400 else None)
            page.on("console", lambda line: errors.append(line.text) if line.type == "error" else None)
            page.goto(address)
            page.wait_for_function(FIRST)
            assert "thumbnail" not in page.content()
            page.close()
    assert (missing, errors) == ([], [])


@pytest.mark.parametrize("query", ["?paused=0", "?paused=0&t=0.4"])
def test_the_playhead_stands_until_the_first_picture(browser: Browser, site: Site, query: str) -> None:
    context = browser.new_context(viewport={"width": 800, "height": 600})
    try:
        page = context.new_page()
        page.add_init_script(DARK_TIMES)
        page.goto(site.page + query)
        start = 0.4 if "t=" in query else 0.0
        page.wait_for_function("(start) => window.hgs?.state.time > start", arg=start)
        assert set(page.evaluate("() => dark")) <= {start}
    finally:
        context.close()


def test_a_page_that_paints_the_poster_itself_is_asked_for_it_once(browser: Browser, host: Host) -> None:
    style = "<style>hgs-player { background: #000 url(clouds/thumbnail.jpg) center / cover; }</style>"
    with embedding(browser, host, style + SCRIPT + player('poster="clouds/thumbnail.jpg"')) as page:
        wait_for_picture(page)
        assert page.locator("#one .poster[src]").count() == 0
    assert len([path for path in host.requests if "thumbnail" in path]) == 1
