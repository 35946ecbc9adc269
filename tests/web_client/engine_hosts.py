"""Splats in the pages of other engines: the hosts, and the reference's pictures."""

from __future__ import annotations

import base64
import dataclasses
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from tests.web_client.conftest import BACKGROUND, HEIGHT, REPOSITORY, WIDTH

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from hgs_core.scene.camera import Camera
    from tests.web_client.conftest import Site

__all__ = [
    "CANVAS_PSNR",
    "FLOAT_PSNR",
    "HALF_PSNR",
    "MAGENTA",
    "Engine",
    "Picture",
    "add_splats",
    "camera_named",
    "canvas",
    "look",
    "numbers",
    "rasterized",
    "serve_folder",
    "settle",
    "srgb",
]

CANVAS_PSNR = 45.0  # dB; a canvas of 8 bits rounds at every splat
HALF_PSNR = 50.0  # dB; a target of half floats
FLOAT_PSNR = 80.0  # dB; what is left is float32
FAR = 50.0
MAGENTA = (1.0, 0.0, 1.0)
HEAD = """<!doctype html><html lang="en"><meta charset="utf-8"><title>A host</title><link rel="icon" href="data:,">
<style>body {{ margin: 0 }} canvas {{ display: block }}</style><script type="importmap">{}</script>"""

Picture = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Engine:
    """An engine with a page that makes a host of it."""

    host: str  # class that the script sets on the window
    script: str  # file beside this one
    imports: Mapping[str, str]
    example: str  # page of web_client/examples
    hidden: str  # expression without splats in the example, of `shown`

    @contextmanager
    def page(
        self, browser: Browser, address: str, prepare: Callable[[Page], None] = lambda page: None
    ) -> Iterator[Page]:
        """A page, prepared before it is loaded, that can make hosts."""
        page = browser.new_page(viewport={"width": 900, "height": 700})
        page.add_init_script(
            "window.warnings = []; console.warn = console.error = (...words) => warnings.push(words.join(' '))"
        )
        try:
            prepare(page)
            text = Path(__file__).with_name(self.script).read_text()
            body = f'{self._head}<script type="module">{text}</script>'
            page.route(f"{address}/", lambda route: route.fulfill(body=body, content_type="text/html"))
            page.goto(address)
            page.wait_for_function("(name) => window[name]", arg=self.host)
            yield page
        finally:
            page.close()

    @contextmanager
    def hosting(self, page: Page, **options: Any) -> Iterator[None]:
        """A new `host` in the page, that has a canvas of the cameras' size."""
        made = {"width": WIDTH, "height": HEIGHT, "background": BACKGROUND} | options
        page.evaluate(
            """([name, options]) => {
              warnings.length = 0;
              window.host = new window[name](options);
              return host.renderer?.init?.();
            }""",
            [self.host, made],
        )
        try:
            yield
        finally:
            page.evaluate("() => host.close()")

    @property
    def _head(self) -> str:
        return HEAD.format(json.dumps({"imports": dict(self.imports)}))

    def require_example(self, browser: Browser, address: str, check: Callable[[Picture, Picture], None]) -> None:
        """The example draws without a complaint; `check` is given its pictures with splats and without."""
        page = browser.new_page(viewport={"width": 480, "height": 300})
        problems: list[str] = []
        page.on(
            "console", lambda message: problems.append(message.text) if message.type in ("error", "warning") else None
        )
        page.on("pageerror", lambda error: problems.append(str(error)))
        try:
            page.goto(f"{address}/examples/{self.example}?src=/clouds/manifest.json")
            page.wait_for_function("() => window.splats && !document.querySelector('p')")
            page.evaluate("() => { splats.pause(); return splats.seek(0.4) }")
            check(*(_screenshot(page, self.hidden.format(shown=shown)) for shown in ("true", "false")))
            assert [problem for problem in problems if "GPU stall" not in problem] == []
        finally:
            page.close()

    def require_program(self, browser: Browser, address: str, number: int, listen: str) -> None:
        """A program of docs/three.md, by its number, plays and seeks; `listen` is the splats' method for events."""
        text = (REPOSITORY / "docs" / "three.md").read_text(encoding="utf-8")
        program = text.split("```js\n")[number].split("```")[0]
        script = program.replace("studio/manifest.json", "/clouds/manifest.json")
        script += "\nwindow.told = [];\nwindow.splats = splats;\n"
        script += f"for (const type of ['ready', 'seeked']) splats.{listen}(type, () => told.push(type));"
        body = f'{self._head}<canvas width="640" height="360"></canvas><script type="module">{script}</script>'
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


def canvas(page: Page) -> Picture:
    """The host's canvas, drawn right now."""
    data = base64.b64decode(page.evaluate("() => host.pixels()"))
    return np.frombuffer(data, np.uint8).reshape(HEIGHT, -1, 4)[:, :, :3]


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


def srgb(light: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
    """Linear light as sRGB."""
    c = np.maximum(light.astype(np.float64), 0.0)
    return np.where(c > 0.0031308, 1.055 * c ** (1 / 2.4) - 0.055, c * 12.92)


def serve_folder(page: Page, name: str, folder: Path) -> None:
    """Have the page find the files of a folder below /name/."""
    page.route(f"**/{name}/**", lambda route: route.fulfill(path=folder / route.request.url.partition(f"/{name}/")[2]))


def _screenshot(page: Page, change: str) -> Picture:
    """The page after a change, by an expression, and two frames."""
    page.evaluate(f"() => {{ {change} }}")
    page.evaluate("() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))")
    return np.asarray(Image.open(BytesIO(page.screenshot())).convert("RGB"))
