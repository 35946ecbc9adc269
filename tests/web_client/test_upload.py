"""Sending a folder from the browser: lines that break, pages that are closed, the check, and the job."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest

from tests.web_client.conftest import serving
from tests.web_client.test_console import write_capture
from tests.web_client.test_console_pages import small_controls, violations

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Page, Route

pytestmark = [pytest.mark.browser, pytest.mark.timeout(300)]

LARGE = 20 << 20  # bytes: more than two pieces


@dataclass(frozen=True)
class Receiver:
    """A server without captures and without a worker."""

    address: str
    home: Path

    def uploads(self) -> list[dict[str, object]]:
        found: list[dict[str, object]] = httpx.get(f"{self.address}/v1/uploads").json()["uploads"]
        return found


@pytest.fixture(scope="module")
def receiver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Receiver]:
    home, captures = tmp_path_factory.mktemp("home"), tmp_path_factory.mktemp("captures")
    with serving([], home, "--captures", str(captures), "--uploads", "upload=30M,free=0") as (address,):
        yield Receiver(address.rstrip("/"), home)


@pytest.fixture
def context(browser: Browser, receiver: Receiver) -> Iterator[BrowserContext]:
    context = browser.new_context(base_url=receiver.address, viewport={"width": 1280, "height": 900})
    context.set_default_timeout(60_000)
    yield context
    context.close()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A capture of grey photographs, and a large file beside them."""
    write_capture(tmp_path / "studio", None)
    (tmp_path / "studio" / "large.bin").write_bytes(os.urandom(LARGE))
    (tmp_path / "studio" / ".hidden").write_text("stays at home")
    return tmp_path / "studio"


def choose(page: Page, folder: Path, address: str = "/new") -> None:
    page.goto(address)
    page.locator("input[webkitdirectory]").set_input_files(folder)


@pytest.mark.slow
def test_a_folder_is_sent_checked_and_trained(context: BrowserContext, receiver: Receiver, folder: Path) -> None:
    """A request is lost, a page is closed half-way, and another goes on."""
    sent: list[str] = []

    def lose_one_and_hold_the_last(route: Route) -> None:
        sent.append(route.request.headers.get("upload-offset", "0"))
        if len(sent) == 1:
            route.abort()
        elif int(sent[-1]) < 16 << 20:
            route.continue_()  # and the last piece of the large file is never answered

    first = context.new_page()
    first.route("**/v1/uploads/*/files/*", lose_one_and_hold_the_last)
    choose(first, folder)
    first.get_by_text("5 of 6 files").wait_for()
    assert violations(first) == []
    while int(str(receiver.uploads()[0]["received"])) < 16 << 20:
        first.wait_for_timeout(20)
    first.get_by_role("button", name="Pause").click()
    first.get_by_text("Paused · ").wait_for()
    first.close()
    (upload,) = receiver.uploads()
    assert (upload["state"], upload["verified"]) == ("receiving", 5)

    page = context.new_page()
    begun: list[str] = []
    page.on("request", lambda request: begun.append(request.headers.get("upload-offset", "")))
    choose(page, folder, "/")  # the empty list takes it too, and goes on to the form
    page.get_by_text("This capture would not train well:").wait_for()
    assert "0" not in begun  # nothing was sent twice
    (upload,) = receiver.uploads()
    capture = Path(str(upload["capture"]))
    assert sorted(path.name for path in capture.iterdir()) == sorted(
        path.name for path in folder.iterdir() if path.name != ".hidden"
    )
    for file in capture.iterdir():
        assert file.read_bytes() == (folder / file.name).read_bytes()
    assert page.get_by_role("radio", name="studio").is_checked()
    page.get_by_text("Figures of 3 cameras").click()
    assert violations(page) == []
    assert small_controls(page) == []
    assert page.get_by_text("is nothing but the level").first.is_visible()
    page.get_by_role("checkbox", name="Train it anyway").check()
    page.get_by_role("button", name="Start").click()
    page.wait_for_url("**/job/studio-*")
    job = httpx.get(f"{receiver.address}/v1/jobs/{page.url.rpartition('/')[2]}").json()
    assert (job["capture"], job["config"]["capture"]["trust_poses"]) == (str(capture), True)

    page.goto("/new")  # needed by the job, and deleted after its end
    page.get_by_text("Sent to this server: 1").click()
    page.get_by_role("button", name="Delete studio …").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    page.get_by_role("alert").get_by_text("wait until it ends, or cancel it").wait_for()
    httpx.post(f"{receiver.address}/v1/jobs/{job['id']}/cancel")
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    page.get_by_role("heading", name="No captures yet").wait_for()
    assert not capture.exists()


def test_what_the_server_refuses_is_told_in_its_words(context: BrowserContext, folder: Path) -> None:
    (folder / "larger.bin").write_bytes(bytes(LARGE))
    page = context.new_page()
    choose(page, folder)
    page.locator(".upload-words", has_text="one upload may have 30.0 MB; send less").wait_for()
    page.get_by_role("button", name="Cancel").click()
    assert page.get_by_text("Choose a folder …").is_visible()
