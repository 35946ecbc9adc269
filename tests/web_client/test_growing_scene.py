"""A scene that grows while a page plays it: from a server, and from a folder."""

from __future__ import annotations

import dataclasses
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from hgs_core.codec.format.growth import first_segments
from hgs_core.codec.format.scene_folder import load_manifest
from jobs.artifacts.artifact_store import ArtifactStore
from server.publishing.web_folder import publish_to_folder
from tests.web_client.conftest import serving
from tests.web_client.test_embedding import PLAYER, hosting

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

WAITS = "More of this scene is still being made"


def write_growing(site: Site, run: Path, segments: int) -> None:
    """Write the clouds as they were while they had so many segments of their two."""
    shutil.copytree(site.folder, run / "scene", dirs_exist_ok=True)
    manifest = dataclasses.replace(first_segments(load_manifest(site.folder), segments), title="Growing")
    (run / "scene" / "manifest.json").write_text(json.dumps(manifest.to_json()))


def watch(page: Page, grow: Callable[[], object]) -> None:
    """Expect a page that shows a player to play to the edge, to wait there with a word, and to go on."""
    page.get_by_text(WAITS).wait_for()
    bar = page.get_by_label("Position")
    assert bar.get_attribute("max") == "1"
    assert float(bar.input_value()) == pytest.approx(1.0, abs=0.01)
    bar.fill("0")  # a second behind the edge: a busy machine looks every half
    page.get_by_text(WAITS).wait_for(state="hidden")
    page.get_by_text(WAITS).wait_for()
    grow()
    page.get_by_text(WAITS).wait_for(state="hidden")
    page.wait_for_function("() => Number(hgsBar().value) > 1.05")
    assert bar.get_attribute("max") == "2"


BAR = """() => {
  window.hgsBar = (root = document) => {
    for (const node of root.querySelectorAll("*")) {
      if (node.matches(".seek")) return node;
      const inside = node.shadowRoot && window.hgsBar(node.shadowRoot);
      if (inside) return inside;
    }
    return null;
  };
}"""


def test_page_of_a_server_follows_a_scene_that_grows(browser: Browser, site: Site, tmp_path: Path) -> None:
    (tmp_path / "home").mkdir()
    store = ArtifactStore((tmp_path / "home" / "store").as_uri())

    def publish(segments: int) -> None:
        write_growing(site, tmp_path / "run", segments)
        store.put_scene(tmp_path / "run" / "scene", "growing")

    publish(1)
    context = browser.new_context(viewport={"width": 640, "height": 480})
    try:
        with serving([], tmp_path / "home") as [address]:
            page = context.new_page()
            page.goto(f"{address.rstrip('/')}/view/growing")
            page.evaluate(BAR)
            watch(page, lambda: publish(2))
    finally:
        context.close()


@pytest.mark.slow
def test_page_of_a_folder_follows_a_scene_that_grows(browser: Browser, site: Site, tmp_path: Path) -> None:
    def publish(segments: int) -> None:
        write_growing(site, tmp_path / "run", segments)
        publish_to_folder(tmp_path / "run", tmp_path / "site", player=PLAYER)

    publish(1)
    context = browser.new_context(viewport={"width": 640, "height": 480})
    with hosting(tmp_path / "site") as host:
        try:
            page = context.new_page()
            page.goto(host.address)
            page.evaluate(BAR)
            watch(page, lambda: publish(2))
        finally:
            context.close()
