"""Splats in a host of three.js in a real browser, against the reference rasterizer's pictures and the host's own."""

from __future__ import annotations

import base64
import dataclasses
import functools
import http.server
import json
import shutil
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from benchmarks.viewers.browser import psnr
from hgs_core.codec import load_manifest
from tests.web_client.clicking_scene import FARTHEST, TAP, ahead, publish_clicks
from tests.web_client.conftest import BACKGROUND, HEIGHT, REPOSITORY, WIDTH
from tests.web_client.sparse_scene import AROUND, camera_at, encode_room, green, red

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from hgs_core.scene.camera import Camera
    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

CANVAS_PSNR = 45.0  # dB; a canvas of 8 bits rounds at every splat
HALF_PSNR = 50.0  # dB; a target of half floats
FLOAT_PSNR = 80.0  # dB; what is left is float32
FAR = 50.0
MAGENTA = (1.0, 0.0, 1.0)
IMPORTS = {
    "three": "/node_modules/three/build/three.module.js",
    "three/addons/": "/node_modules/three/examples/jsm/",
    "@hgs/player/three": "/dist/three.js",
}
PAGE = f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>A host</title><link rel="icon" href="data:,">
<style>body {{ margin: 0 }} canvas {{ display: block }}</style>
<script type="importmap">{json.dumps({"imports": IMPORTS})}</script>
<script type="module" src="three_host.js"></script>"""


@pytest.fixture(scope="module")
def address(site: Site, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A plain web server with the package as it is built, three.js, the clouds, a page and the example."""
    client = REPOSITORY / "web_client"
    npx = shutil.which("npx")
    if npx is None or not (client / "node_modules" / "three").is_dir():
        pytest.skip("needs npm and web_client/node_modules")
    folder = tmp_path_factory.mktemp("host")
    build = [
        npx,
        "vite",
        "build",
        "-c",
        "vite.package.config.ts",
        "--outDir",
        str(folder / "dist"),
        "--logLevel",
        "warn",
    ]
    subprocess.run(build, cwd=client, check=True, capture_output=True)
    (folder / "node_modules").mkdir()
    for name in ("three", "playcanvas"):
        (folder / "node_modules" / name).symlink_to(client / "node_modules" / name)
    (folder / "examples").symlink_to(client / "examples")
    (folder / "clouds").symlink_to(site.folder)
    encode_room(folder / "room", AROUND)
    for name in ("drawn_host.js", "three_host.js"):
        (folder / name).symlink_to(Path(__file__).with_name(name))
    (folder / "index.html").write_text(PAGE)
    handler = functools.partial(Files, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


class Files(http.server.SimpleHTTPRequestHandler):
    """A handler without a log."""

    def log_message(self, *_: Any) -> None:
        pass


@contextmanager
def hosting(browser: Browser, address: str, **options: Any) -> Iterator[Page]:
    """A page with a `host` that has a canvas of the cameras' size."""
    page = browser.new_page(viewport={"width": 900, "height": 700})
    page.add_init_script("window.warnings = []; console.warn = (...words) => warnings.push(words.join(' '))")
    try:
        page.goto(address)
        page.wait_for_function("() => window.Host")
        made = {"width": WIDTH, "height": HEIGHT, "background": BACKGROUND} | options
        page.evaluate("(options) => { window.host = new Host(options) }", made)
        yield page
    finally:
        page.close()


def camera_named(site: Site, name: str) -> Camera:
    return next(camera for camera in site.cameras if camera.name == name)


def numbers(camera: Camera, rows: npt.NDArray[np.float64] | None = None, scale: float = 1.0) -> dict[str, Any]:
    """The camera for the page; `rows` in place of its own matrix, in a world of units `scale` times smaller."""
    values = {name: getattr(camera, name) for name in ("width", "height", "fx", "fy", "cx", "cy")}
    matrix = np.asarray(camera.world_to_camera if rows is None else rows, np.float64)
    return values | {"near": camera.near * scale, "far": FAR * scale, "rows": matrix.tolist()}


def look(page: Page, camera: Camera, rows: npt.NDArray[np.float64] | None = None, scale: float = 1.0) -> None:
    page.evaluate("(camera) => host.look(camera)", numbers(camera, rows, scale))


def add_splats(page: Page, time: float = 0.4, place: list[list[float]] | None = None, **options: Any) -> None:
    made = {"src": "/clouds/manifest.json", "time": time} | options
    page.evaluate("([options, place]) => host.addSplats(options, place)", [made, place])


def settle(page: Page) -> None:
    page.evaluate("() => host.settled()")


def canvas(page: Page) -> npt.NDArray[np.uint8]:
    data = base64.b64decode(page.evaluate("() => host.pixels()"))
    return np.frombuffer(data, np.uint8).reshape(HEIGHT, -1, 4)[::-1, :, :3]


def floats(page: Page, offset: int = 0, samples: int = 0) -> npt.NDArray[np.float32]:
    taken = page.evaluate("([offset, samples]) => host.floats(offset, samples)", [offset, samples])
    data = np.frombuffer(base64.b64decode(taken), np.float16 if samples else np.float32).astype(np.float32)
    return data.reshape(HEIGHT, WIDTH, 4)[::-1, :, :3]


def srgb(light: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
    """Linear light as sRGB."""
    c = np.maximum(light.astype(np.float64), 0.0)
    return np.where(c > 0.0031308, 1.055 * c ** (1 / 2.4) - 0.055, c * 12.92)


def rasterized(
    site: Site,
    camera: Camera,
    seconds: float,
    keep: Callable[[Any], Any] | None = None,
    background: tuple[float, ...] = BACKGROUND,
    colours: Callable[[Any], Any] = lambda rgb: rgb,
    antialiased: bool = False,
    rig: tuple[Camera, ...] = (),
) -> npt.NDArray[np.float64]:
    """The reference picture, [H, W, 3]; `keep` says of centres, [N, 3], which splats are in it."""
    import torch

    from hgs_core.render import rasterize
    from hgs_core.scene.motion import position

    scene = site.scene.map(lambda array: torch.tensor(array, dtype=torch.float64))
    segment = scene.segment_at(seconds)
    time = segment.normalised(seconds)
    static, dynamic = scene.static, segment.dynamic
    if keep is not None:
        static = static.take(keep(static.means))
        dynamic = dynamic.take(keep(position(dynamic.motion, (time - dynamic.time_centers)[:, None])))
    static = dataclasses.replace(static, rgb=colours(static.rgb))
    dynamic = dataclasses.replace(dynamic, rgb=colours(dynamic.rgb))
    render = rasterize(
        static,
        dynamic,
        camera,
        time,
        background=background,
        backend="reference",
        gradients="none",
        antialiased=antialiased,
        rig=rig,
    )
    picture: npt.NDArray[np.float64] = render.rgb.permute(1, 2, 0).double().numpy()
    return picture


@pytest.mark.parametrize(("name", "seconds"), [("side", 0.4), ("askew", 1.7)])
def test_splats_alone_are_the_reference_picture(
    browser: Browser, address: str, site: Site, name: str, seconds: float
) -> None:
    """On the canvas; and in a target of floats at any corner of it, in sRGB where that is asked for."""
    camera = camera_named(site, name)
    truth = rasterized(site, camera, seconds)
    with hosting(browser, address) as page:
        look(page, camera)
        add_splats(page, seconds, linear=False)
        settle(page)
        assert psnr(canvas(page), truth) >= CANVAS_PSNR
        page.evaluate("() => host.renderer.setClearColor(new THREE.Color(0.1, 0.2, 0.3), 1)")
        assert psnr(floats(page), truth) >= FLOAT_PSNR
        assert psnr(floats(page, offset=40), truth) >= FLOAT_PSNR


def test_the_room_of_a_sparse_rig_fades_as_in_the_player(browser: Browser, address: str) -> None:
    with hosting(browser, address, background=(0, 0, 0)) as page:
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


@pytest.mark.parametrize(
    "depth",
    [{}, {"logarithmicDepthBuffer": True}, {"reversedDepthBuffer": True}],
    ids=["plain", "logarithmic", "reversed"],
)
def test_splats_behind_a_wall_are_hidden_and_those_before_it_are_drawn_over_it(
    browser: Browser, address: str, site: Site, depth: dict[str, bool]
) -> None:
    """The reference has only the splats with centres before the wall, on its colour."""
    camera = camera_named(site, "side")
    rows = np.asarray(camera.world_to_camera, np.float64)
    wall = 3.0
    truth = rasterized(
        site, camera, 0.4, background=MAGENTA, keep=lambda means: (means.numpy() @ rows[2, :3] + rows[2, 3]) < wall
    )
    with hosting(browser, address, renderer=depth) as page:
        if depth:
            name = next(iter(depth))
            assert page.evaluate("(name) => host.renderer.capabilities[name]", name), f"this browser has no {name}"
        look(page, camera)
        page.evaluate("(depth) => host.addWall(depth)", wall)
        add_splats(page, linear=False)
        settle(page)
        assert psnr(floats(page), truth) >= FLOAT_PSNR


def require_depth(page: Page, site: Site, canvas: Callable[[Page], npt.NDArray[np.uint8]]) -> None:
    """A mesh before the splats keeps its colour, and one behind them is covered."""
    look(page, camera_named(site, "side"))
    page.evaluate("() => host.addWall(1, { size: 0.3, at: [0.2, 0.1], colour: [1, 0, 0] })")
    page.evaluate("() => host.addWall(6, { size: 2, at: [-0.5, 0], colour: [0, 1, 0] })")
    without = canvas(page)
    add_splats(page)
    settle(page)
    shown = canvas(page)
    before = (without == [255, 0, 0]).all(axis=2)
    behind = (without == [0, 255, 0]).all(axis=2)
    assert before.sum() > 1000
    assert behind.sum() > 1000
    assert (shown[before] == [255, 0, 0]).all()
    assert (shown[behind] != [0, 255, 0]).any(axis=1).mean() > 0.9


def require_steady_heap(page: Page, mounts: str) -> None:
    """Two hundred scenes that come and go leave a page's heap as it was; `mounts` is a function of their number."""
    session = page.context.new_cdp_session(page)

    def heap(count: int) -> float:
        page.evaluate(mounts, count)
        session.send("HeapProfiler.collectGarbage")
        used: float = session.send("Runtime.getHeapUsage")["usedSize"]
        return used / 1e6

    first = heap(20)
    after = [heap(60) for _ in range(3)]
    print(f"heap after 20, 80, 140 and 200 mounts: {first:.2f} {after} MB")
    assert after[-1] < first + 1.0


def test_a_mesh_before_the_splats_keeps_its_colour_and_one_behind_is_covered(
    browser: Browser, address: str, site: Site
) -> None:
    with hosting(browser, address) as page:
        require_depth(page, site, canvas)


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
            taken = page.evaluate("() => host.frames(0, 12)")
            if splats:
                settle(page)
            taken += page.evaluate("() => host.frames(12, 4)")
            assert page.evaluate("() => host.renderer.getContext().getError()") == 0
            pictures.append(taken)
    assert len(set(pictures[0])) > 7  # every second frame is another picture
    assert [a == b for a, b in zip(*pictures, strict=True)] == [True] * 16


def test_what_a_host_has_bound_neither_harms_the_splats_nor_is_lost(browser: Browser, address: str, site: Site) -> None:
    """Samplers that interpolate, a buffer that textures are filled from, and textures that are filled upside down."""
    camera = camera_named(site, "side")
    bound = "() => host.bound()"
    with hosting(browser, address) as page:
        look(page, camera)
        page.evaluate("() => host.bind()")
        before = page.evaluate(bound)
        add_splats(page)
        settle(page)
        assert psnr(canvas(page), rasterized(site, camera, 0.4)) >= CANVAS_PSNR
        assert page.evaluate(bound) == before
        assert page.evaluate("() => host.renderer.getContext().getError()") == 0


def test_each_of_two_viewports_has_its_own_order(browser: Browser, address: str, site: Site) -> None:
    cameras = [camera_named(site, name) for name in ("side", "askew")]
    with hosting(browser, address, width=2 * WIDTH) as page:
        page.evaluate("([a, b]) => host.split(a, b)", [numbers(camera) for camera in cameras])
        add_splats(page)
        settle(page)
        shown = canvas(page)
    for camera, half in zip(cameras, np.split(shown, 2, axis=1), strict=True):
        assert psnr(half, rasterized(site, camera, 0.4)) >= CANVAS_PSNR


@pytest.mark.parametrize(("samples", "least"), [(0, FLOAT_PSNR), (4, HALF_PSNR)])
def test_render_targets_get_the_same_picture_in_linear_light(
    browser: Browser, address: str, site: Site, samples: int, least: float
) -> None:
    """At any corner; the earlier picture is behind the splats, and unchanged elsewhere."""
    camera = camera_named(site, "side")
    truth = rasterized(site, camera, 0.4)
    with hosting(browser, address) as page:
        look(page, camera)
        without = floats(page, offset=40, samples=samples)
        add_splats(page)
        settle(page)
        shown = floats(page, offset=40, samples=samples)
        assert psnr(srgb(shown), truth) >= least
        assert psnr(srgb(without), np.broadcast_to(BACKGROUND, truth.shape)) >= least
        assert page.evaluate("() => host.renderer.getContext().getError()") == 0


def test_coarse_targets_get_splats_that_are_blended_in_linear_light(browser: Browser, address: str, site: Site) -> None:
    """The reference blends colours that were turned into linear light splat by splat."""
    import torch

    def linear(rgb: torch.Tensor) -> torch.Tensor:
        return torch.where(rgb > 0.04045, ((rgb.clamp(min=0) + 0.055) / 1.055) ** 2.4, rgb / 12.92)

    camera = camera_named(site, "side")
    background = tuple(linear(torch.tensor(BACKGROUND, dtype=torch.float64)).tolist())
    truth = rasterized(site, camera, 0.4, background=background, colours=linear)
    with hosting(browser, address) as page:
        look(page, camera)
        page.evaluate("() => { host.renderer.outputColorSpace = THREE.LinearSRGBColorSpace }")
        add_splats(page)
        settle(page)
        assert psnr(canvas(page), truth) >= CANVAS_PSNR


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
        page.evaluate("() => { host.heard.length = 0; host.splats.scale.set(1, 2, 1) }")
        for _ in range(3):
            assert np.array_equal(canvas(page), without)
        said = page.evaluate("() => host.heard")
        assert [words.partition(":")[0] for words in said] == ["the scene is scaled by 1, 2, 1"]
        assert page.evaluate("() => warnings") == [f"HgsScene: {said[0]}"]
        page.evaluate("() => { host.splats.scale.set(1, 1, 1); host.drawn = host.camera }")
        page.evaluate("() => { host.camera = new THREE.OrthographicCamera(); host.draw(); host.camera = host.drawn }")
        assert "has no perspective" in page.evaluate("() => host.heard.at(-1)")
        assert np.array_equal(canvas(page), shown)


def test_a_scene_plays_tells_and_is_disposed_of(browser: Browser, address: str, site: Site) -> None:
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
          host.splats.addEventListener("ended", resolve);
          host.splats.play();
        }))"""
        page.evaluate(ended)
        told = [name for name in page.evaluate("() => host.heard") if name != "seeked"]
        assert told == ["manifest", "firstpicture", "ready", "play", "pause", "ended"]
        assert page.evaluate("() => host.splats.ended")
        page.evaluate(
            "() => { window.asked = host.splats.seek(0).catch((error) => error.name); host.splats.dispose() }"
        )
        assert page.evaluate("() => asked") == "AbortError"
        assert page.evaluate("() => host.splats.parent === null && !host.renderer.getContext().isContextLost()")
        assert np.array_equal(canvas(page), without)
        assert page.evaluate("() => host.renderer.getContext().getError()") == 0


def test_a_scene_sounds_in_step_while_the_host_draws_and_is_not_muted(
    browser: Browser, address: str, site: Site, tmp_path: Path
) -> None:
    folder = publish_clicks(tmp_path / "run")
    audio = load_manifest(folder).audio
    assert audio is not None
    asked: list[str] = []
    with hosting(browser, address) as page:
        page.on("request", lambda request: asked.append(request.url.rpartition("/")[2]))
        page.add_init_script(path=str(TAP))
        page.route(
            "**/clicks/**", lambda route: route.fulfill(path=folder / route.request.url.partition("/clicks/")[2])
        )
        page.reload()
        page.wait_for_function("() => window.Host")
        page.evaluate(
            "([width, height]) => { window.host = new Host({ width, height }); window.samples = [] }", [WIDTH, HEIGHT]
        )
        look(page, camera_named(site, "side"))
        add_splats(page, 0.0, src="/clicks/manifest.json", autoplay=True, loop=True, muted=True)
        page.evaluate("""() => host.renderer.setAnimationLoop(() => {
          host.draw();
          window.samples.push([document.timeline.currentTime, host.splats.currentTime]);
        })""")
        page.wait_for_function("() => host.splats.currentTime > 0.3")
        assert set(audio.sizes).isdisjoint(asked)
        page.evaluate("() => { host.splats.muted = false; host.splats.volume = 0.9 }")
        assert abs(ahead(page, 1.0)) <= FARTHEST
        assert page.evaluate("() => [host.splats.muted, host.splats.volume]") == [False, 0.9]
        assert page.evaluate("() => host.heard.filter((type) => type === 'volumechange').length") >= 2
        page.evaluate("() => { host.splats.muted = true }")
        page.wait_for_function("() => window.context.state === 'suspended'")


def test_the_example_shows_a_mesh_before_and_one_behind_the_splats(browser: Browser, address: str) -> None:
    page = browser.new_page(viewport={"width": 640, "height": 400})
    problems: list[str] = []
    page.on("console", lambda message: problems.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: problems.append(str(error)))
    try:
        page.goto(f"{address}/examples/three.html?src=/clouds/manifest.json")
        page.wait_for_function("() => window.splats && !document.querySelector('p')")
        page.evaluate("() => splats.pause()")
        page.evaluate("() => splats.seek(0.4)")
        shown, without = (
            screenshot(page, f"splats.visible = {visible}; renderer.render(world, camera)")
            for visible in ("true", "false")
        )
        before, behind = (mostly(without, channel) for channel in (0, 2))
        assert before.sum() > 5000
        assert behind.sum() > 5000
        assert np.array_equal(shown[before], without[before])
        assert (shown[behind] != without[behind]).any(axis=1).mean() > 0.9
        assert [problem for problem in problems if "GPU stall" not in problem] == []
    finally:
        page.close()


def screenshot(page: Page, change: str) -> npt.NDArray[np.uint8]:
    """The page after a change, by an expression, and two frames."""
    page.evaluate(f"() => {{ {change} }}")
    page.evaluate("() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))")
    return np.asarray(Image.open(BytesIO(page.screenshot())).convert("RGB"))


def mostly(picture: npt.NDArray[np.uint8], channel: int) -> npt.NDArray[np.bool_]:
    """Where a channel is twice as bright as each of the others."""
    others = np.delete(picture, channel, axis=2).max(axis=2).astype(int)
    bright: npt.NDArray[np.bool_] = picture[..., channel] > np.maximum(2 * others, 30)
    return bright


def test_the_program_of_the_documents_plays_and_seeks(browser: Browser, address: str) -> None:
    text = (REPOSITORY / "docs" / "three.md").read_text(encoding="utf-8")
    program = text.split("```js\n")[1].split("```")[0].replace("studio/manifest.json", "/clouds/manifest.json")
    script = f"{program}\nwindow.told = [];\nwindow.splats = splats;\n"
    script += "for (const type of ['ready', 'seeked']) splats.addEventListener(type, () => told.push(type));"
    page = browser.new_page(viewport={"width": 640, "height": 400})
    try:
        page.route(
            "**/program.html",
            lambda route: route.fulfill(
                content_type="text/html",
                body=f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>A program</title>
<canvas width="640" height="360"></canvas>
<script type="importmap">{json.dumps({"imports": IMPORTS})}</script><script type="module">{script}</script>""",
            ),
        )
        page.goto(f"{address}/program.html")
        page.wait_for_function("() => window.told?.includes('ready')")
        assert page.evaluate("() => splats.paused") is False
        page.evaluate("() => splats.seek(0.5)")
        assert "seeked" in page.evaluate("() => told")
    finally:
        page.close()
