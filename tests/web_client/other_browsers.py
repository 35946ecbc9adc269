"""Debian's Firefox and WebKitGTK, driven as tests drive Chromium's pages.

Playwright drives builds of its own only. Firefox is driven by Mozilla's marionette-driver, which speaks to the browser
itself: Selenium needs geckodriver, which Debian has not and Selenium would download. WebKitGTK is driven by Selenium
through Debian's WebKitWebDriver. Both draw by llvmpipe on an Xvfb of their own; without a display Firefox has no WebGL.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

__all__ = ["HINTS", "OPENERS", "DrivenPage", "xvfb"]

PATIENCE = 120.0  # seconds
HINTS = {
    "firefox": "no Firefox on a virtual display: apt-get install firefox-esr xvfb",
    "webkit": "no WebKitGTK on a virtual display: apt-get install webkit2gtk-driver xvfb",
}
_CALL = """
const [argument, done] = arguments;
Promise.resolve()
  .then(() => (CALL)(argument))
  .then((value) => done({ value: value === undefined ? null : value }), (error) => done({ error: String(error) }));
"""
_ERRORS = """
return Services.console.getMessageArray()
  .filter((one) => one instanceof Ci.nsIScriptError && !(one.flags & Ci.nsIScriptError.warningFlag))
  .filter(({ sourceName }) => sourceName.startsWith("http://127.0.0.1"))
  .map(({ errorMessage, sourceName }) => `${sourceName}: ${errorMessage}`);
"""


@dataclass(frozen=True)
class DrivenPage:
    """A page of a browser, with the method names of Playwright's pages."""

    name: str
    version: str
    goto: Callable[[str], None]
    execute: Callable[[str, Any], dict[str, Any]]  # asynchronous script, its argument -> value or error
    errors: Callable[[], list[str]]  # uncaught errors of all its scripts; WebKitWebDriver reports none

    def evaluate(self, function: str, argument: Any = None) -> Any:
        """Return the result of a JavaScript function; a promise is awaited.

        Raises:
            RuntimeError: it throws, or its promise is rejected.
        """
        result = self.execute(_CALL.replace("CALL", function), argument)
        if "error" in result:
            raise RuntimeError(result["error"])
        return result["value"]

    def wait_for_function(self, function: str, argument: Any = None) -> None:
        until = time.monotonic() + PATIENCE
        while not self.evaluate(function, argument):
            if time.monotonic() > until:
                raise TimeoutError(f"{self.name}: not within {PATIENCE} s: {function}")
            time.sleep(0.1)


@contextmanager
def xvfb() -> Iterator[str]:
    """Run a virtual display of a free number; yields its name."""
    command = ["Xvfb", "-displayfd", "1", "-screen", "0", "1024x768x24", "-nolisten", "tcp"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        assert server.stdout is not None
        yield f":{server.stdout.readline().strip()}"
    finally:
        server.terminate()
        server.communicate(timeout=60)


@contextmanager
def _firefox(display: str, folder: Path) -> Iterator[DrivenPage]:
    preferences = {
        "gfx.webrender.all": False,  # a compositor on OpenGL in software, with which WebGL 2 is refused
        "gfx.webrender.software": True,
        "webgl.force-enabled": True,
    }
    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
        # A package below it uses what is deprecated, and it leaves sockets open while the browser starts.
        warnings.simplefilter("ignore")
        from marionette_driver.marionette import Marionette

        patch.setenv("DISPLAY", display)  # Marionette hands on the environment
        firefox = Marionette(
            bin=_firefox_path(), port=0, prefs=preferences, gecko_log=str(folder / "firefox.log"), startup_timeout=300
        )
    try:
        capabilities = firefox.start_session()
        firefox.timeout.script = PATIENCE

        def execute(script: str, argument: Any) -> dict[str, Any]:
            answer: dict[str, Any] = firefox.execute_async_script(script, script_args=[argument], sandbox=None)
            return answer

        def errors() -> list[str]:
            with firefox.using_context("chrome"):
                lines: list[str] = firefox.execute_script(_ERRORS)
                return lines

        yield DrivenPage("Firefox", capabilities["browserVersion"], firefox.navigate, execute, errors)
    finally:
        firefox.quit()
        firefox.cleanup()


@contextmanager
def _webkit(display: str, folder: Path) -> Iterator[DrivenPage]:
    from selenium.webdriver import WebKitGTK, WebKitGTKOptions
    from selenium.webdriver.webkitgtk.service import Service

    options = WebKitGTKOptions()
    options.binary_location = _webkit_path()
    options.add_argument("--automation")
    with (folder / "webkit.log").open("wb") as log:
        environment = os.environ | {"DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1"}
        service = Service(shutil.which("WebKitWebDriver"), log_output=log, env=environment)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # Selenium's, about itself
            webkit = WebKitGTK(options=options, service=service)
        try:
            webkit.set_script_timeout(PATIENCE)
            version = webkit.capabilities["browserVersion"]
            yield DrivenPage("WebKitGTK", version, webkit.get, webkit.execute_async_script, lambda: [])
        finally:
            webkit.quit()


def _firefox_path() -> str | None:
    return shutil.which("firefox-esr")


def _webkit_path() -> str | None:
    """The path of WebKitGTK's browser, where its driver is there, too."""
    browsers = sorted(Path("/usr/lib").glob("**/webkit2gtk-4.*/MiniBrowser"))
    return str(browsers[-1]) if browsers and shutil.which("WebKitWebDriver") else None


OPENERS = {"firefox": (_firefox_path, _firefox), "webkit": (_webkit_path, _webkit)}
