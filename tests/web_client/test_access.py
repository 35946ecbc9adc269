"""A server that asks for keys, in a browser: the key is asked for, kept, and forgotten; links need none."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.conftest import REPOSITORY
from tests.web_client.conftest import serving
from tests.web_client.test_view_page import PHONE

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]


def hgs(home: Path, *arguments: str) -> str:
    command = [sys.executable, "-m", "server.cli", *arguments]
    environment = os.environ | {"HGS_HOME": str(home)}
    return subprocess.run(
        command, env=environment, cwd=REPOSITORY, check=True, capture_output=True, text=True
    ).stdout.strip()


@pytest.fixture(scope="module")
def guarded(site: Site, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, str, Path]]:
    """The address of a server that asks for keys, a key of it, and its home; its scene is `clouds`."""
    home = tmp_path_factory.mktemp("guarded")
    key = hgs(home, "keys", "add", "anna", "--scope", "submit", "--scope", "publish")
    with serving([site.folder.parent], home) as [page]:
        yield page.partition("/view/")[0], key, home


def give(page: Page, key: str) -> None:
    page.get_by_label("Key", exact=True).fill(key)
    page.get_by_role("button", name="Open").click()


def test_the_console_asks_for_a_key_and_keeps_it(browser: Browser, guarded: tuple[str, str, Path]) -> None:
    address, key, _ = guarded
    context = browser.new_context()
    page = context.new_page()
    page.goto(address)
    page.get_by_label("Key", exact=True).wait_for()
    give(page, "hgs_nonsense")
    page.get_by_role("alert").filter(has_text="not a key of this server").wait_for()
    give(page, key)
    page.get_by_role("link", name="Clouds").first.wait_for()
    assert key.rpartition("_")[2] not in page.evaluate("() => document.cookie + JSON.stringify(localStorage)")
    page.reload()
    page.get_by_role("link", name="Clouds").first.wait_for()
    page.goto(f"{address}/view/clouds?paused=1")
    page.wait_for_function("() => window.hgs?.ready.then(() => true)")
    page.goto(address)
    page.get_by_role("button", name="Sign out anna").click()
    page.get_by_label("Key", exact=True).wait_for()
    context.close()


def test_a_scene_asks_for_a_key_and_plays_when_it_is_given(browser: Browser, guarded: tuple[str, str, Path]) -> None:
    address, key, _ = guarded
    context = browser.new_context(**PHONE)
    page = context.new_page()
    page.goto(f"{address}/view/clouds?paused=1")
    page.get_by_label("Key", exact=True).wait_for()
    assert page.evaluate("() => window.hgs === undefined")  # no player goes on behind the page that asks
    give(page, key)
    page.wait_for_function("() => window.hgs?.ready.then(() => true)")
    assert page.url == f"{address}/view/clouds?paused=1"
    context.close()


def test_a_link_plays_its_scene_without_a_key_until_it_expires(
    browser: Browser, guarded: tuple[str, str, Path]
) -> None:
    address, _, home = guarded
    link = hgs(home, "keys", "link", "clouds", "--for", "1h")
    context = browser.new_context()
    page = context.new_page()
    page.goto(f"{address}{link}&paused=1")
    page.wait_for_function("() => window.hgs?.ready.then(() => true)")
    assert page.evaluate("() => window.hgs.state.complete")
    page.goto(f"{address}{link}x&paused=1")
    page.get_by_role("heading", name="This link has expired").wait_for()
    context.close()
