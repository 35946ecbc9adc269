"""The page in a real browser: quiet, offline, usable, and nothing beside or over anything else."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

# Pairs of words of one chart that share more than a pixel each way.
COLLISIONS = """() => [...document.querySelectorAll("svg")].flatMap((svg) => {
  const boxes = [...svg.querySelectorAll("text")].map((t) => [t.textContent, t.getBBox()]);
  return boxes.flatMap(([a, p], i) => boxes.slice(i + 1)
    .filter(([, q]) => Math.min(p.x + p.width, q.x + q.width) - Math.max(p.x, q.x) > 1
      && Math.min(p.y + p.height, q.y + q.height) - Math.max(p.y, q.y) > 4)
    .map(([b]) => `${svg.getAttribute("aria-label")}: ${a} / ${b}`));
})"""
CUT = """() => [...document.querySelectorAll("svg")].flatMap((svg) => {
  const { width } = svg.viewBox.baseVal;
  return [...svg.querySelectorAll("text")]
    .filter((t) => t.getBBox().x < -8 || t.getBBox().x + t.getBBox().width > width + 8)
    .map((t) => `${svg.getAttribute("aria-label")}: ${t.textContent}`);
})"""


@pytest.fixture(params=[(1280, "light"), (390, "dark")], ids=["wide", "phone"])
def page(browser: Browser, report: Path, request: pytest.FixtureRequest) -> Iterator[Page]:
    """The open report; any error on the console and any request but for the file fails the test."""
    width, scheme = request.param
    context = browser.new_context(viewport={"width": width, "height": 800}, color_scheme=scheme)
    try:
        page = context.new_page()
        faults: list[str] = []
        page.on("console", lambda message: faults.append(message.text))
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("request", lambda sent: faults.append(sent.url) if not sent.url.startswith("data:") else None)
        page.goto(report.as_uri())
        yield page
        assert faults == [report.as_uri()]
    finally:
        context.close()


def test_the_page_fits_its_window(page: Page) -> None:
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


def test_words_in_charts_neither_cover_each_other_nor_leave_the_chart(page: Page) -> None:
    assert page.evaluate(COLLISIONS) == []
    assert page.evaluate(CUT) == []


def test_the_wipe_follows_the_pointer_and_the_keys(page: Page) -> None:
    wipe = page.locator(".wipe").first
    wipe.scroll_into_view_if_needed()
    box = wipe.bounding_box()
    assert box is not None
    line = "e => e.querySelector('.line').getBoundingClientRect().x + 1 - e.getBoundingClientRect().x"
    for share in (0.25, 0.8):
        page.mouse.click(box["x"] + share * box["width"], box["y"] + box["height"] / 2)
        assert wipe.evaluate(line) == pytest.approx(share * box["width"], abs=0.01 * box["width"] + 1)
    clip = wipe.evaluate("e => getComputedStyle(e.querySelector('.over')).clipPath")
    before = wipe.evaluate(line)
    page.keyboard.press("Home")
    assert wipe.evaluate(line) == pytest.approx(0, abs=1) != before
    assert wipe.evaluate("e => getComputedStyle(e.querySelector('.over')).clipPath") != clip


def test_all_pictures_are_decoded(page: Page) -> None:
    page.evaluate("() => { for (const d of document.querySelectorAll('details')) d.open = true; }")
    sizes = page.evaluate("() => Promise.all([...document.images].map(i => i.decode().then(() => i.naturalWidth)))")
    assert sizes
    assert set(sizes) == {16, 32, 64}  # crops are smaller
