"""A page that draws fewer splats than there are: their number, their choice, and the loss of its picture."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, TypeVar

import numpy as np
import pytest

from benchmarks.viewers.browser import canvas_floats, canvas_pixels, psnr
from tests.web_client.test_browser import reference_picture, view

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from hgs_core.scene import DynamicSplats, StaticSplats
    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

Splats = TypeVar("Splats", "StaticSplats[np.ndarray]", "DynamicSplats[np.ndarray]")

VIEWS = [("side", 0.4), ("above", 1.0), ("askew", 1.7)]


def thinned(site: Site, share: float, dynamic_share: float) -> Site:
    """The site with so many of its splats, taken at random."""
    r = np.random.default_rng(7)

    def some(splats: Splats, share: float) -> Splats:
        count = len(splats.opacity_logits)
        keep = r.permutation(count) < share * count
        return splats.map(lambda array: array[keep])

    scene = site.scene
    segments = tuple(dataclasses.replace(one, dynamic=some(one.dynamic, dynamic_share)) for one in scene.segments)
    return dataclasses.replace(
        site, scene=dataclasses.replace(scene, static=some(scene.static, share), segments=segments)
    )


@pytest.mark.parametrize(("camera", "seconds"), VIEWS)
def test_half_the_splats_lose_far_less_than_any_half_would_also_where_it_moves(
    browser: Browser, site: Site, camera: str, seconds: float
) -> None:
    truth, any_half, still = (
        reference_picture(thinned(site, *shares), camera, seconds, antialiased=False)
        for shares in ((1, 1), (0.5, 0.5), (1, 0))
    )
    moves = np.abs(truth - still).max(axis=-1) > 0.1
    with view(browser, site, camera, seconds) as page:
        drawn = page.evaluate("() => hgs.state.splats")
    with view(browser, site, camera, seconds, f"&splats={drawn / 2}") as page:
        kept = page.evaluate("() => hgs.state.splats")
        picture = canvas_floats(page)
    for name, where in (("whole picture", np.full(moves.shape, True)), ("where it moves", moves)):
        got, worse = psnr(picture[where], truth[where]), psnr(any_half[where], truth[where])
        print(f"{camera} at {seconds} s, {kept} of {drawn} splats, {name}: {got:.1f} dB, any half {worse:.1f} dB")
        assert got >= worse + 3
    assert 0.45 * drawn < kept <= drawn / 2


def test_a_budget_for_all_of_them_changes_no_bit(browser: Browser, site: Site) -> None:
    with view(browser, site, "above", 1.0) as page:
        floats, pixels, drawn = canvas_floats(page), canvas_pixels(page), page.evaluate("() => hgs.state.splats")
    with view(browser, site, "above", 1.0, f"&splats={drawn}") as page:
        assert np.array_equal(canvas_floats(page), floats)
        assert np.array_equal(canvas_pixels(page), pixels)
