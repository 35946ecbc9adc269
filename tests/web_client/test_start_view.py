"""The first view of a page: all that moves is inside the canvas, on a desktop and on a phone held upright."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pytest

from benchmarks.viewers.browser import canvas_pixels
from hgs_core.codec import encode_scene
from hgs_core.fit.find_start_views import find_start_views
from tests.hgs_core.fit.test_find_start_views import FRONT, SIDE, scene
from tests.web_client.conftest import serving

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

ROW = [(x, 0.0, 0.0) for x in (-1.5, 0.0, 1.5)]


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The page of three red balls in a row, seen from the front and from its end."""
    folder = tmp_path_factory.mktemp("start") / "row"
    moving = scene(*ROW)
    encode_scene(
        moving,
        folder / "scene",
        cameras=[SIDE, FRONT],
        times=np.linspace(0, 1, 31),
        title="Row",
        trained=[SIDE, FRONT],
        start_views=find_start_views(moving, [SIDE, FRONT]),
    )
    with serving([folder], tmp_path_factory.mktemp("home")) as [page]:
        yield page


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (390, 844)])
@pytest.mark.parametrize("time", [0, 1])
def test_all_that_moves_is_inside_the_canvas(
    browser: Browser, address: str, width: int, height: int, time: int
) -> None:
    context = browser.new_context(viewport={"width": width, "height": height})
    page = context.new_page()
    page.goto(f"{address}?paused=1&t={time}")
    page.wait_for_function("() => window.hgs?.ready.then(() => true)")
    picture = canvas_pixels(page)
    context.close()
    red = picture[..., 0] > 64
    rows, columns = red.shape
    assert red.any()
    y, x = np.nonzero(red)
    assert 0 < x.min() <= x.max() < columns - 1
    assert 0 < y.min() <= y.max() < rows - 1
    if width > height:  # front view: three balls side by side
        filled = red.any(axis=0).astype(int)
        assert int((np.diff(filled) == 1).sum()) == 3
