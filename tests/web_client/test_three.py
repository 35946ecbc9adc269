"""Splats in a host of three.js in a real browser, against the reference rasterizer's pictures and the host's own."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import pytest

from benchmarks.viewers.browser import psnr
from hgs_core.codec import load_manifest
from tests.web_client import asked_of_hosts as asked
from tests.web_client.clicking_scene import FARTHEST, TAP, ahead, publish_clicks
from tests.web_client.conftest import BACKGROUND, HEIGHT, WIDTH
from tests.web_client.engine_hosts import (
    CANVAS_PSNR,
    FLOAT_PSNR,
    HALF_PSNR,
    Engine,
    add_splats,
    camera_named,
    canvas,
    look,
    rasterized,
    serve_folder,
    settle,
    srgb,
)
from tests.web_client.sparse_scene import AROUND, camera_at, encode_room, green, red

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

THREE = Engine(
    "Host",
    "three_host.js",
    {
        "three": "/node_modules/three/build/three.module.js",
        "three/addons/": "/node_modules/three/examples/jsm/",
        "@hgs/player/three": "/dist/three.js",
    },
    example="three.html",
    hidden="splats.visible = {shown}; renderer.render(world, camera)",
)


@pytest.fixture(scope="module")
def page(browser: Browser, address: str) -> Iterator[Page]:
    with THREE.page(browser, address) as loaded:
        yield loaded


def floats(page: Page, offset: int = 0, samples: int = 0) -> npt.NDArray[np.float32]:
    taken = page.evaluate("([offset, samples]) => host.floats(offset, samples)", [offset, samples])
    data = np.frombuffer(base64.b64decode(taken), np.float16 if samples else np.float32).astype(np.float32)
    return data.reshape(HEIGHT, WIDTH, 4)[::-1, :, :3]


def require_no_error(page: Page) -> None:
    assert page.evaluate("() => host.renderer.getContext().getError()") == 0


@pytest.mark.parametrize(("name", "seconds"), [("side", 0.4), ("askew", 1.7)])
def test_splats_alone_are_the_reference_picture(page: Page, site: Site, name: str, seconds: float) -> None:
    """On the canvas; and in a target of floats at any corner of it, in sRGB where that is asked for."""
    camera = camera_named(site, name)
    truth = rasterized(site, camera, seconds)
    with THREE.hosting(page):
        look(page, camera)
        add_splats(page, seconds, linear=False)
        settle(page)
        assert psnr(canvas(page), truth) >= CANVAS_PSNR
        page.evaluate("() => host.renderer.setClearColor(new THREE.Color(0.1, 0.2, 0.3), 1)")
        assert psnr(floats(page), truth) >= FLOAT_PSNR
        assert psnr(floats(page, offset=40), truth) >= FLOAT_PSNR


def test_the_room_of_a_sparse_rig_fades_as_in_the_player(browser: Browser, address: str, tmp_path: Path) -> None:
    encode_room(tmp_path, AROUND)
    served = THREE.page(browser, address, lambda page: serve_folder(page, "room", tmp_path))
    with served as page, THREE.hosting(page, background=(0, 0, 0)):
        look(page, camera_at(0))
        add_splats(page, src="/room/manifest.json")
        settle(page)
        assert page.evaluate("() => host.splats.subjectOnly")
        assert green(canvas(page)) == 0
        page.evaluate("() => { host.splats.subjectOnly = false }")
        assert green(canvas(page)) > 0.5
        look(page, camera_at(60))
        settle(page)
        assert green(canvas(page)) == 0
        assert red(canvas(page)) > 0.03
        look(page, camera_at(120))
        settle(page)
        assert green(canvas(page)) > 0.5


def test_a_scene_that_is_moved_turned_and_scaled_is_the_same_picture_to_a_camera_that_is_too(
    page: Page, site: Site
) -> None:
    with THREE.hosting(page):
        asked.require_same_picture_moved(page, site)


@pytest.mark.parametrize(
    "depth",
    [{}, {"logarithmicDepthBuffer": True}, {"reversedDepthBuffer": True}],
    ids=["plain", "logarithmic", "reversed"],
)
def test_splats_behind_a_wall_are_hidden_and_those_before_it_are_drawn_over_it(
    page: Page, site: Site, depth: dict[str, bool]
) -> None:
    with THREE.hosting(page, renderer=depth):
        for name in depth:
            assert page.evaluate("(name) => host.renderer.capabilities[name]", name), f"this browser has no {name}"
        asked.require_wall(page, site, floats, FLOAT_PSNR, linear=False)


def test_a_mesh_before_the_splats_keeps_its_colour_and_one_behind_is_covered(page: Page, site: Site) -> None:
    with THREE.hosting(page):
        asked.require_depth(page, site)


def test_the_hosts_own_picture_is_unchanged_bit_by_bit(page: Page, site: Site) -> None:
    asked.require_same_frames(THREE, page, site, "host.renderer.getContext().getError()")


def test_what_a_host_has_bound_neither_harms_the_splats_nor_is_lost(page: Page, site: Site) -> None:
    """Samplers that interpolate, a buffer that textures are filled from, and textures that are filled upside down."""
    camera = camera_named(site, "side")
    bound = "() => host.bound()"
    with THREE.hosting(page):
        look(page, camera)
        page.evaluate("() => host.bind()")
        before = page.evaluate(bound)
        add_splats(page)
        settle(page)
        assert psnr(canvas(page), rasterized(site, camera, 0.4)) >= CANVAS_PSNR
        assert page.evaluate(bound) == before
        require_no_error(page)


def test_each_of_two_viewports_has_its_own_order(page: Page, site: Site) -> None:
    with THREE.hosting(page, width=2 * WIDTH):
        asked.require_two_views(page, site)


def test_render_targets_get_the_same_picture_in_linear_light(page: Page, site: Site) -> None:
    """At any corner; the earlier picture is behind the splats, and unchanged elsewhere."""
    camera = camera_named(site, "side")
    truth = rasterized(site, camera, 0.4)
    least = {0: FLOAT_PSNR, 4: HALF_PSNR}  # keys: samples
    with THREE.hosting(page):
        look(page, camera)
        without = {samples: floats(page, offset=40, samples=samples) for samples in least}
        add_splats(page)
        settle(page)
        for samples, enough in least.items():
            assert psnr(srgb(floats(page, offset=40, samples=samples)), truth) >= enough
            assert psnr(srgb(without[samples]), np.broadcast_to(BACKGROUND, truth.shape)) >= enough
        require_no_error(page)


def test_coarse_targets_get_splats_that_are_blended_in_linear_light(page: Page, site: Site) -> None:
    """The reference blends colours that were turned into linear light splat by splat."""
    import torch

    def linear(rgb: torch.Tensor) -> torch.Tensor:
        return torch.where(rgb > 0.04045, ((rgb.clamp(min=0) + 0.055) / 1.055) ** 2.4, rgb / 12.92)

    camera = camera_named(site, "side")
    background = tuple(linear(torch.tensor(BACKGROUND, dtype=torch.float64)).tolist())
    truth = rasterized(site, camera, 0.4, background=background, colours=linear)
    with THREE.hosting(page):
        look(page, camera)
        page.evaluate("() => { host.renderer.outputColorSpace = THREE.LinearSRGBColorSpace }")
        add_splats(page)
        settle(page)
        assert psnr(canvas(page), truth) >= CANVAS_PSNR


def test_a_context_that_was_lost_comes_back_with_the_splats(page: Page, site: Site) -> None:
    with THREE.hosting(page):
        asked.require_restored_context(page, site)


def test_what_cannot_be_drawn_is_said_once_and_the_host_goes_on(page: Page, site: Site) -> None:
    with THREE.hosting(page):
        asked.require_one_complaint(page, site, "scale.set")
        page.evaluate("() => { host.camera = new THREE.OrthographicCamera(); host.draw() }")
        assert "has no perspective" in page.evaluate("() => host.heard.at(-1)")


def test_a_scene_plays_tells_and_is_disposed_of(page: Page, site: Site) -> None:
    """The host's context stays alive."""
    end = """() => {
      const asked = host.splats.seek(0).catch((error) => error.name);
      host.splats.dispose();
      return asked;
    }"""
    with THREE.hosting(page):
        asked.require_whole_life(page, site, "addEventListener", end)
        assert page.evaluate("() => host.splats.parent === null && !host.renderer.getContext().isContextLost()")
        require_no_error(page)


def test_a_scene_sounds_in_step_while_the_host_draws_and_is_not_muted(
    browser: Browser, address: str, site: Site, tmp_path: Path
) -> None:
    folder = publish_clicks(tmp_path / "run")
    audio = load_manifest(folder).audio
    assert audio is not None
    requested: list[str] = []

    def listen(page: Page) -> None:
        page.on("request", lambda request: requested.append(request.url.rpartition("/")[2]))
        page.add_init_script(path=str(TAP))
        serve_folder(page, "clicks", folder)

    with THREE.page(browser, address, listen) as page, THREE.hosting(page):
        look(page, camera_named(site, "side"))
        add_splats(page, 0.0, src="/clicks/manifest.json", autoplay=True, loop=True, muted=True)
        page.evaluate("""() => {
          window.samples = [];
          host.renderer.setAnimationLoop(() => {
            host.draw();
            window.samples.push([document.timeline.currentTime, host.splats.currentTime]);
          });
        }""")
        page.wait_for_function("() => host.splats.currentTime > 0.3")
        assert set(audio.sizes).isdisjoint(requested)
        page.evaluate("() => { host.splats.muted = false; host.splats.volume = 0.9 }")
        assert abs(ahead(page, 1.0)) <= FARTHEST
        assert page.evaluate("() => [host.splats.muted, host.splats.volume]") == [False, 0.9]
        assert page.evaluate("() => host.heard.filter((type) => type === 'volumechange').length") >= 2
        page.evaluate("() => { host.splats.muted = true }")
        page.wait_for_function("() => window.context.state === 'suspended'")


def test_the_example_shows_a_mesh_before_and_one_behind_the_splats(browser: Browser, address: str) -> None:
    THREE.require_example(browser, address, asked.require_meshes_around)


def test_the_program_of_the_documents_plays_and_seeks(browser: Browser, address: str) -> None:
    THREE.require_program(browser, address, 1, "addEventListener")
