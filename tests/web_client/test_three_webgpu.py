"""Splats in a host of three.js' WebGPURenderer, by WebGPU and WebGL2, against the reference rasterizer's pictures."""

from __future__ import annotations

import base64
import dataclasses
import json
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from benchmarks.viewers.browser import psnr
from tests.web_client.conftest import BACKGROUND, HEIGHT, WIDTH
from tests.web_client.test_three import (
    CANVAS_PSNR,
    HALF_PSNR,
    MAGENTA,
    add_splats,
    address,
    camera_named,
    look,
    numbers,
    rasterized,
    require_depth,
    require_steady_heap,
    screenshot,
    settle,
    srgb,
)

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

__all__ = ["address"]

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

IMPORTS = {
    "three": "/node_modules/three/build/three.webgpu.js",
    "three/webgpu": "/node_modules/three/build/three.webgpu.js",
    "three/tsl": "/node_modules/three/build/three.tsl.js",
    "three/webgl": "/node_modules/three/build/three.module.js",
    "@hgs/player/three": "/dist/three.js",
    "@hgs/player/three-webgpu": "/dist/three-webgpu.js",
}
PAGE = f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>A host</title><link rel="icon" href="data:,">
<style>body {{ margin: 0 }} canvas {{ display: block }}</style>
<script type="importmap">{json.dumps({"imports": IMPORTS})}</script>
<script type="module">{Path(__file__).with_name("three_webgpu_host.js").read_text()}</script>"""
WEBGPU, WEBGL = {"forceWebGL": False}, {"forceWebGL": True}
both = pytest.mark.parametrize("backend", [WEBGPU, WEBGL], ids=["webgpu", "webgl"])


@contextmanager
def hosting(browser: Browser, address: str, backend: dict[str, Any], **options: Any) -> Iterator[Page]:
    """A page with a `host` that has a canvas of the cameras' size, drawn by that back end."""
    page = browser.new_page(viewport={"width": 900, "height": 700})
    page.add_init_script(
        "window.warnings = []; console.warn = console.error = (...words) => warnings.push(words.join(' '))"
    )
    try:
        page.route(f"{address}/", lambda route: route.fulfill(body=PAGE, content_type="text/html"))
        page.goto(address)
        page.wait_for_function("() => window.NodeHost")
        made = {"width": WIDTH, "height": HEIGHT, "background": BACKGROUND, "renderer": backend} | options
        page.evaluate("(options) => { window.host = new NodeHost(options); return host.renderer.init() }", made)
        kind = page.evaluate("() => host.renderer.backend.isWebGPUBackend === true")
        if kind == backend["forceWebGL"]:
            pytest.skip("this browser offers no adapter of WebGPU")
        yield page
    finally:
        page.close()


def canvas(page: Page) -> npt.NDArray[np.uint8]:
    data = base64.b64decode(page.evaluate("() => host.pixels()"))
    return np.frombuffer(data, np.uint8).reshape(HEIGHT, -1, 4)[:, :, :3]


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
    browser: Browser, address: str, site: Site, backend: dict[str, Any], name: str, seconds: float
) -> None:
    """On the canvas, and in targets of half floats with one sample a pixel and with four."""
    camera = camera_named(site, name)
    truth = rasterized(site, camera, seconds)
    with hosting(browser, address, backend) as page:
        look(page, camera)
        add_splats(page, seconds)
        settle(page)
        assert psnr(canvas(page), truth) >= CANVAS_PSNR
        for samples in (0, 4):
            assert psnr(srgb(halves(page, samples)), truth) >= HALF_PSNR
        assert page.evaluate("() => warnings") == []


@both
def test_a_page_shines_through_a_canvas_without_a_background(
    browser: Browser, address: str, site: Site, backend: dict[str, Any]
) -> None:
    camera = camera_named(site, "side")
    with hosting(browser, address, backend) as page:
        look(page, camera)
        page.evaluate("() => { host.renderer.setClearColor(0, 0); document.body.style.background = '#ff00ff' }")
        add_splats(page)
        settle(page)
        page.evaluate("() => host.draw()")
        clip = {"x": 0, "y": 0, "width": WIDTH, "height": HEIGHT}
        shown = np.asarray(Image.open(BytesIO(page.screenshot(clip=clip))).convert("RGB"))
    assert psnr(shown, rasterized(site, camera, 0.4, background=MAGENTA)) >= CANVAS_PSNR


@both
def test_enlarged_antialiased_splats_are_the_reference_picture(
    browser: Browser, address: str, site: Site, backend: dict[str, Any]
) -> None:
    """The view is three times as large as the pictures that are said to have made the scene."""
    camera = camera_named(site, "side")
    near = dataclasses.replace(camera, fx=3 * camera.fx, fy=3 * camera.fy)
    truth = rasterized(site, near, 0.4, antialiased=True, rig=site.cameras)
    manifest = json.loads((site.folder / "manifest.json").read_text()) | {"photographed": True}
    with hosting(browser, address, backend) as page:
        page.route("**/clouds/manifest.json", lambda route: route.fulfill(json=manifest))
        look(page, near)
        add_splats(page, antialiased=True)
        settle(page)
        assert psnr(canvas(page), truth) >= CANVAS_PSNR


@pytest.mark.parametrize(
    ("backend", "depth"),
    [
        (WEBGPU, {"logarithmicDepthBuffer": True}),
        (WEBGPU, {"reversedDepthBuffer": True}),
        (WEBGPU, {"antialias": True}),
        (WEBGL, {"logarithmicDepthBuffer": True}),
        (WEBGL, {}),
    ],
    ids=["webgpu, logarithmic", "webgpu, reversed", "webgpu, samples", "webgl, logarithmic", "webgl"],
)
def test_splats_behind_a_wall_are_hidden_and_those_before_it_are_drawn_over_it(
    browser: Browser, address: str, site: Site, backend: dict[str, Any], depth: dict[str, bool]
) -> None:
    """The reference has only the splats with centres before the wall, on its colour."""
    camera = camera_named(site, "side")
    rows = np.asarray(camera.world_to_camera, np.float64)
    wall = 3.0
    truth = rasterized(
        site, camera, 0.4, background=MAGENTA, keep=lambda means: (means.numpy() @ rows[2, :3] + rows[2, 3]) < wall
    )
    with hosting(browser, address, backend | depth) as page:
        for name in depth.keys() & {"logarithmicDepthBuffer", "reversedDepthBuffer"}:
            assert page.evaluate("(name) => host.renderer[name]", name), f"this browser has no {name}"
        look(page, camera)
        page.evaluate("(depth) => host.addWall(depth)", wall)
        add_splats(page)
        settle(page)
        assert psnr(canvas(page), truth) >= CANVAS_PSNR


def test_a_mesh_before_the_splats_keeps_its_colour_and_one_behind_is_covered(
    browser: Browser, address: str, site: Site
) -> None:
    with hosting(browser, address, WEBGPU) as page:
        require_depth(page, site, canvas)


@both
def test_the_hosts_own_picture_is_unchanged_bit_by_bit(
    browser: Browser, address: str, site: Site, backend: dict[str, Any]
) -> None:
    """With splats that are behind a wall: light that was turned into sRGB and back would be rounded."""
    camera = camera_named(site, "side")
    behind = np.eye(4)
    behind[:3, 3] = 20 * np.asarray(camera.world_to_camera)[2, :3]
    with hosting(browser, address, backend) as page:
        look(page, camera)
        page.evaluate("() => { host.addThings(); host.addWall(8, { colour: [0.21, 0.43, 0.65] }) }")
        before = halves(page)
        add_splats(page, place=behind.tolist())
        settle(page)
        assert np.array_equal(halves(page), before)


def test_each_of_two_viewports_has_its_own_order(browser: Browser, address: str, site: Site) -> None:
    cameras = [camera_named(site, name) for name in ("side", "askew")]
    with hosting(browser, address, WEBGPU, width=2 * WIDTH) as page:
        page.evaluate("([a, b]) => host.split(a, b)", [numbers(camera) for camera in cameras])
        add_splats(page)
        settle(page)
        shown = canvas(page)
    for camera, half in zip(cameras, np.split(shown, 2, axis=1), strict=True):
        assert psnr(half, rasterized(site, camera, 0.4)) >= CANVAS_PSNR


def test_each_object_refuses_the_other_kind_of_renderer_in_one_sentence(
    browser: Browser, address: str, site: Site
) -> None:
    """And the host goes on, with its own picture."""
    with hosting(browser, address, WEBGPU) as page:
        look(page, camera_named(site, "side"))
        page.evaluate("() => host.addWall(3)")
        without = canvas(page)
        page.evaluate("() => { host.Scene = OfWebGL }")
        add_splats(page)
        shown = canvas(page)
        said = "this renderer is no WebGLRenderer: import HgsScene from @hgs/player/three-webgpu instead"
        assert said in page.evaluate("() => host.heard")
        assert np.array_equal(shown, without)
    with hosting(browser, address, WEBGL) as page:
        look(page, camera_named(site, "side"))
        page.evaluate("() => { host.renderer = new WebGLRenderer() }")
        add_splats(page)
        page.evaluate("() => { host.draw(); host.draw() }")
        said = "this renderer is no WebGPURenderer: import HgsScene from @hgs/player/three instead"
        assert page.evaluate("() => host.heard").count(said) == 1


def test_targets_with_several_textures_are_refused_in_one_sentence(browser: Browser, address: str, site: Site) -> None:
    with hosting(browser, address, WEBGPU) as page:
        look(page, camera_named(site, "side"))
        add_splats(page)
        settle(page)
        said = "the render target has 2 textures: splats are drawn into one only"
        assert page.evaluate("() => { host.drawToTwo(); return host.heard.at(-1) }") == said
        canvas(page)
        assert page.evaluate("() => warnings") == [f"HgsScene: {said}"]


def test_the_example_draws_splats_in_a_pass_of_post_processing(browser: Browser, address: str) -> None:
    page = browser.new_page(viewport={"width": 480, "height": 300})
    problems: list[str] = []
    page.on("console", lambda message: problems.append(message.text) if message.type in ("error", "warning") else None)
    try:
        page.goto(f"{address}/examples/three_webgpu.html?src=/clouds/manifest.json")
        page.wait_for_function("() => window.splats")
        page.evaluate("() => { splats.pause(); return splats.seek(0.4) }")
        shown, without = (screenshot(page, f"splats.visible = {visible}") for visible in ("true", "false"))
        assert (shown != without).any(axis=2).mean() > 0.3
        assert [problem for problem in problems if "GPU stall" not in problem] == []
    finally:
        page.close()


MOUNTS = """async (count) => {
  for (let i = 0; i < count; i++) {
    host.addSplats({ src: "/clouds/manifest.json", time: 0.4 });
    await host.settled();
    host.splats.dispose();
    host.heard.length = 0;
    host.draw();
  }
  const { geometries, textures, programs } = host.renderer.info.memory;
  return [geometries, textures, programs, host.world.children.length];
}"""


@both
def test_scenes_that_come_and_go_leave_nothing_in_the_renderer(
    browser: Browser, address: str, site: Site, backend: dict[str, Any]
) -> None:
    with hosting(browser, address, backend) as page:
        look(page, camera_named(site, "side"))
        assert page.evaluate(MOUNTS, 3) == page.evaluate(MOUNTS, 1)
        assert page.evaluate("() => warnings") == []


@pytest.mark.slow
@pytest.mark.timeout(1800)
@both
def test_two_hundred_scenes_that_come_and_go_leave_the_heap_as_it_was(
    browser: Browser, address: str, site: Site, backend: dict[str, Any]
) -> None:
    with hosting(browser, address, backend) as page:
        look(page, camera_named(site, "side"))
        require_steady_heap(page, MOUNTS)
