"""The real page on lines that fall silent, and with chunks that have been damaged on the server's disk."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import pytest

from hgs_core.codec import load_manifest
from tests.web_client.conftest import serving
from tests.web_client.swallowing_proxy import swallowing_proxy

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

READY = "() => window.hgs?.ready.then(() => true)"
NOTICE = "A part of this scene is damaged and cannot be shown."


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    opened = browser.new_page(viewport={"width": 320, "height": 200})
    yield opened
    opened.close()


@pytest.mark.slow
def test_silent_connection_is_replaced_and_what_came_is_kept(page: Page, site: Site) -> None:
    address = urlsplit(site.page)
    assert address.hostname is not None
    assert address.port is not None
    statics = sum(chunk.bytes for chunk in load_manifest(site.folder).static)
    limit = (site.folder / "manifest.json").stat().st_size + statics // 2
    with swallowing_proxy((address.hostname, address.port), limit) as proxy:
        page.goto(f"http://127.0.0.1:{proxy.port}{address.path}?paused=1&t=0.4")
        page.wait_for_function(READY)
        assert proxy.swallowed.is_set()
        assert proxy.websockets == 2
        page.wait_for_function("() => window.hgs.state.bytes >= window.hgs.state.bytesTotal")
        assert page.evaluate("() => window.hgs.state.bytes === window.hgs.state.bytesTotal")  # nothing came twice


@pytest.mark.parametrize(
    "event", ["window.dispatchEvent(new Event('online'))", "document.dispatchEvent(new Event('visibilitychange'))"]
)
def test_connection_is_tried_at_once_when_the_network_or_the_page_is_back(page: Page, site: Site, event: str) -> None:
    """Of a scene that is not complete: only the first of its chunks reaches the page."""
    page.add_init_script(
        """
      window.pings = 0;
      const Original = WebSocket;
      window.WebSocket = class extends Original {
        constructor(url) {
          super(url);
          let frames = 0;
          this.addEventListener("message", (message) => {
            if (new Uint8Array(message.data)[0] === 1 && ++frames > 1) message.stopImmediatePropagation();
          });
        }
        send(data) {
          if (new TextDecoder().decode(data).includes("ping")) window.pings++;
          super.send(data);
        }
      };
    """
    )
    page.goto(f"{site.page}?paused=1&t=0.4")
    page.wait_for_function("() => window.hgs && window.hgs.state.bytes > 0")
    assert page.evaluate(f"() => {{ const before = window.pings; {event}; return window.pings - before; }}") == 1


@pytest.fixture
def damaged(site: Site, tmp_path: Path) -> Iterator[str]:
    """The page of a scene of which a static chunk is damaged, and a dynamic one of the first slice missing."""
    run = tmp_path / "clouds"
    shutil.copytree(site.folder, run / "scene")
    with serving([run], tmp_path) as pages:
        manifest = load_manifest(site.folder)
        chunks = tmp_path / "store" / "chunks"
        path = chunks / manifest.static[-1].id
        data = bytearray(path.read_bytes())
        data[len(data) // 2] ^= 1
        path.write_bytes(data)
        (chunks / manifest.slices[0].chunks[-1].id).unlink()
        yield pages[0]


def test_damaged_chunks_cost_their_splats_and_a_notice(page: Page, damaged: str) -> None:
    page.goto(f"{damaged}?t=0")
    page.wait_for_function(READY)
    page.get_by_role("alert").filter(has_text=NOTICE).wait_for()
    assert page.evaluate("() => window.hgs.state.lostChunks") == 2
    assert page.evaluate("() => window.hgs.state.splats") > 500
    page.wait_for_function("() => window.hgs.state.time > 0.2")  # it plays through the damaged slice


def test_chunk_that_cannot_be_decoded_costs_its_splats_and_a_notice(page: Page, site: Site, flipped_bit: str) -> None:
    """One bit of the stream's first chunk is wrong, and its replacement is wrong too."""
    page.add_init_script(flipped_bit)
    page.route("**/v1/scenes/*/chunks/*", lambda route: route.fulfill(body=b"no chunk"))
    page.goto(f"{site.page}?paused=1&t=0.4")
    page.wait_for_function(READY)
    page.get_by_role("alert").filter(has_text=NOTICE).wait_for()
    assert page.evaluate("() => window.hgs.state.splats") > 0
