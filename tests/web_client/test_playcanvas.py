"""Splats in a PlayCanvas application in a real browser, against the reference rasterizer's pictures and the host's."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pytest

from benchmarks.viewers.browser import psnr
from tests.web_client.conftest import BACKGROUND, HEIGHT, REPOSITORY, WIDTH
from tests.web_client.test_three import (
    CANVAS_PSNR,
    FLOAT_PSNR,
    HALF_PSNR,
    MAGENTA,
    add_splats,
    address,
    camera_named,
    look,
    mostly,
    numbers,
    rasterized,
    require_depth,
    require_steady_heap,
    screenshot,
    settle,
)
from tests.web_client.test_three_webgpu import canvas

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

__all__ = ["address"]

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

IMPORTS = {
    "playcanvas": "/node_modules/playcanvas/build/playcanvas.mjs",
    "@hgs/player/playcanvas": "/dist/playcanvas.js",
}
HEAD = f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>A host</title><link rel="icon" href="data:,">
<style>body {{ margin: 0 }} canvas {{ display: block }}</style>
<script type="importmap">{json.dumps({"imports": IMPORTS})}</script>"""
PAGE = f'{HEAD}<script type="module">{Path(__file__).with_name("playcanvas_host.js").read_text()}</script>'


@contextmanager
def hosting(browser: Browser, address: str, **options: Any) -> Iterator[Page]:
    """A page with a `host` that has a canvas of the cameras' size."""
    page = browser.new_page(viewport={"width": 900, "height": 700})
    page.add_init_script(
        "window.warnings = []; console.warn = console.error = (...words) => warnings.push(words.join(' '))"
    )
    try:
        page.route(f"{address}/", lambda route: route.fulfill(body=PAGE, content_type="text/html"))
        page.goto(address)
        page.wait_for_function("() => window.PlayHost")
        made = {"width": WIDTH, "height": HEIGHT, "background": BACKGROUND} | options
        page.evaluate("(options) => { window.host = new PlayHost(options) }", made)
        yield page
    finally:
        page.close()


def turned(page: Page, bits: int, samples: int = 1) -> npt.NDArray[np.float64]:
    """A picture in linear light, turned as PlayCanvas turns it."""
    taken = page.evaluate("([format, samples]) => host.light(format, samples)", [f"PIXELFORMAT_RGBA{bits}F", samples])
    data = np.frombuffer(base64.b64decode(taken), np.float16 if bits == 16 else np.float32).astype(np.float32)
    return np.maximum(data.reshape(HEIGHT, WIDTH, 4)[::-1, :, :3].astype(np.float64), 0) ** (1 / 2.2)


@pytest.mark.parametrize(("name", "seconds"), [("side", 0.4), ("askew", 1.7)])
def test_splats_alone_are_the_reference_picture(
    browser: Browser, address: str, site: Site, name: str, seconds: float
) -> None:
    """On the canvas; in linear light in targets of floats, and of half floats with one sample a pixel and with four."""
    camera = camera_named(site, name)
    truth = rasterized(site, camera, seconds)
    with hosting(browser, address) as page:
        look(page, camera)
        add_splats(page, seconds)
        settle(page)
        assert psnr(canvas(page), truth) >= CANVAS_PSNR
        assert psnr(turned(page, 32), truth) >= FLOAT_PSNR
        for samples in (1, 4):
            assert psnr(turned(page, 16, samples), truth) >= HALF_PSNR
        assert page.evaluate("() => [warnings, host.error]") == [[], 0]


def test_a_scene_that_is_moved_turned_and_scaled_is_the_same_picture_to_a_camera_that_is_too(
    browser: Browser, address: str, site: Site
) -> None:
    camera = camera_named(site, "above")
    scale, turn = 2.5, 0.7
    place = np.eye(4)
    place[:3, :3] = scale * np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    place[:3, 3] = [3.0, -1.0, 7.0]
    rows = np.asarray(camera.world_to_camera, np.float64) @ np.linalg.inv(place)
    rows[:3] *= scale
    with hosting(browser, address) as page:
        look(page, camera, rows, scale)
        add_splats(page, place=place.tolist())
        settle(page)
        assert psnr(canvas(page), rasterized(site, camera, 0.4)) >= CANVAS_PSNR


def test_splats_behind_a_wall_are_hidden_and_those_before_it_are_drawn_over_it(
    browser: Browser, address: str, site: Site
) -> None:
    """The reference has only the splats with centres before the wall, on its colour."""
    camera = camera_named(site, "side")
    rows = np.asarray(camera.world_to_camera, np.float64)
    wall = 3.0
    truth = rasterized(
        site, camera, 0.4, background=MAGENTA, keep=lambda means: (means.numpy() @ rows[2, :3] + rows[2, 3]) < wall
    )
    with hosting(browser, address) as page:
        look(page, camera)
        page.evaluate("(depth) => host.addWall(depth)", wall)
        add_splats(page)
        settle(page)
        assert psnr(canvas(page), truth) >= CANVAS_PSNR


def test_a_mesh_before_the_splats_keeps_its_colour_and_one_behind_is_covered(
    browser: Browser, address: str, site: Site
) -> None:
    with hosting(browser, address) as page:
        require_depth(page, site, canvas)


def test_a_transparent_mesh_tints_the_splats_behind_it(browser: Browser, address: str, site: Site) -> None:
    """Its middle is nearer than theirs, so it is drawn after them."""
    camera = camera_named(site, "side")
    with hosting(browser, address) as page:
        look(page, camera)
        add_splats(page)
        settle(page)
        without = canvas(page).astype(float)
        page.evaluate("""() => {
          const veil = { emissive: new pc.Color(1, 0, 1), opacity: 0.5, blendType: pc.BLEND_NORMAL, depthWrite: false };
          host.place("plane", host.material(veil), 100, 0, 0, -1);
        }""")
        veiled = canvas(page)
    assert np.abs(veiled - (without + 255 * np.array(MAGENTA)) / 2).max() <= 2


def test_the_hosts_own_picture_is_unchanged_bit_by_bit(browser: Browser, address: str, site: Site) -> None:
    """While splats arrive and are drawn behind a wall: with textures of the host's before and after them."""
    camera = camera_named(site, "side")
    pictures = []
    for splats in (False, True):
        with hosting(browser, address) as page:
            look(page, camera)
            page.evaluate("() => { host.addThings(); host.addWall(8) }")
            if splats:
                behind = np.eye(4)
                behind[:3, 3] = 20 * np.asarray(camera.world_to_camera)[2, :3]
                add_splats(page, place=behind.tolist())
            taken = page.evaluate("() => host.frames(0, 8)")
            if splats:
                settle(page)
            taken += page.evaluate("() => host.frames(8, 4)")
            assert page.evaluate("() => [warnings, host.error]") == [[], 0]
            pictures.append(taken)
    assert len(set(pictures[0])) > 5  # every second frame is another picture
    assert [a == b for a, b in zip(*pictures, strict=True)] == [True] * 12


def test_each_of_two_cameras_has_its_own_order(browser: Browser, address: str, site: Site) -> None:
    cameras = [camera_named(site, name) for name in ("side", "askew")]
    with hosting(browser, address, width=2 * WIDTH) as page:
        page.evaluate("(cameras) => host.split(...cameras)", [numbers(camera) for camera in cameras])
        add_splats(page)
        settle(page)
        shown = canvas(page)
    for camera, half in zip(cameras, np.split(shown, 2, axis=1), strict=True):
        assert psnr(half, rasterized(site, camera, 0.4)) >= CANVAS_PSNR


def test_a_camera_frame_of_half_floats_shows_the_same_picture(browser: Browser, address: str, site: Site) -> None:
    camera = camera_named(site, "side")
    with hosting(browser, address) as page:
        look(page, camera)
        page.evaluate("() => host.addFrame('PIXELFORMAT_RGBA16F')")
        add_splats(page)
        settle(page)
        assert psnr(canvas(page), rasterized(site, camera, 0.4)) >= CANVAS_PSNR


def test_a_context_that_was_lost_comes_back_with_the_splats(browser: Browser, address: str, site: Site) -> None:
    with hosting(browser, address) as page:
        look(page, camera_named(site, "side"))
        add_splats(page)
        settle(page)
        before = canvas(page)
        page.evaluate("() => host.loseContext()")
        settle(page)
        assert np.array_equal(canvas(page), before)


def test_what_cannot_be_drawn_is_said_once_and_the_host_goes_on(browser: Browser, address: str, site: Site) -> None:
    with hosting(browser, address) as page:
        look(page, camera_named(site, "side"))
        without = canvas(page)
        add_splats(page)
        settle(page)
        shown = canvas(page)
        page.evaluate("() => { host.heard.length = 0; host.splats.setLocalScale(1, 2, 1) }")
        for _ in range(3):
            assert np.array_equal(canvas(page), without)
        said = page.evaluate("() => host.heard")
        assert [words.partition(":")[0] for words in said] == ["the scene is scaled by 1, 2, 1"]
        assert page.evaluate("() => warnings") == [f"HgsScene: {said[0]}"]
        page.evaluate("() => { host.splats.setLocalScale(1, 1, 1) }")
        flat = """() => {
          const { camera } = host.eye;
          camera.calculateProjection = (matrix) => matrix.setOrtho(-1, 1, -1, 1, 1, 9);
          host.draw();
          return host.heard.at(-1);
        }"""
        assert np.array_equal(canvas(page), shown)
        assert page.evaluate(flat) == "the camera eye has no perspective: splats need one that has"


def test_targets_of_several_textures_and_upside_down_ones_are_refused(
    browser: Browser, address: str, site: Site
) -> None:
    refused = """(options) => {
      const make = () => new pc.Texture(host.app.graphicsDevice, { width: 8, height: 8, format: pc.PIXELFORMAT_RGBA8 });
      const colorBuffers = Array.from({ length: options.count ?? 1 }, make);
      host.eye.camera.renderTarget = new pc.RenderTarget({ colorBuffers, depth: true, ...options });
      host.draw();
      host.eye.camera.renderTarget = null;
      return host.heard.at(-1);
    }"""
    with hosting(browser, address) as page:
        look(page, camera_named(site, "side"))
        add_splats(page)
        settle(page)
        two = "the render target has 2 textures: splats are drawn into one only"
        assert page.evaluate(refused, {"count": 2}) == two
        canvas(page)
        assert page.evaluate(refused, {"flipY": True}) == (
            "the render target is upside down: splats need one without flipY"
        )


def test_an_application_that_does_not_draw_by_webgl2_is_refused(browser: Browser, address: str) -> None:
    made = """() => {
      const app = new pc.AppBase(document.createElement("canvas"));
      const graphicsDevice = new pc.NullGraphicsDevice(document.createElement("canvas"));
      app.init(Object.assign(new pc.AppOptions(), { graphicsDevice, componentSystems: [pc.RenderComponentSystem] }));
      try { new HgsScene(app, { src: "/clouds/manifest.json" }) } catch (error) { return error.message }
    }"""
    with hosting(browser, address) as page:
        said = 'this application draws by null: splats need a device made of deviceTypes: ["webgl2"]'
        assert page.evaluate(made) == said


def test_a_scene_plays_tells_and_is_destroyed_with_its_parent(browser: Browser, address: str, site: Site) -> None:
    """The host's context stays alive, and its picture is the one without splats."""
    with hosting(browser, address) as page:
        look(page, camera_named(site, "side"))
        page.evaluate("() => host.addThings()")
        without = canvas(page)
        add_splats(page, 1.9, playbackRate=4)
        settle(page)
        assert page.evaluate("() => [host.splats.paused, host.splats.duration, host.splats.currentTime]") == [
            True,
            2,
            1.9,
        ]
        ended = """() => host.drawUntil(new Promise((resolve) => {
          host.splats.once("ended", () => resolve());
          host.splats.play();
        }))"""
        page.evaluate(ended)
        told = [name for name in page.evaluate("() => host.heard") if name != "seeked"]
        assert told == ["manifest", "firstpicture", "ready", "play", "pause", "ended"]
        destroyed = """() => {
          const parent = new pc.Entity();
          host.app.root.addChild(parent);
          host.splats.reparent(parent);
          const asked = host.splats.seek(0).catch((error) => error.name);
          parent.destroy();
          return asked;
        }"""
        assert page.evaluate(destroyed) == "AbortError"
        assert np.array_equal(canvas(page), without)
        assert page.evaluate("() => [warnings, host.error]") == [[], 0]


def test_an_application_is_destroyed_with_its_scene(browser: Browser, address: str, site: Site) -> None:
    with hosting(browser, address) as page:
        look(page, camera_named(site, "side"))
        add_splats(page)
        settle(page)
        page.evaluate("() => host.app.destroy()")
        assert page.evaluate("() => warnings") == []


MOUNTS = """async (count) => {
  for (let i = 0; i < count; i++) {
    host.addSplats({ src: "/clouds/manifest.json", time: 0.4 });
    await host.settled();
    host.splats.destroy();
    host.heard.length = 0;
    host.draw();
  }
  return host.held();
}"""


def test_scenes_that_come_and_go_leave_nothing_in_the_application(browser: Browser, address: str, site: Site) -> None:
    with hosting(browser, address) as page:
        look(page, camera_named(site, "side"))
        assert page.evaluate(MOUNTS, 3) == page.evaluate(MOUNTS, 1)
        assert page.evaluate("() => warnings") == []


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_two_hundred_scenes_that_come_and_go_leave_the_heap_as_it_was(
    browser: Browser, address: str, site: Site
) -> None:
    with hosting(browser, address) as page:
        look(page, camera_named(site, "side"))
        require_steady_heap(page, MOUNTS)


def test_the_example_shows_a_mesh_before_and_one_behind_the_splats(browser: Browser, address: str) -> None:
    page = browser.new_page(viewport={"width": 640, "height": 400})
    problems: list[str] = []
    page.on("console", lambda message: problems.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: problems.append(str(error)))
    try:
        page.goto(f"{address}/examples/playcanvas.html?src=/clouds/manifest.json")
        page.wait_for_function("() => window.splats && !document.querySelector('p')")
        page.evaluate("() => { splats.pause(); return splats.seek(0.4) }")
        shown, without = (screenshot(page, f"splats.enabled = {visible}") for visible in ("true", "false"))
        before, behind = (mostly(without, channel) for channel in (0, 2))
        assert before.sum() > 5000
        assert behind.sum() > 5000
        assert np.array_equal(shown[before], without[before])
        assert (shown[behind] != without[behind]).any(axis=1).mean() > 0.9
        assert [problem for problem in problems if "GPU stall" not in problem] == []
    finally:
        page.close()


def test_the_program_of_the_documents_plays_and_seeks(browser: Browser, address: str) -> None:
    text = (REPOSITORY / "docs" / "three.md").read_text(encoding="utf-8")
    program = text.split("## PlayCanvas")[1].split("```js\n")[1].split("```")[0]
    script = program.replace("studio/manifest.json", "/clouds/manifest.json")
    script += "\nwindow.told = [];\nwindow.splats = splats;\n"
    script += "for (const type of ['ready', 'seeked']) splats.on(type, () => told.push(type));"
    body = f'{HEAD}<canvas width="640" height="360"></canvas><script type="module">{script}</script>'
    page = browser.new_page(viewport={"width": 640, "height": 400})
    try:
        page.route("**/program.html", lambda route: route.fulfill(content_type="text/html", body=body))
        page.goto(f"{address}/program.html")
        page.wait_for_function("() => window.told?.includes('ready')")
        assert page.evaluate("() => splats.paused") is False
        page.evaluate("() => splats.seek(0.5)")
        assert "seeked" in page.evaluate("() => told")
    finally:
        page.close()
