"""The box drawn around the part to keep, and the edit that keeps it."""

from __future__ import annotations

import argparse
import json
import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from hgs_core.edit.crop_file import CropFile
from hgs_core.edit.regions import Box, box_of
from server.cli import edit
from tests.web_client.test_view_page import PHONE, viewing

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

DESKTOP = {"width": 1000, "height": 600}


def options(page: Page) -> argparse.Namespace:
    """The command line that the page shows, as `hgs` reads it."""
    command = page.locator(".crop-command").text_content()
    assert command is not None
    assert command.startswith("hgs edit RUN --out NEW ")
    parser = argparse.ArgumentParser()
    edit.add_parser(parser.add_subparsers())
    return parser.parse_args(shlex.split(command)[1:])


def box(page: Page) -> Box:
    return box_of([float(number) for number in options(page).box.split(",")])


def place(page: Page, handle: str) -> tuple[float, float]:
    found = page.locator(f"{handle} .crop-dot").first.bounding_box()
    assert found is not None
    return found["x"] + found["width"] / 2, found["y"] + found["height"] / 2


def drag(page: Page, handle: str, dx: float, dy: float) -> None:
    x, y = place(page, handle)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + dx, y + dy, steps=3)
    page.mouse.up()


def test_a_box_is_drawn_with_the_mouse_and_read_by_hgs(browser: Browser, site: Site) -> None:
    with viewing(browser, site, viewport=DESKTOP) as page:
        loaded: list[str] = []
        page.on("request", lambda request: loaded.append(request.url))
        page.keyboard.press("v")
        page.locator(".crop-panel").wait_for()
        assert any("crop_tool" in url for url in loaded)  # not before it was asked for
        first = box(page)
        x, _ = place(page, ".crop-face")
        drag(page, ".crop-face", 30, 0)
        larger = box(page)
        assert place(page, ".crop-face")[0] == pytest.approx(x + 30, abs=10)  # its way is seen askew
        assert larger.size[0] > first.size[0]
        np.testing.assert_allclose(larger.size[1:], first.size[1:])
        np.testing.assert_allclose(  # the opposite face stays where it was
            larger.center - larger.axes[:, 0] * larger.size[0] / 2,
            first.center - first.axes[:, 0] * first.size[0] / 2,
            atol=1e-3,
        )
        drag(page, ".crop-turn", 40, 0)
        assert np.abs(box(page).axes - first.axes).max() > 0.05
        np.testing.assert_allclose(box(page).axes[:, 1], first.axes[:, 1], atol=1e-4)  # it stands upright
        drag(page, ".crop-middle", -20, 10)
        assert np.abs(box(page).center - larger.center).max() > 0.01
        page.keyboard.press("v")
        assert page.locator(".crop-panel").count() == page.locator(".crop-drawing").count() == 0


def test_a_box_is_drawn_with_a_finger(browser: Browser, site: Site) -> None:
    with viewing(browser, site, **PHONE) as page:
        page.get_by_role("button", name="Settings").tap()
        page.get_by_role("button", name="Crop").tap()
        page.locator(".crop-panel").wait_for()
        before, seen = box(page), page.evaluate("() => window.hgs.state.framesDrawn")
        devices = page.context.new_cdp_session(page)
        x, y = place(page, ".crop-face")
        for kind, dx in (("touchStart", 0), ("touchMove", 15), ("touchMove", 30), ("touchEnd", None)):
            points = [] if dx is None else [{"x": x + dx, "y": y}]
            devices.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        assert box(page).size[0] > before.size[0]
        assert page.evaluate("() => window.hgs.state.framesDrawn") == seen  # the camera stays
        panel = page.locator(".crop-panel").bounding_box()
        assert panel is not None
        assert panel["y"] > 0.55 * 844  # the upper part of the picture is free


def test_numbers_can_be_typed_and_everything_else_is_in_the_command(browser: Browser, site: Site) -> None:
    with viewing(browser, site, viewport=DESKTOP) as page:
        page.keyboard.press("i")  # repeat from here
        page.keyboard.press("v")
        page.get_by_label("Height").fill("1.25")
        page.get_by_label("Height").press("Enter")
        page.get_by_role("button", name="Keep outside").click()
        found = options(page)
        assert box(page).size[1] == 1.25
        assert found.inverse is True
        assert re.fullmatch(r"0\.4,\d(\.\d+)?", found.trim)
        page.get_by_label("Height").fill("-1")
        page.get_by_label("Height").press("Enter")
        assert page.get_by_label("Height").input_value() == "1.25"
        page.get_by_role("button", name="Reset").click()
        assert box(page).size[1] != 1.25


def test_apply_asks_for_one_job_that_keeps_the_box(browser: Browser, site: Site) -> None:
    with viewing(browser, site, viewport=DESKTOP) as page:
        page.keyboard.press("i")  # repeat from here
        page.keyboard.press("v")
        page.get_by_role("button", name="Keep outside").click()
        apply = page.get_by_role("button", name="Apply")
        page.route("**/edits", lambda route: route.abort())
        with page.expect_request("**/edits") as lost:
            apply.click()
        page.get_by_text("The server cannot be reached.").wait_for()
        page.unroute("**/edits")
        with page.expect_response("**/edits") as answer:
            apply.click()
        job, request = answer.value.json(), answer.value.request
        page.get_by_role("link", name="Job").wait_for()
        assert apply.is_disabled()
        assert request.headers["idempotency-key"] == lost.value.headers["idempotency-key"]
        page.request.post(f"{site.address}/v1/jobs/{job['id']}/cancel")
        page.get_by_text("Cancelled").wait_for()
        assert apply.is_enabled()
        sent = CropFile.of(Path("edit.json"), json.loads(request.post_data or ""))
        np.testing.assert_allclose(sent.box.center, box(page).center, rtol=1e-4)
        assert sent.inverse is True
        assert sent.trim is not None


def test_the_box_stays_in_the_world_when_the_camera_turns(browser: Browser, site: Site) -> None:
    with viewing(browser, site, viewport=DESKTOP) as page:
        page.keyboard.press("v")
        page.locator(".crop-panel").wait_for()
        command, edges = (page.locator(name) for name in (".crop-command", ".crop-edges"))
        before = command.text_content(), edges.get_attribute("d")
        page.keyboard.press("Shift+ArrowLeft")
        page.wait_for_function(
            "(d) => document.querySelector('.player-host').shadowRoot"
            ".querySelector('.crop-edges').getAttribute('d') !== d",
            arg=before[1],
        )
        assert command.text_content() == before[0]
