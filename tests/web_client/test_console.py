"""The console on a real server with a worker: making a scene, following its job, and managing scenes."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest
from PIL import Image

from tests.web_client.conftest import serving

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(300)]

WAIT = 60_000  # ms, for what a worker does on a busy machine
ALL = 400  # iterations of stepwise_pipeline
CAMERAS = ("left", "middle", "right")


@dataclass(frozen=True)
class Console:
    """A server with a worker that trains as far as captures say."""

    address: str  # http://host:port
    captures: Path

    def let_train(self, name: str, until: int = ALL) -> None:
        """Let the training of a capture go on until so many iterations are done."""
        _replace(self.captures / name / "until", str(until))


def _replace(file: Path, text: str) -> None:
    temporary = file.with_suffix(".tmp")
    temporary.write_text(text)
    temporary.replace(file)


def write_capture(folder: Path, scene: Path | None) -> None:
    folder.mkdir(parents=True)
    for name in CAMERAS:
        Image.new("RGB", (32, 24)).save(folder / f"{name}.png")
    frames = [
        {"file_path": f"{name}.png", "transform_matrix": [[1, 0, 0, place], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}
        for place, name in enumerate(CAMERAS)
    ]
    transforms = {"fl_x": 50, "w": 32, "h": 24, "frames": frames}
    (folder / "transforms.json").write_text(json.dumps(transforms))
    (folder / "until").write_text("0")
    if scene is not None:
        shutil.copytree(scene, folder / "scene")


@pytest.fixture(scope="module")
def console(tmp_path_factory: pytest.TempPathFactory, site: Site) -> Iterator[Console]:
    captures = tmp_path_factory.mktemp("captures")
    for name in ("studio", "park", "hall", "shows/stage"):
        write_capture(captures / name, site.folder)
    write_capture(captures / "broken", None)
    home = tmp_path_factory.mktemp("console")
    pipeline = {"HGS_PIPELINE": "stepwise_pipeline"}
    with serving([], home, "--captures", str(captures), workers=1, environment=pipeline) as (address,):
        yield Console(address.rstrip("/"), captures)


@pytest.fixture
def page(browser: Browser, console: Console) -> Iterator[Page]:
    context = browser.new_context(base_url=console.address, viewport={"width": 1280, "height": 800})
    context.set_default_timeout(WAIT)
    try:
        yield context.new_page()
    finally:
        context.close()


@pytest.fixture(autouse=True)
def _leave_the_worker_free(console: Console) -> Iterator[None]:
    """Cancel the leftovers of a test, so that its fault is its own."""
    yield
    for job in httpx.get(f"{console.address}/v1/jobs").json()["jobs"]:
        if job["state"] in ("queued", "running"):
            httpx.post(f"{console.address}/v1/jobs/{job['id']}/cancel")


def submit(console: Console, capture: str, title: str, audio: str = "auto") -> str:
    """Queue a job without the form; returns its id."""
    body = {"capture": str(console.captures / capture), "title": title, "audio": audio}
    job: str = httpx.post(f"{console.address}/v1/jobs", json=body).json()["id"]
    return job


def finish(console: Console, job: str) -> None:
    """Wait until a job has ended."""
    with httpx.stream("GET", f"{console.address}/v1/jobs/{job}/events", timeout=300) as events:
        for _ in events.iter_lines():
            pass


def state(console: Console, job: str) -> str:
    found: str = httpx.get(f"{console.address}/v1/jobs/{job}").json()["state"]
    return found


def test_a_scene_is_made_from_the_form_and_followed_to_its_end(console: Console, page: Page) -> None:
    page.goto("/")
    page.get_by_role("link", name="New scene").click()
    page.get_by_text("shows/stage").wait_for()
    page.get_by_role("radio", name=re.compile("^studio")).check()
    assert page.get_by_role("textbox", name="Name").count() == 0  # not visible
    page.get_by_text("More settings").click()
    page.get_by_role("textbox", name="Name").fill("My studio")
    page.get_by_role("radio", name=re.compile("^Preview")).check()
    for name in CAMERAS:
        page.locator(".camera-card", has_text=name).locator("img").wait_for()
    page.get_by_role("checkbox", name="right").check()
    console.let_train("studio", 80)
    page.get_by_role("button", name="Start").click()

    page.wait_for_url("**/job/my-studio-*")
    page.get_by_role("heading", name="My studio", level=1).wait_for()
    page.get_by_text("Training 80 / 400").wait_for()
    job = page.url.rpartition("/")[2]
    submitted = httpx.get(f"{console.address}/v1/jobs/{job}").json()
    assert (submitted["preset"], submitted["hold_out"]) == ("preview", ["right"])
    page.locator(".job-picture img").wait_for()
    curve = page.locator(".chart .curve")
    curve.wait_for()
    assert page.locator("progress").evaluate("(bar) => bar.value") == pytest.approx(0.2)
    assert page.title() == "20% · My studio · HGS"
    early = curve.get_attribute("d")

    console.let_train("studio")
    watch = page.get_by_role("link", name="Watch the scene")
    watch.wait_for()
    page.locator(".job-state", has_text="Done").wait_for()  # the scene can be watched a little before
    assert curve.get_attribute("d") != early
    assert page.get_by_role("button", name="PSNR").get_attribute("aria-pressed") == "true"
    page.get_by_role("button", name="Loss").click()
    history = httpx.get(f"{console.address}/v1/jobs/{job}/history").json()["points"]
    losses = [point["figures"]["loss"] for point in history if point["stage"] == "train" and "loss" in point["figures"]]
    page.get_by_text(f"Now {losses[-1]:.3g}", exact=True).wait_for()
    page.reload()  # the server has kept the course that the page followed
    curve.wait_for()
    watch.click()
    page.wait_for_url(f"**/view/{job}")


def test_what_the_server_refuses_stands_at_its_field(console: Console, page: Page) -> None:
    page.goto("/new")
    page.get_by_role("button", name="Start").click()
    capture = page.locator("fieldset[name=capture]")
    capture.get_by_text("Choose a capture.").wait_for()
    assert page.evaluate("() => document.activeElement.name") == "capture"

    page.get_by_role("radio", name=re.compile("^broken")).check()
    assert capture.locator("#capture-error").inner_text() == ""
    page.get_by_role("button", name="Start").click()
    capture.get_by_text("the picture is unreadable; restore the file").wait_for()

    page.get_by_role("radio", name=re.compile("^park")).check()
    page.get_by_text("More settings").click()
    for name in CAMERAS[:2]:
        page.get_by_role("checkbox", name=name).check()
    page.get_by_text("More settings").click()  # closed
    page.get_by_role("button", name="Start").click()
    page.locator("fieldset[name=hold_out]").get_by_text("leaves 1 of 3 cameras to train on").wait_for()
    box = page.get_by_role("checkbox", name="left")
    assert (box.get_attribute("aria-invalid"), box.is_checked()) == ("true", True)
    assert page.url.endswith("/new")


def test_a_job_is_cancelled_and_tried_again(console: Console, page: Page) -> None:
    console.let_train("park", 40)
    page.goto(f"/job/{submit(console, 'park', 'Park', 'none')}")
    page.get_by_text("Training 40 / 400").wait_for()
    assert "no sound" in page.locator(".page-head").inner_text()
    page.get_by_role("button", name="Cancel").click()
    page.locator(".job-state", has_text="Cancelled").wait_for()
    console.let_train("park")
    page.get_by_role("button", name="Try again").click()
    page.get_by_role("link", name="Watch the scene").wait_for()
    assert "attempt 2" in page.locator(".page-head").inner_text()


@pytest.mark.slow
def test_a_failed_job_says_why_and_goes_on_after_the_cure(console: Console, page: Page) -> None:
    (console.captures / "hall" / "fail").touch()
    console.let_train("hall")
    job = submit(console, "hall", "Hall")
    page.goto(f"/job/{job}")
    page.get_by_text("RuntimeError: the loss is not a number").wait_for()
    page.get_by_text("Log", exact=True).click()
    log = page.get_by_role("region", name="Log")
    log.get_by_text("train begins").wait_for()
    assert "two of 100 frames look alike" in log.inner_text()
    assert "Traceback" in log.inner_text()
    page.get_by_text("Settings", exact=True).click()
    assert page.get_by_role("rowheader", name="Seed", exact=True).is_visible()

    (console.captures / "hall" / "fail").unlink()
    page.get_by_role("button", name="Try again").click()
    page.get_by_role("link", name="Watch the scene").wait_for()
    curve = page.request.get(f"/v1/jobs/{job}/history").json()["points"]
    done = [point["done"] for point in curve if point["stage"] == "train"]
    assert done == sorted(set(done))
    assert (done[0], done[-1]) == (0, ALL)


def test_a_waiting_job_says_what_is_ahead_of_it(console: Console, page: Page) -> None:
    console.let_train("park", 20)
    jobs = [submit(console, "park", f"Queue {number}") for number in range(3)]
    page.goto(f"/job/{jobs[0]}")
    page.get_by_text("Training 20 / 400").wait_for()
    page.goto(f"/job/{jobs[2]}")
    page.get_by_text("One other job is ahead of it.").wait_for()
    for job in jobs[1:]:
        httpx.post(f"{console.address}/v1/jobs/{job}/cancel").raise_for_status()
    page.locator(".job-state", has_text="Cancelled").wait_for()
    page.goto("/")
    row = page.locator(".job", has_text="Queue 0")
    row.get_by_role("button", name="Cancel: Queue 0").click()
    row.get_by_text("Cancelled").wait_for()
    assert state(console, jobs[0]) == "cancelled"


def test_a_scene_is_shared_renamed_and_deleted(console: Console, page: Page) -> None:
    console.let_train("shows/stage")
    job = submit(console, "shows/stage", "Stage")
    finish(console, job)
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.goto("/")
    page.get_by_role("button", name="More about Stage").click()
    page.get_by_role("button", name="Copy link").click()
    page.get_by_role("status").get_by_text("Link copied").wait_for()
    assert page.evaluate("() => navigator.clipboard.readText()") == f"{console.address}/view/{job}"

    page.get_by_role("button", name="More about Stage").click()
    page.get_by_role("button", name="Rename …").click()
    dialog = page.get_by_role("dialog", name="Rename the scene")
    dialog.get_by_role("textbox").fill("two\u2028lines")
    dialog.get_by_role("button", name="Rename").click()
    dialog.get_by_text("contains control characters").wait_for()
    dialog.get_by_role("textbox").fill("On stage")
    dialog.get_by_role("button", name="Rename").click()
    page.get_by_role("heading", name="On stage", exact=True).wait_for()
    assert httpx.get(f"{console.address}/v1/scenes/{job}").json()["title"] == "On stage"

    watcher = page.context.new_page()
    watcher.goto(f"/view/{job}")
    watcher.wait_for_function("() => window.hgs !== undefined")
    watcher.get_by_role("heading", name="On stage").wait_for()
    page.get_by_role("button", name="More about On stage").click()
    page.get_by_role("button", name="Delete …").click()
    dialog = page.get_by_role("dialog", name="Delete On stage?")
    assert dialog.get_by_role("button", name="Cancel").evaluate("(button) => button === document.activeElement")
    dialog.get_by_role("button", name="Delete").click()
    page.get_by_role("heading", name="On stage", exact=True).wait_for(state="detached")
    assert httpx.get(f"{console.address}/v1/scenes/{job}").status_code == 404
    row = page.locator(".job").filter(has=page.locator(f"a[href='/job/{job}']"))
    row.get_by_role("link", name=re.compile("^Watch")).wait_for(state="hidden")
    page.goto(f"/job/{job}")
    page.locator(".job-state", has_text="Done").wait_for()
    assert not page.get_by_role("link", name="Watch the scene").is_visible()


def test_a_report_is_offered_once_it_is_there(
    console: Console, page: Page, tmp_path_factory: pytest.TempPathFactory
) -> None:
    console.let_train("studio")
    job = submit(console, "studio", "Reported")
    finish(console, job)
    page.goto(f"/job/{job}")
    page.get_by_role("link", name="Watch the scene").wait_for()
    assert not page.get_by_role("link", name="Report").is_visible()
    run = next(tmp_path_factory.getbasetemp().glob(f"console*/runs/{job}"))
    script = (
        "document.title = window.origin; try { document.cookie; } catch (error) { document.title += ' ' + error.name; }"
    )
    (run / "report.html").write_text(f"<!doctype html><title>Report</title><script>{script}</script>")
    page.reload()
    with page.expect_popup() as popup:
        page.get_by_role("link", name="Report").click()
    popup.value.wait_for_load_state()
    assert popup.value.title() == "null SecurityError"  # an origin of its own


def test_a_job_that_is_not_there_says_so(page: Page) -> None:
    page.goto("/job/nothing")
    page.get_by_role("heading", name="There is no such job").wait_for()
