"""The page of scenes and jobs, and the page of an address at which there is nothing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

STAGES = ["initialise", "masks", "points", "train", "encode", "publish"]  # those of docs/protocol.md, in order
LONG = "a_name_without_any_space_" * 8


def job(name: str, **fields: Any) -> dict[str, Any]:
    """A job as docs/protocol.md has it."""
    return {
        "id": name, "state": "running", "attempt": 1, "capture": f"/captures/{name}", "title": name,
        "preset": "preview", "hold_out": [], "config": {}, "stage": None, "progress": None, "error": None,
        "scene": None, "created": 1.0, "updated": 1.0,
    } | fields  # fmt: skip


def at_stage(stage: str, done: int = 3, total: int = 16, **figures: float) -> dict[str, Any]:
    return {"stage": stage, "progress": {"stage": stage, "done": done, "total": total, "figures": figures}}


def scene(name: str, **fields: Any) -> dict[str, Any]:
    """A scene as docs/protocol.md has it."""
    return {
        "id": name, "title": name, "created": 1.0, "start": 0.0, "end": 2.0, "bytes_total": 1000, "splats_static": 10,
        "splats_dynamic": 5,
    } | fields  # fmt: skip


@contextmanager
def listing(
    browser: Browser, site: Site, scenes: list[dict[str, Any]], jobs: list[dict[str, Any]], **options: Any
) -> Iterator[Page]:
    """The list as it shows these scenes and jobs."""
    context = browser.new_context(**options)
    try:
        page = context.new_page()
        page.route("**/v1/scenes", lambda route: route.fulfill(json={"scenes": scenes}))
        page.route("**/v1/jobs", lambda route: route.fulfill(json={"jobs": jobs}))
        page.route("**/events", lambda route: route.fulfill(status=204))
        page.goto(site.address)
        page.locator(".card, .job").first.wait_for()
        yield page
    finally:
        context.close()


PHONE = {"viewport": {"width": 390, "height": 844}, "device_scale_factor": 3, "has_touch": True, "is_mobile": True}


@pytest.mark.parametrize("options", [PHONE, {"viewport": {"width": 1280, "height": 800}}], ids=["phone", "desktop"])
def test_no_long_name_widens_the_page(browser: Browser, site: Site, options: dict[str, Any]) -> None:
    jobs = [
        job("title", title=LONG, **at_stage("train", **{LONG: 1.0})),
        job("capture", title=None, capture=f"/captures/{LONG}"),
        job("error", state="failed", error=f"/captures/{LONG}: cannot be read; replace it"),
        job("stage", **at_stage(LONG)),
    ]
    with listing(browser, site, [scene("scene", title=LONG)], jobs, **options) as page:
        width = page.evaluate("() => document.documentElement.scrollWidth")
        assert width == options["viewport"]["width"]


def test_controls_are_large_enough_for_fingers(browser: Browser, site: Site) -> None:
    jobs = [job("a", **at_stage("train")), job("b", state="failed"), job("c", state="succeeded", scene="c")]
    with listing(browser, site, [scene("scene")], jobs, **PHONE) as page:
        controls = page.locator("button:visible, a:visible").all()
        boxes = [control.bounding_box() for control in controls]
        assert len(boxes) == 4
        assert all(box and box["width"] >= 44 and box["height"] >= 44 for box in boxes), boxes


def test_every_stage_has_words_and_a_step(browser: Browser, site: Site) -> None:
    with listing(browser, site, [], [job(stage, **at_stage(stage)) for stage in STAGES]) as page:
        rows = page.locator(".job").all()
        words = [row.locator(".job-state").inner_text() for row in rows]
        steps = [row.locator("[data-state=now]").all_inner_texts() for row in rows]
        assert [f"{step} 3 / 16" for (step,) in steps] == words
        assert [row.locator("[data-state=done]").count() for row in rows] == [0, 0, 1, 2, 3, 4]


def test_an_unknown_stage_shows_its_name_and_its_progress(browser: Browser, site: Site) -> None:
    with listing(browser, site, [], [job("a", **at_stage("depth_maps", 4, 16))]) as page:
        assert page.locator(".job-state").inner_text() == "Depth maps 4 / 16"
        assert page.locator(".job progress").evaluate("(bar) => bar.value / bar.max") == 0.25
        assert not page.locator(".job-steps").is_visible()


def test_only_a_scene_that_lasts_wears_its_length(browser: Browser, site: Site) -> None:
    scenes = [scene("moving"), scene("still", end=0.0, splats_dynamic=0)]
    with listing(browser, site, scenes, []) as page:
        moving, still = page.locator(".card").all()
        assert moving.locator(".card-length").inner_text() == "2.0 s"
        assert still.locator(".card-length").count() == 0
        assert "still" in still.locator(".card-figures").inner_text()


@pytest.mark.parametrize("path", ["/nothing", "/view", "/view/no/such/page"])
def test_an_address_without_a_page_says_so_and_leads_to_the_list(browser: Browser, site: Site, path: str) -> None:
    page = browser.new_page()
    try:
        page.goto(site.address + path)
        page.get_by_role("heading", name="There is nothing at this address").wait_for()
        assert page.title() == "Not found · HGS"
        page.get_by_role("link", name="All scenes").click()
        page.get_by_role("link", name="Clouds").wait_for()
    finally:
        page.close()
