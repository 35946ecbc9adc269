"""Sound and picture in a real browser: in step, and silent until a visitor wants to hear it."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING

import av
import numpy as np
import pytest

from hgs_core.capture.sound_pieces import cut_sound
from hgs_core.codec import encode_scene, load_manifest
from hgs_core.codec.format.audio import AudioEntry, AudioPiece, CodedAudio
from hgs_core.codec.format.folder import chunk_id
from hgs_core.scene.camera import Camera, looking_at
from hgs_core.scene.splats import HybridScene, Segment
from server.viewer import VIEWER
from server.web_folder import PLAYER, publish_to_folder
from tests.synthetic import synthetic_scene
from tests.web_client.test_console_pages import violations

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

RATE = 48_000
SECONDS = 6
CLICKS = np.cumsum(np.random.default_rng(2).uniform(0.17, 0.31, 25))  # no two gaps are alike
CLICKS = CLICKS[CLICKS < SECONDS - 0.3]
FARTHEST = 40.0  # ms that sound and picture may be apart
REFRESH = 1000 / 60  # ms from a frame until it is seen
TAP = Path(__file__).with_name("sound_tap.js")
UNTOUCHED = """(() => {
  let touched = false;
  for (const type of ["pointerdown", "keydown"]) addEventListener(type, () => { touched = true; }, true);
  Object.defineProperty(navigator, "userActivation", { value: { get hasBeenActive() { return touched; } } });
})()"""
PICTURED = "() => document.querySelector('hgs-player')?.player?.statistics?.firstFrame != null"


def clicking(file: Path) -> CodedAudio:
    """Clicks, encoded by FFmpeg and cut as `hgs train` does it."""
    sound, burst = np.zeros((SECONDS + 1) * RATE), np.arange(240) / RATE
    for time in CLICKS:
        place = round(time * RATE)
        sound[place : place + 240] = 0.8 * np.sin(2 * np.pi * 2000 * burst) * np.exp(-800 * burst)
    with av.open(str(file), "w") as container:
        stream = container.add_stream("libopus", rate=RATE, layout="mono")
        frame = av.AudioFrame.from_ndarray((32_000 * sound).astype(np.int16)[None], format="s16", layout="mono")
        frame.sample_rate, frame.pts = RATE, 0
        resampler = av.AudioResampler(format="s16", layout="mono", rate=RATE, frame_size=960)
        for part in (*resampler.resample(frame), *resampler.resample(None)):
            container.mux(stream.encode(part))
        container.mux(stream.encode(None))
    cut = cut_sound(file, 0.0, float(SECONDS))
    assert cut is not None
    pieces = tuple(AudioPiece(chunk_id(piece.data), len(piece.data), piece.start, piece.end) for piece in cut.pieces)
    chunks = {chunk_id(piece.data): piece.data for piece in cut.pieces}
    return CodedAudio(AudioEntry(cut.codec, cut.sample_rate, cut.channels, pieces), chunks)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A published scene of six seconds with clicks."""
    if not (VIEWER / PLAYER / "hgs-player.js").is_file():
        pytest.skip("the viewer is not built: run npm ci && npm run build in web_client")
    run = tmp_path_factory.mktemp("runs") / "run"
    static, dynamic = (splats.map(lambda array: array.numpy()) for splats in synthetic_scene())
    camera = Camera("side", 320, 200, 300.0, 280.0, 160.0, 100.0, looking_at((0.3, -0.2, -3.2), np.zeros(3)))
    run.mkdir()
    encode_scene(
        HybridScene(static, (Segment(0.0, float(SECONDS), dynamic),)), run / "scene", cameras=[camera],
        times=np.linspace(0, SECONDS, 91), title="Clicks", audio=clicking(run / "clicks.mka"),
    )  # fmt: skip
    publish_to_folder(run, run / "site", player=VIEWER / PLAYER)
    return run / "site"


@pytest.fixture
def site(folder: Path) -> Iterator[str]:
    """Its address."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *_: object) -> None:
            """Say nothing."""

    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def ahead(page: Page, rate: float) -> float:
    """By how many milliseconds pictures are seen before they are heard, in the median over three clicks."""
    page.evaluate("() => { window.clicks.length = window.samples.length = 0; }")
    page.wait_for_function("() => window.clicks.length >= 3 && window.samples.at(-1)?.[0] > window.clicks[2] + 50")
    clicks, samples = page.evaluate("() => [window.clicks, window.samples]")
    frames = np.array(samples)
    found = []
    for heard in clicks[:3]:
        at = int(np.searchsorted(frames[:, 0], heard - REFRESH)) - 1
        if at < 0:
            continue
        seen = frames[at, 1] + rate * (heard - REFRESH - frames[at, 0]) / 1000
        found.append(1000 / rate * float(min(seen - CLICKS, key=abs)))
    return float(np.median(found))


def test_sound_is_in_step_with_the_picture_after_a_seek_and_at_other_rates(browser: Browser, site: str) -> None:
    page = browser.new_page()
    try:
        page.add_init_script(path=str(TAP))
        page.goto(site)
        page.wait_for_function(PICTURED)
        page.evaluate("""() => {
          window.samples = [];
          const element = document.querySelector("hgs-player");
          element.muted = false;
          element.player.addEventListener("frame", () => {
            window.samples.push([document.timeline.currentTime, element.currentTime]);
          });
        }""")
        measured = {"from the start": ahead(page, 1.0)}
        page.evaluate("() => { document.querySelector('hgs-player').currentTime = 2.9; }")
        measured["after a seek"] = ahead(page, 1.0)
        for rate in (0.5, 2.0):
            page.evaluate("(rate) => { document.querySelector('hgs-player').playbackRate = rate; }", rate)
            page.wait_for_timeout(100)
            measured[f"at rate {rate}"] = ahead(page, rate)
        page.evaluate("() => { document.querySelector('hgs-player').pause(); }")
        page.wait_for_function("() => window.context.state === 'suspended'")  # nothing sounds, nothing costs power
    finally:
        page.close()
    assert all(abs(milliseconds) <= FARTHEST for milliseconds in measured.values()), measured


def test_a_scene_is_silent_until_a_visitor_wants_to_hear_it(browser: Browser, site: str, folder: Path) -> None:
    audio = load_manifest(folder).audio
    assert audio is not None
    asked: list[str] = []
    page = browser.new_page()
    try:
        page.on("request", lambda request: asked.append(request.url.rpartition("/")[2]))
        page.add_init_script(UNTOUCHED)
        page.goto(site)
        page.wait_for_function(PICTURED)
        sound_on = page.get_by_role("button", name="Sound on")
        sound_on.wait_for()
        assert page.evaluate("() => document.querySelector('hgs-player').muted")
        assert set(audio.sizes).isdisjoint(asked)
        sound_on.click()
        page.get_by_role("button", name="Mute").wait_for()
        page.get_by_role("slider", name="Volume").fill("0.5")
        assert page.evaluate("() => document.querySelector('hgs-player').volume") == 0.5
        page.keyboard.press("m")
        sound_on.wait_for()
        page.keyboard.press("m")
        page.get_by_role("button", name="Mute").wait_for()
        assert violations(page) == []
        page.evaluate("() => document.querySelector('hgs-player').toggleAttribute('muted', true)")
        sound_on.wait_for()
        assert not set(audio.sizes).isdisjoint(asked)
    finally:
        page.close()


def test_sound_that_cannot_be_decoded_is_told_and_the_scene_plays_on(browser: Browser, site: str, folder: Path) -> None:
    audio = load_manifest(folder).audio
    assert audio is not None
    page = browser.new_page()
    try:
        for name in audio.sizes:
            page.route(f"**/chunks/{name}", lambda route: route.fulfill(body=b"no sound"))
        page.goto(site)
        page.wait_for_function(PICTURED)
        page.evaluate("() => { document.querySelector('hgs-player').muted = false; }")
        page.get_by_text("This browser cannot play the scene's sound.").wait_for()
        page.wait_for_function("(time) => document.querySelector('hgs-player').currentTime > time", arg=1.0)
    finally:
        page.close()
