"""Open the viewer in headless Chromium, wait until everything is drawn, and compare the canvas with a picture.

Used by `scripts/demo --check` and by tests/web_client. Needs Playwright for Python and a system Chromium; it
downloads no browser.
"""

from __future__ import annotations

import base64
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from hgs_core.metrics.psnr import decibels

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page, Playwright

__all__ = [
    "CHROMIUM_HINT",
    "canvas_floats",
    "canvas_pixels",
    "capture_canvas",
    "find_chromium",
    "open_browser",
    "open_viewer",
    "psnr",
]

CHROMIUM_HINT = "no Chromium found: apt-get install chromium, or set HGS_CHROMIUM to its path"

# Chromium heeds the last list of features alone, and Playwright gives one: its own, as far as they concern our pages.
_FEATURES_OFF = (
    "AvoidCorsURLLoaderRestartOnRedirect",
    "AvoidUnnecessaryBeforeUnloadCheckSync",
    "DestroyProfileOnBrowserClose",
    "HttpsFirstBalancedModeAutoEnable",
    "HttpsUpgrades",
    "LensOverlay",
    "MediaRouter",
    "NetworkTimeServiceQuerying",
    "OptimizationHints",
    "PaintHolding",
    "PreconnectToSearch",
    "ThirdPartyStoragePartitioning",
    # Each window would load hidden pages for suggestions in its address bar: a third of the time of opening a scene.
    "AimEnabled",
    "WebUIOmniboxAimPopup",
    "WebUIOmniboxFullPopup",
    "WebUIOmniboxPopup",
)
_FLAGS = [
    f"--disable-features={','.join(_FEATURES_OFF)}",
    "--disable-gpu-rasterization",  # no GPU: software GL would draw text more slowly
    "--no-sandbox",  # containers rarely allow the sandbox, and only our own page is opened
    "--ignore-gpu-blocklist",
    "--force-color-profile=srgb",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--enable-unsafe-webgpu",
    "--use-webgpu-adapter=swiftshader",
]
# Mesa's llvmpipe draws faster than SwiftShader, but is not installed everywhere.
_DRIVERS = {
    "mesa": ["--use-gl=angle", "--use-angle=gl-egl"],
    "swiftshader": ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
}
_HAS_WEBGL2 = "() => document.createElement('canvas').getContext('webgl2') !== null"
_READ = """async (float) => {
  const { width, height, data } = await window.hgs.readPixels({ float });
  const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  let text = "";
  for (let i = 0; i < bytes.length; i += 32768) text += String.fromCharCode(...bytes.subarray(i, i + 32768));
  return { width, height, data: btoa(text) };
}"""


def find_chromium() -> str | None:
    """Return the path of Chromium or Chrome: `$HGS_CHROMIUM`, else the one on the PATH, else None."""
    chosen = os.environ.get("HGS_CHROMIUM")
    if chosen:
        return shutil.which(chosen)
    for name in ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable"):
        found = shutil.which(name)
        if found:
            return found
    return None


@contextmanager
def open_browser(chromium: str) -> Iterator[Browser]:
    """Start headless Chromium with the fastest software GL that it offers.

    Raises:
        RuntimeError: it draws no WebGL2 with any driver.
    """
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = _launch(playwright, chromium)
        try:
            yield browser
        finally:
            browser.close()


def _launch(playwright: Playwright, chromium: str) -> Browser:
    for driver in _DRIVERS.values():
        browser = playwright.chromium.launch(executable_path=chromium, headless=True, args=_FLAGS + driver)
        page = browser.new_page()
        works = page.evaluate(_HAS_WEBGL2)
        page.close()
        if works:
            return browser
        browser.close()
    raise RuntimeError(f"{chromium} draws no WebGL2 with {' or '.join(_DRIVERS)}")


@contextmanager
def open_viewer(browser: Browser, url: str, *, width: int, height: int, timeout: float = 120.0) -> Iterator[Page]:
    """Open `url` in a window of `width` x `height` and wait until everything alive at its time is drawn.

    Args:
        browser: from `open_browser`.
        url: address of a viewer page.
        width: of the window, CSS pixels (one CSS pixel is one pixel).
        height: of the window.
        timeout: seconds to wait for the picture.

    Raises:
        playwright.sync_api.Error: the page reports an error, which is in the message, or is not ready in time.
    """
    context = browser.new_context(viewport={"width": width, "height": height}, device_scale_factor=1)
    context.set_default_timeout(timeout * 1000)
    try:
        page = context.new_page()
        page.goto(url)
        page.wait_for_function("() => window.hgs !== undefined")
        page.wait_for_function("() => window.hgs.ready.then(() => true)")
        yield page
    finally:
        context.close()


def canvas_pixels(page: Page) -> npt.NDArray[np.uint8]:
    """Return the canvas of an open viewer, [H, W, 3] sRGB."""
    answer = page.evaluate(_READ, False)
    rgba = np.frombuffer(base64.b64decode(answer["data"]), np.uint8)
    return rgba.reshape(answer["height"], answer["width"], 4)[..., :3]


def canvas_floats(page: Page) -> npt.NDArray[np.float32]:
    """Return the picture of an open viewer drawn in floats, without the canvas's rounding, [H, W, 3] sRGB in [0, 1]."""
    answer = page.evaluate(_READ, True)
    rgba = np.frombuffer(base64.b64decode(answer["data"]), np.float32)
    return rgba.reshape(answer["height"], answer["width"], 4)[..., :3]


def capture_canvas(url: str, width: int, height: int, chromium: str) -> npt.NDArray[np.uint8]:
    """Open `url` once and return its canvas, [H, W, 3] sRGB; raises the errors of `open_viewer`."""
    with open_browser(chromium) as browser, open_viewer(browser, url, width=width, height=height) as page:
        return canvas_pixels(page)


def psnr(picture: npt.NDArray[Any], truth: npt.NDArray[Any]) -> float:
    """Return the PSNR in dB (data range 1) of two sRGB pictures, uint8 or floats in [0, 1]; inf if they are equal."""
    return decibels(float(np.mean((_unit(picture) - _unit(truth)) ** 2)))


def _unit(picture: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    scale = 255.0 if picture.dtype == np.uint8 else 1.0
    return np.clip(picture.astype(np.float64) / scale, 0.0, 1.0)
