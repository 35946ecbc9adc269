"""Delivery of pages and scripts to a real browser: bytes on the wire, their order, and permissions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.web_client.relay import relayed

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

VIEWER = Path(__file__).resolve().parents[2] / "server" / "viewer"
HEADERS = 1500  # bytes
ALL_DRAWN = "() => window.hgs?.ready.then(() => true)"


def test_page_of_a_scene_asks_for_all_scripts_at_once_and_gets_them_compressed(browser: Browser, site: Site) -> None:
    with relayed(site.address) as relay:
        relay.hold("/assets/view_page", until="/assets/worker")
        page = browser.new_page()
        try:
            page.goto(site.page.replace(site.address, relay.address))
            page.wait_for_function(ALL_DRAWN)
        finally:
            page.close()
        asked = [path for path in relay.requests if not path.startswith("/v1/")]
    assert relay.overdue == []  # the page itself names the worker, whose name view_page has
    scripts = [path for path in asked if path.startswith("/assets/")]
    assert sorted(scripts) == sorted(set(scripts))  # the worker, too, comes once
    packed = {path: (VIEWER / f"{path.lstrip('/')}.br").stat().st_size for path in scripts}
    assert [path for path in scripts if relay.received[path] > packed[path] + HEADERS] == []


def test_pages_play_within_their_content_security_policy(browser: Browser, site: Site) -> None:
    page = browser.new_page()
    complaints: list[str] = []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    try:
        listed = page.goto(site.address)
        assert listed is not None
        assert "default-src 'none'" in listed.headers["content-security-policy"]
        page.get_by_role("link", name="Clouds").first.wait_for()
        watched = page.goto(site.page)
        assert watched is not None
        assert "default-src 'none'" in watched.headers["content-security-policy"]
        page.wait_for_function(ALL_DRAWN)
    finally:
        page.close()
    assert [text for text in complaints if "Content Security Policy" in text or "Refused" in text] == []


def test_scenes_can_be_shown_in_a_frame_and_the_list_of_jobs_cannot(browser: Browser, site: Site) -> None:
    page = browser.new_page()
    try:
        page.set_content(f'<iframe name="scene" src="{site.page}"></iframe>')
        scene = page.frame("scene")
        assert scene is not None
        scene.wait_for_function(ALL_DRAWN)
        with page.expect_console_message(lambda message: "frame-ancestors" in message.text):
            page.set_content(f'<iframe src="{site.address}"></iframe>')
    finally:
        page.close()
