"""Splats in a PlayCanvas application in a real browser, against the reference rasterizer's pictures and the host's."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import pytest

from benchmarks.viewers.browser import psnr
from tests.web_client import asked_of_hosts as asked
from tests.web_client.conftest import HEIGHT, WIDTH
from tests.web_client.engine_hosts import (
    CANVAS_PSNR,
    FLOAT_PSNR,
    HALF_PSNR,
    MAGENTA,
    Engine,
    add_splats,
    camera_named,
    canvas,
    look,
    rasterized,
    settle,
)

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

PLAYCANVAS = Engine(
    "PlayHost",
    "playcanvas_host.js",
    {"playcanvas": "/node_modules/playcanvas/build/playcanvas.mjs", "@hgs/player/playcanvas": "/dist/playcanvas.js"},
    example="playcanvas.html",
    hidden="splats.enabled = {shown}",
)


@pytest.fixture(scope="module")
def page(browser: Browser, address: str) -> Iterator[Page]:
    with PLAYCANVAS.page(browser, address) as loaded:
        yield loaded


def turned(page: Page, bits: int, samples: int = 1) -> npt.NDArray[np.float64]:
    """A picture in linear light, turned as PlayCanvas turns it."""
    taken = page.evaluate("([format, samples]) => host.light(format, samples)", [f"PIXELFORMAT_RGBA{bits}F", samples])
    data = np.frombuffer(base64.b64decode(taken), np.float16 if bits == 16 else np.float32).astype(np.float32)
    return np.maximum(data.reshape(HEIGHT, WIDTH, 4)[::-1, :, :3].astype(np.float64), 0) ** (1 / 2.2)


@pytest.mark.parametrize(("name", "seconds"), [("side", 0.4), ("askew", 1.7)])
def test_splats_alone_are_the_reference_picture(page: Page, site: Site, name: str, seconds: float) -> None:
    """On the canvas; in linear light in targets of floats, and of half floats with one sample a pixel and with four."""
    camera = camera_named(site, name)
    truth = rasterized(site, camera, seconds)
    with PLAYCANVAS.hosting(page):
        look(page, camera)
        add_splats(page, seconds)
        settle(page)
        assert psnr(canvas(page), truth) >= CANVAS_PSNR
        assert psnr(turned(page, 32), truth) >= FLOAT_PSNR
        for samples in (1, 4):
            assert psnr(turned(page, 16, samples), truth) >= HALF_PSNR
        assert page.evaluate("() => [warnings, host.error]") == [[], 0]


def test_a_scene_that_is_moved_turned_and_scaled_is_the_same_picture_to_a_camera_that_is_too(
    page: Page, site: Site
) -> None:
    with PLAYCANVAS.hosting(page):
        asked.require_same_picture_moved(page, site)


def test_splats_behind_a_wall_are_hidden_and_those_before_it_are_drawn_over_it(page: Page, site: Site) -> None:
    with PLAYCANVAS.hosting(page):
        asked.require_wall(page, site)


def test_a_mesh_before_the_splats_keeps_its_colour_and_one_behind_is_covered(page: Page, site: Site) -> None:
    with PLAYCANVAS.hosting(page):
        asked.require_depth(page, site)


def test_a_transparent_mesh_tints_the_splats_behind_it(page: Page, site: Site) -> None:
    """Its middle is nearer than theirs, so it is drawn after them."""
    camera = camera_named(site, "side")
    with PLAYCANVAS.hosting(page):
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


def test_the_hosts_own_picture_is_unchanged_bit_by_bit(page: Page, site: Site) -> None:
    asked.require_same_frames(PLAYCANVAS, page, site, "host.error")


def test_each_of_two_cameras_has_its_own_order(page: Page, site: Site) -> None:
    with PLAYCANVAS.hosting(page, width=2 * WIDTH):
        asked.require_two_views(page, site)


def test_a_camera_frame_of_half_floats_shows_the_same_picture(page: Page, site: Site) -> None:
    camera = camera_named(site, "side")
    with PLAYCANVAS.hosting(page):
        look(page, camera)
        page.evaluate("() => host.addFrame('PIXELFORMAT_RGBA16F')")
        add_splats(page)
        settle(page)
        assert psnr(canvas(page), rasterized(site, camera, 0.4)) >= CANVAS_PSNR


def test_a_context_that_was_lost_comes_back_with_the_splats(page: Page, site: Site) -> None:
    with PLAYCANVAS.hosting(page):
        asked.require_restored_context(page, site)


def test_what_cannot_be_drawn_is_said_once_and_the_host_goes_on(page: Page, site: Site) -> None:
    with PLAYCANVAS.hosting(page):
        asked.require_one_complaint(page, site, "setLocalScale")
        flat = """() => {
          const { camera } = host.eye;
          camera.calculateProjection = (matrix) => matrix.setOrtho(-1, 1, -1, 1, 1, 9);
          host.draw();
          return host.heard.at(-1);
        }"""
        assert page.evaluate(flat) == "the camera eye has no perspective: splats need one that has"


def test_targets_of_several_textures_and_upside_down_ones_are_refused(page: Page, site: Site) -> None:
    refused = """(options) => {
      const make = () => new pc.Texture(host.app.graphicsDevice, { width: 8, height: 8, format: pc.PIXELFORMAT_RGBA8 });
      const colorBuffers = Array.from({ length: options.count ?? 1 }, make);
      host.eye.camera.renderTarget = new pc.RenderTarget({ colorBuffers, depth: true, ...options });
      host.draw();
      host.eye.camera.renderTarget = null;
      return host.heard.at(-1);
    }"""
    with PLAYCANVAS.hosting(page):
        look(page, camera_named(site, "side"))
        add_splats(page)
        settle(page)
        two = "the render target has 2 textures: splats are drawn into one only"
        assert page.evaluate(refused, {"count": 2}) == two
        canvas(page)
        assert page.evaluate(refused, {"flipY": True}) == (
            "the render target is upside down: splats need one without flipY"
        )


def test_an_application_that_does_not_draw_by_webgl2_is_refused(page: Page) -> None:
    made = """() => {
      const app = new pc.AppBase(document.createElement("canvas"));
      const graphicsDevice = new pc.NullGraphicsDevice(document.createElement("canvas"));
      app.init(Object.assign(new pc.AppOptions(), { graphicsDevice, componentSystems: [pc.RenderComponentSystem] }));
      try { new HgsScene(app, { src: "/clouds/manifest.json" }) } catch (error) { return error.message }
    }"""
    with PLAYCANVAS.hosting(page):
        said = 'this application draws by null: splats need a device made of deviceTypes: ["webgl2"]'
        assert page.evaluate(made) == said


def test_a_scene_plays_tells_and_is_destroyed_with_its_parent(page: Page, site: Site) -> None:
    """The host's context stays alive."""
    end = """() => {
      const parent = new pc.Entity();
      host.app.root.addChild(parent);
      host.splats.reparent(parent);
      const asked = host.splats.seek(0).catch((error) => error.name);
      parent.destroy();
      return asked;
    }"""
    with PLAYCANVAS.hosting(page):
        asked.require_whole_life(page, site, "once", end)
        assert page.evaluate("() => [warnings, host.error]") == [[], 0]


def test_an_application_is_destroyed_with_its_scene(page: Page, site: Site) -> None:
    with PLAYCANVAS.hosting(page):
        look(page, camera_named(site, "side"))
        add_splats(page)
        settle(page)
        page.evaluate("() => host.app.destroy()")
        assert page.evaluate("() => warnings") == []


MOUNTS = asked.mounts("destroy", "host.held()")


def test_scenes_that_come_and_go_leave_nothing_in_the_application(page: Page, site: Site) -> None:
    with PLAYCANVAS.hosting(page):
        asked.require_nothing_left(page, site, MOUNTS)


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_two_hundred_scenes_that_come_and_go_leave_the_heap_as_it_was(page: Page, site: Site) -> None:
    with PLAYCANVAS.hosting(page):
        asked.require_steady_heap(page, site, MOUNTS)


def test_the_example_shows_a_mesh_before_and_one_behind_the_splats(browser: Browser, address: str) -> None:
    PLAYCANVAS.require_example(browser, address, asked.require_meshes_around)


def test_the_program_of_the_documents_plays_and_seeks(browser: Browser, address: str) -> None:
    PLAYCANVAS.require_program(browser, address, 3, "on")
