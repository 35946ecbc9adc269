"""The real page of a real server in a real browser, against the reference rasterizer's pictures."""

from __future__ import annotations

import base64
import functools
from collections.abc import Callable
from typing import TYPE_CHECKING

import msgpack
import numpy as np
import numpy.typing as npt
import pytest

from benchmarks.viewers.browser import canvas_floats, canvas_pixels, open_viewer, psnr
from tests.web_client.conftest import HEIGHT, WIDTH

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from hgs_core.scene.camera import Camera
    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

FLOAT_PSNR = 80.0  # dB; what is left is float32 and the codec's identical inputs
CANVAS_PSNR = 50.0  # dB; the canvas blends in half floats and rounds to 8 bits
CAMERAS = ("side", "above", "askew")

Reference = Callable[[str, float], npt.NDArray[np.float64]]


def reference_picture(
    site: Site, name: str, seconds: float, *, antialiased: bool, backend: str = "reference"
) -> npt.NDArray[np.float64]:
    """The rasterizer's picture of the decoded scene, [H, W, 3]; by default the reference in float64."""
    import torch

    from hgs_core.render import rasterize

    dtype = torch.float64 if backend == "reference" else torch.float32
    scene = site.scene.map(lambda array: torch.tensor(array, dtype=dtype))
    segment = scene.segment_at(seconds)
    render = rasterize(
        scene.static,
        segment.dynamic,
        camera_named(site, name),
        segment.normalised(seconds),
        background=(0.1, 0.2, 0.3),
        backend=backend,
        gradients="none",
        antialiased=antialiased,
    )
    picture: npt.NDArray[np.float64] = render.rgb.permute(1, 2, 0).double().numpy()
    return picture


@pytest.fixture(scope="session")
def reference(site: Site) -> Reference:
    """Return a function (camera, seconds) -> the reference picture of the clouds."""
    return functools.cache(lambda name, seconds: reference_picture(site, name, seconds, antialiased=False))


def camera_named(site: Site, name: str) -> Camera:
    return next(camera for camera in site.cameras if camera.name == name)


def exact(site: Site, camera: str, seconds: float) -> str:
    shape = camera_named(site, camera)
    return f"{site.page}?camera={camera}&t={seconds}&width={shape.width}&height={shape.height}&paused=1&exact=1"


def view(browser: Browser, site: Site, camera: str, seconds: float, more: str = ""):  # type: ignore[no-untyped-def]
    shape = camera_named(site, camera)
    return open_viewer(browser, exact(site, camera, seconds) + more, width=shape.width, height=shape.height)


@pytest.mark.parametrize("camera", CAMERAS)
def test_canvas_shows_the_reference_picture(browser: Browser, site: Site, reference: Reference, camera: str) -> None:
    with view(browser, site, camera, 2.0) as page:
        for seconds in (2.0, 0.0, 0.4, 1.0, 1.7):
            page.evaluate("(seconds) => window.hgs.seek(seconds)", seconds)
            floats, canvas = (psnr(take(page), reference(camera, seconds)) for take in (canvas_floats, canvas_pixels))
            print(f"Chromium {browser.version}, {camera}, {seconds} s: floats {floats:.1f} dB, canvas {canvas:.1f} dB")
            assert floats >= FLOAT_PSNR
            assert canvas >= CANVAS_PSNR


TAKE_WHILE_PLAYING = """async (after) => {
  const base64 = ({ data }) => {
    let text = "";
    for (const byte of new Uint8Array(data.buffer)) text += String.fromCharCode(byte);
    return btoa(text);
  };
  for (;;) {
    await new Promise((resolve) => requestAnimationFrame(resolve));
    const { time, playing } = window.hgs.state;
    if (!playing || time < after) continue;
    const canvas = base64(await window.hgs.readPixels());
    const { pictureTime } = window.hgs.state;
    return { time, pictureTime, canvas, floats: base64(await window.hgs.readPixels({ float: true })) };
  }
}"""


@pytest.mark.parametrize("camera", CAMERAS)
def test_what_is_drawn_while_playing_is_exactly_the_picture_of_its_time(
    browser: Browser, site: Site, camera: str
) -> None:
    """Unless the machine is so busy that an order comes late: then one of the next pictures is."""

    def taken(page: Page, seconds: float) -> tuple[float, float]:
        """The canvas and the floats after this second, dB."""
        told = page.evaluate(TAKE_WHILE_PLAYING, seconds)
        truth = reference_picture(site, camera, told["pictureTime"], antialiased=False, backend="cpu")
        canvas, floats = (
            np.frombuffer(base64.b64decode(told[name]), kind).reshape(HEIGHT, WIDTH, 4)[..., :3]
            for name, kind in (("canvas", np.uint8), ("floats", np.float32))
        )
        return psnr(canvas, truth), psnr(floats, truth)

    with view(browser, site, camera, 0.0) as page:
        for seconds in (0.2, 0.6, 1.2, 1.6):
            page.evaluate("() => window.hgs.seek(0).then(() => window.hgs.play())")
            psnrs: list[tuple[float, float]] = []
            while not psnrs or psnrs[-1][0] < CANVAS_PSNR or psnrs[-1][1] < FLOAT_PSNR:
                assert len(psnrs) < 10, f"canvas and floats, dB: {psnrs}"
                psnrs.append(taken(page, seconds))


@pytest.mark.parametrize("camera", ["far", "close"])
def test_splats_thinner_than_a_pixel_are_drawn_as_the_scene_asks_or_the_other_way_to_compare(
    browser: Browser, dust: Site, camera: str
) -> None:
    shown = []
    for more, antialiased in (("", True), ("&antialiased=0", False)):
        truth = reference_picture(dust, camera, 0.4, antialiased=antialiased)
        with view(browser, dust, camera, 0.4, more) as page:
            assert psnr(canvas_floats(page), truth) >= FLOAT_PSNR
            assert psnr(canvas_pixels(page), truth) >= CANVAS_PSNR
            shown.append(canvas_floats(page))
    assert psnr(*shown) < 30


@pytest.mark.parametrize("fades", [True, False])
def test_what_is_near_fades_for_a_camera_that_a_visitor_has_placed(browser: Browser, site: Site, fades: bool) -> None:
    """Splats fade below 0.15 of the distance to the target; near the target hardly any are that close."""
    import torch

    from hgs_core.render import rasterize
    from hgs_core.scene import StaticSplats
    from hgs_core.scene.camera import Camera
    from tests.web_client.ordered_picture import moment

    side = camera_named(site, "side")
    eye, ahead = np.array([0.02, -0.04, -1.2]), np.array([0.1, 0.06, 1.0])
    target = eye + (10.0 if fades else 0.5) * ahead
    z = ahead / np.linalg.norm(ahead)
    x = np.cross(z, [0, -1, 0]) / np.linalg.norm(np.cross(z, [0, -1, 0]))
    pose = np.eye(4)
    pose[:3, :3] = [x, np.cross(z, x), z]
    pose[:3, 3] = -pose[:3, :3] @ eye
    camera = Camera("placed", side.width, side.height, side.fx, side.fy, side.cx, side.cy, pose)
    splats = moment(site.scene, 0.4)
    clear = 0.15 * np.linalg.norm(target - eye)
    share = (splats.means @ pose[2, :3] + pose[2, 3] - camera.near) / (clear - camera.near)
    opacity = splats.opacities * np.clip(share, 1e-9, 1)
    arrays = splats.means, np.log(splats.scales), splats.quats, np.log(opacity / (1 - opacity)), splats.rgb
    truth = rasterize(
        StaticSplats(*(torch.tensor(array) for array in arrays)),
        site.scene.segment_at(0.4).dynamic.map(lambda array: torch.tensor(array[:0], dtype=torch.float64)),
        camera,
        0.0,
        background=(0.1, 0.2, 0.3),
        backend="reference",
        gradients="none",
    ).rgb.permute(1, 2, 0)
    view = ",".join(f"{number:.7f}" for number in (*eye, *target, 0.0, -1.0, 0.0))
    size = {"width": side.width, "height": side.height}
    address = f"{site.page}?camera=side&t=0.4&width={side.width}&height={side.height}&paused=1&view={view}"
    with open_viewer(browser, address, **size) as page:
        assert psnr(canvas_floats(page), truth.numpy()) >= 60  # dB; the address has seven digits


def test_screen_shows_what_the_canvas_holds(browser: Browser, site: Site) -> None:
    from io import BytesIO

    from PIL import Image

    with view(browser, site, "side", 0.4) as page:
        screenshot = np.asarray(Image.open(BytesIO(page.screenshot())).convert("RGB"))
        assert np.array_equal(screenshot, canvas_pixels(page))


def test_seek_shows_the_picture_of_the_new_time(browser: Browser, site: Site, reference: Reference) -> None:
    with view(browser, site, "above", 0.0) as page:
        page.evaluate("() => window.hgs.seek(1.7)")
        assert psnr(canvas_pixels(page), reference("above", 1.7)) >= CANVAS_PSNR
        page.evaluate("() => window.hgs.seek(0.4)")
        assert psnr(canvas_pixels(page), reference("above", 0.4)) >= CANVAS_PSNR


def test_play_moves_the_picture_and_pause_holds_it(browser: Browser, site: Site) -> None:
    with view(browser, site, "side", 0.0) as page:
        before = canvas_pixels(page)
        page.evaluate("() => window.hgs.play()")
        page.wait_for_function("() => window.hgs.state.time > 0.3")
        page.evaluate("() => window.hgs.pause()")
        stopped = page.evaluate("() => window.hgs.seek(window.hgs.state.time).then(() => window.hgs.state.time)")
        after = canvas_pixels(page)
        assert psnr(before, after) < 35
        page.wait_for_timeout(200)
        assert page.evaluate("() => window.hgs.state.time") == stopped
        assert np.array_equal(canvas_pixels(page), after)


def test_lost_context_comes_back_with_the_same_picture(browser: Browser, site: Site) -> None:
    with view(browser, site, "side", 0.4) as page:
        before = canvas_pixels(page)
        page.locator("canvas").evaluate(
            """async (canvas) => {
              const context = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
              const event = (name) => new Promise((resolve) => canvas.addEventListener(name, resolve, { once: true }));
              const lost = event("webglcontextlost");
              context.loseContext();
              await lost;
              await new Promise((resolve) => setTimeout(resolve)); // until the event has been dealt with
              const restored = event("webglcontextrestored");
              context.restoreContext();
              await restored;
              await window.hgs.seek(0.4);
            }"""
        )
        assert np.array_equal(canvas_pixels(page), before)


def test_broken_connection_is_taken_up_again(browser: Browser, site: Site, reference: Reference) -> None:
    """The first connection is cut after its first chunk; the second one brings the rest."""
    cut = """
      const Original = WebSocket;
      window.connections = 0;
      window.WebSocket = class extends Original {
        constructor(url) {
          super(url);
          if (++window.connections > 1) return;
          let frames = 0;
          this.addEventListener("message", () => { if (++frames === 2) this.close(3000); });
        }
      };
    """
    size = {"width": site.cameras[0].width, "height": site.cameras[0].height}
    context = browser.new_context(viewport=size)
    try:
        context.add_init_script(cut)
        page = context.new_page()
        page.goto(exact(site, "side", 0.4))
        page.wait_for_function("() => window.hgs?.ready.then(() => true)")
        assert page.evaluate("() => window.connections") == 2
        assert psnr(canvas_pixels(page), reference("side", 0.4)) >= CANVAS_PSNR
    finally:
        context.close()


def test_damaged_chunk_is_fetched_again(browser: Browser, site: Site, reference: Reference, flipped_bit: str) -> None:
    """One bit of the stream's first chunk is wrong."""
    context = browser.new_context(viewport={"width": site.cameras[0].width, "height": site.cameras[0].height})
    try:
        context.add_init_script(flipped_bit)
        page = context.new_page()
        fetched: list[str] = []
        page.on("request", lambda request: fetched.append(request.url))
        page.goto(exact(site, "side", 0.4))
        page.wait_for_function("() => window.hgs?.ready.then(() => true)")
        assert len([url for url in fetched if "/chunks/" in url]) == 1
        assert psnr(canvas_pixels(page), reference("side", 0.4)) >= CANVAS_PSNR
    finally:
        context.close()


@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("/view/clouds?camera=cam99", "camera cam99"),
        ("/view/clouds?t=soon", "t=soon"),
    ],
)
def test_page_says_what_is_wrong(browser: Browser, site: Site, address: str, message: str) -> None:
    page = browser.new_page()
    try:
        page.goto(site.address + address)
        page.get_by_role("alert").filter(has_text=message).wait_for()
    finally:
        page.close()


def test_a_missing_scene_has_the_page_of_missing_addresses(browser: Browser, site: Site) -> None:
    page = browser.new_page()
    try:
        page.goto(site.address + "/view/nowhere")
        page.get_by_role("heading", name="There is no such scene here").wait_for()
        page.get_by_role("link", name="All scenes").click()
        page.get_by_role("heading", name="Scenes", exact=True).wait_for()
    finally:
        page.close()


WELCOME = {"type": "welcome", "protocol": 1, "scene": "clouds", "manifest_id": bytes(32), "remaining": 0}
FLOOD = {"type": "error", "code": "flood", "detail": "900 messages"}


@pytest.mark.parametrize(
    ("answer", "words", "cause"),
    [
        (b"\xc1", "This page and the server have different versions.", "not msgpack"),
        (msgpack.packb(FLOOD), "The server has ended the stream.", "900 messages"),
        (msgpack.packb(WELCOME | {"manifest": b"{}"}), "This page cannot read the scene.", "is missing"),
    ],
)
def test_a_failed_stream_is_told_in_plain_words_and_its_cause_to_the_console(
    browser: Browser, site: Site, answer: bytes, words: str, cause: str
) -> None:
    page = browser.new_page()
    told: list[str] = []
    page.on("console", lambda message: told.append(message.text))
    page.route_web_socket("**/stream", lambda socket: socket.on_message(lambda _: socket.send(answer)))
    try:
        page.goto(site.page)
        alert = page.get_by_role("alert").filter(has_text=words)
        alert.wait_for()
        assert cause not in alert.inner_text()
        assert any(cause in text for text in told)
    finally:
        page.close()


def test_list_shows_scenes_and_leads_to_the_player(browser: Browser, site: Site) -> None:
    page = browser.new_page()
    try:
        page.goto(site.address)
        card = page.get_by_role("link", name="Clouds").first
        card.wait_for()
        assert "KB" in card.inner_text()
        page.wait_for_function("() => [...document.images].every((image) => image.complete && image.naturalWidth > 0)")
        card.click()
        page.wait_for_function("() => window.hgs?.ready.then(() => true)")
        assert page.get_by_role("heading", name="Clouds").is_visible()
    finally:
        page.close()


def controlled(browser: Browser, site: Site) -> Page:
    """Open the page with its controls, standing still, wide enough for all of them."""
    page = browser.new_page(viewport={"width": 800, "height": 500})
    page.goto(f"{site.page}?paused=1&t=0.4")
    page.wait_for_function("() => window.hgs?.ready.then(() => true)")
    return page


def test_dragging_turns_the_camera_and_a_key_brings_it_back(browser: Browser, site: Site) -> None:
    page = controlled(browser, site)
    try:
        before = canvas_pixels(page)
        page.mouse.move(400, 250)
        page.mouse.down()
        page.mouse.move(500, 270, steps=4)
        page.mouse.up()
        for _ in range(100):  # a busy machine may hand the drag to the page after the seek
            page.evaluate("() => window.hgs.seek(0.4)")
            if psnr(canvas_pixels(page), before) < 30:
                break
            page.wait_for_timeout(100)
        else:
            pytest.fail("the picture has not turned")
        page.keyboard.press("r")
        page.locator(".message", has_text="Back to the camera").wait_for()
        page.evaluate("() => window.hgs.seek(0.4)")
        assert np.array_equal(canvas_pixels(page), before)
    finally:
        page.close()


def test_keyboard_plays_and_steps(browser: Browser, site: Site) -> None:
    page = controlled(browser, site)
    try:
        page.keyboard.press(".")
        page.wait_for_function("() => Math.abs(window.hgs.state.time - 0.4 - 2 / 30) < 1e-6")
        page.keyboard.press("Space")
        assert page.evaluate("() => window.hgs.state.playing")
        pause = page.get_by_role("button", name="Pause")
        pause.focus()  # controls hide after three seconds, which a busy machine may need, unless one has the focus
        pause.click()
        assert not page.evaluate("() => window.hgs.state.playing")
    finally:
        page.close()


def test_picture_follows_the_size_of_the_window(browser: Browser, site: Site) -> None:
    page = controlled(browser, site)
    try:
        page.set_viewport_size({"width": 390, "height": 700})
        page.wait_for_function("() => window.hgs.state.width === 390 && window.hgs.state.height === 700")
    finally:
        page.close()
