"""Splats in a host of three.js' WebGPURenderer, by WebGPU and WebGL2, against the reference rasterizer's pictures."""

from __future__ import annotations

import base64
import dataclasses
import json
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from benchmarks.viewers.browser import psnr
from tests.web_client import asked_of_hosts as asked
from tests.web_client.conftest import HEIGHT, WIDTH
from tests.web_client.engine_hosts import (
    CANVAS_PSNR,
    HALF_PSNR,
    MAGENTA,
    Engine,
    Picture,
    add_splats,
    camera_named,
    canvas,
    look,
    rasterized,
    settle,
    srgb,
)

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

THREE = Engine(
    "NodeHost",
    "three_webgpu_host.js",
    {
        "three": "/node_modules/three/build/three.webgpu.js",
        "three/webgpu": "/node_modules/three/build/three.webgpu.js",
        "three/tsl": "/node_modules/three/build/three.tsl.js",
        "three/webgl": "/node_modules/three/build/three.module.js",
        "@hgs/player/three": "/dist/three.js",
        "@hgs/player/three-webgpu": "/dist/three-webgpu.js",
    },
    example="three_webgpu.html",
    hidden="splats.visible = {shown}",
)
WEBGPU, WEBGL = {"forceWebGL": False}, {"forceWebGL": True}
both = pytest.mark.parametrize("backend", [WEBGPU, WEBGL], ids=["webgpu", "webgl"])


@pytest.fixture(scope="module")
def page(browser: Browser, address: str) -> Iterator[Page]:
    with THREE.page(browser, address) as loaded:
        yield loaded


@contextmanager
def hosting(page: Page, backend: dict[str, Any], **options: Any) -> Iterator[None]:
    """A new `host` in the page, drawn by that back end."""
    with THREE.hosting(page, renderer=backend, **options):
        kind = page.evaluate("() => host.renderer.backend.isWebGPUBackend === true")
        if kind == backend["forceWebGL"]:
            pytest.skip("this browser offers no adapter of WebGPU")
        yield


def halves(page: Page, samples: int = 0) -> npt.NDArray[np.float32]:
    data = base64.b64decode(page.evaluate("(samples) => host.halves(samples)", samples))
    picture = np.frombuffer(data, np.float16).astype(np.float32).reshape(HEIGHT, WIDTH, 4)[:, :, :3]
    webgl = page.evaluate("() => !host.renderer.backend.isWebGPUBackend")
    return picture[::-1] if webgl else picture


@pytest.mark.parametrize(
    ("backend", "name", "seconds"),
    [(WEBGPU, "side", 0.4), (WEBGPU, "askew", 1.7), (WEBGL, "askew", 1.7)],
    ids=["webgpu, cubic", "webgpu, fifth order", "webgl, fifth order"],
)
def test_splats_alone_are_the_reference_picture(
    page: Page, site: Site, backend: dict[str, Any], name: str, seconds: float
) -> None:
    """On the canvas, and in targets of half floats with one sample a pixel and with four."""
    camera = camera_named(site, name)
    truth = rasterized(site, camera, seconds)
    with hosting(page, backend):
        look(page, camera)
        add_splats(page, seconds)
        settle(page)
        assert psnr(canvas(page), truth) >= CANVAS_PSNR
        for samples in (0, 4):
            assert psnr(srgb(halves(page, samples)), truth) >= HALF_PSNR
        assert page.evaluate("() => warnings") == []


@both
def test_a_page_shines_through_a_canvas_without_a_background(page: Page, site: Site, backend: dict[str, Any]) -> None:
    camera = camera_named(site, "side")
    with hosting(page, backend):
        look(page, camera)
        page.evaluate("() => { host.renderer.setClearColor(0, 0); document.body.style.background = '#ff00ff' }")
        add_splats(page)
        settle(page)
        page.evaluate("() => host.draw()")
        clip = {"x": 0, "y": 0, "width": WIDTH, "height": HEIGHT}
        shown = np.asarray(Image.open(BytesIO(page.screenshot(clip=clip))).convert("RGB"))
    assert psnr(shown, rasterized(site, camera, 0.4, background=MAGENTA)) >= CANVAS_PSNR


@both
def test_enlarged_antialiased_splats_are_the_reference_picture(page: Page, site: Site, backend: dict[str, Any]) -> None:
    """The view is three times as large as the pictures that are said to have made the scene."""
    camera = camera_named(site, "side")
    near = dataclasses.replace(camera, fx=3 * camera.fx, fy=3 * camera.fy)
    truth = rasterized(site, near, 0.4, antialiased=True, rig=site.cameras)
    manifest = json.loads((site.folder / "manifest.json").read_text()) | {"photographed": True}
    with hosting(page, backend):
        page.route("**/clouds/manifest.json", lambda route: route.fulfill(json=manifest), times=1)
        look(page, near)
        add_splats(page, antialiased=True)
        settle(page)
        assert psnr(canvas(page), truth) >= CANVAS_PSNR


@pytest.mark.parametrize(
    ("backend", "options"),
    [
        (WEBGPU, {"logarithmicDepthBuffer": True}),
        (WEBGPU, {"antialias": True}),
        (WEBGL, {"logarithmicDepthBuffer": True}),
        (WEBGL, {}),
    ],
    ids=["webgpu, logarithmic", "webgpu, samples", "webgl, logarithmic", "webgl"],
)
def test_splats_behind_a_wall_are_hidden_and_those_before_it_are_drawn_over_it(
    page: Page, site: Site, backend: dict[str, Any], options: dict[str, bool]
) -> None:
    with hosting(page, backend | options):
        for name in options.keys() & {"logarithmicDepthBuffer"}:
            assert page.evaluate("(name) => host.renderer[name]", name), f"this browser has no {name}"
        asked.require_wall(page, site)


def test_a_reversed_depth_buffer_hides_splats_behind_a_wall(browser: Browser, address: str, site: Site) -> None:
    """In a page of its own: three.js keeps a mark of such a buffer that reaches later renderers of the page."""
    with THREE.page(browser, address) as page, hosting(page, WEBGPU | {"reversedDepthBuffer": True}):
        assert page.evaluate("() => host.renderer.reversedDepthBuffer"), "this browser has no reversed depth"
        asked.require_wall(page, site)


def test_after_a_renderer_with_a_reversed_depth_buffer_others_draw_as_ever(
    browser: Browser, address: str, site: Site
) -> None:
    with THREE.page(browser, address) as page:
        with hosting(page, WEBGPU | {"reversedDepthBuffer": True}):
            look(page, camera_named(site, "side"))
            canvas(page)
        with hosting(page, WEBGPU):
            asked.require_wall(page, site)


def test_a_mesh_before_the_splats_keeps_its_colour_and_one_behind_is_covered(page: Page, site: Site) -> None:
    with hosting(page, WEBGPU):
        asked.require_depth(page, site)


@both
def test_the_hosts_own_picture_is_unchanged_bit_by_bit(page: Page, site: Site, backend: dict[str, Any]) -> None:
    """With splats that are behind a wall: light that was turned into sRGB and back would be rounded."""
    camera = camera_named(site, "side")
    behind = np.eye(4)
    behind[:3, 3] = 20 * np.asarray(camera.world_to_camera)[2, :3]
    with hosting(page, backend):
        look(page, camera)
        page.evaluate("() => { host.addThings(); host.addWall(8, { colour: [0.21, 0.43, 0.65] }) }")
        before = halves(page)
        add_splats(page, place=behind.tolist())
        settle(page)
        assert np.array_equal(halves(page), before)


def test_each_of_two_viewports_has_its_own_order(page: Page, site: Site) -> None:
    with hosting(page, WEBGPU, width=2 * WIDTH):
        asked.require_two_views(page, site)


def test_each_object_refuses_the_other_kind_of_renderer_in_one_sentence(page: Page, site: Site) -> None:
    """And the host goes on, with its own picture."""
    with hosting(page, WEBGPU):
        look(page, camera_named(site, "side"))
        page.evaluate("() => host.addWall(3)")
        without = canvas(page)
        page.evaluate("() => { host.Scene = OfWebGL }")
        add_splats(page)
        shown = canvas(page)
        said = "this renderer is no WebGLRenderer: import HgsScene from @hgs/player/three-webgpu instead"
        assert said in page.evaluate("() => host.heard")
        assert np.array_equal(shown, without)
    with hosting(page, WEBGL):
        look(page, camera_named(site, "side"))
        page.evaluate("() => { host.renderer = new WebGLRenderer() }")
        add_splats(page)
        page.evaluate("() => { host.draw(); host.draw() }")
        said = "this renderer is no WebGPURenderer: import HgsScene from @hgs/player/three instead"
        assert page.evaluate("() => host.heard").count(said) == 1


def test_targets_with_several_textures_are_refused_in_one_sentence(page: Page, site: Site) -> None:
    with hosting(page, WEBGPU):
        look(page, camera_named(site, "side"))
        add_splats(page)
        settle(page)
        said = "the render target has 2 textures: splats are drawn into one only"
        assert page.evaluate("() => { host.drawToTwo(); return host.heard.at(-1) }") == said
        canvas(page)
        assert page.evaluate("() => warnings") == [f"HgsScene: {said}"]


def test_the_example_draws_splats_in_a_pass_of_post_processing(browser: Browser, address: str) -> None:
    def check(shown: Picture, without: Picture) -> None:
        assert (shown != without).any(axis=2).mean() > 0.3

    THREE.require_example(browser, address, check)


MEMORY = "(({ geometries, textures, programs }) => [geometries, textures, programs])(host.renderer.info.memory)"
MOUNTS = asked.mounts("dispose", f"[...{MEMORY}, host.world.children.length]")


@both
def test_scenes_that_come_and_go_leave_nothing_in_the_renderer(page: Page, site: Site, backend: dict[str, Any]) -> None:
    with hosting(page, backend):
        asked.require_nothing_left(page, site, MOUNTS)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@both
def test_two_hundred_scenes_that_come_and_go_leave_the_heap_as_it_was(
    page: Page, site: Site, backend: dict[str, Any]
) -> None:
    with hosting(page, backend):
        asked.require_steady_heap(page, site, MOUNTS)
