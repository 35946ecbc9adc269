"""A scene with clicks as its sound, and the lead of a page's picture over them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import av
import numpy as np
import pytest

from hgs_core.capture.sound.sound_pieces import cut_sound
from hgs_core.codec import encode_scene
from hgs_core.codec.format.audio import AudioEntry, AudioPiece, CodedAudio
from hgs_core.codec.format.scene_folder import chunk_id
from hgs_core.scene.camera import Camera, looking_at
from hgs_core.scene.splats import HybridScene, Segment
from server.publishing.static_folder import PLAYER
from server.publishing.web_folder import publish_to_folder
from server.routes.viewer_pages import VIEWER
from tests.synthetic import synthetic_scene

if TYPE_CHECKING:
    from playwright.sync_api import Page

RATE = 48_000
SECONDS = 6
CLICKS = np.cumsum(np.random.default_rng(2).uniform(0.17, 0.31, 25))  # no two gaps are alike
CLICKS = CLICKS[CLICKS < SECONDS - 0.3]
FARTHEST = 40.0  # ms that sound and picture may be apart
REFRESH = 1000 / 60  # ms from a frame until it is seen
TAP = Path(__file__).with_name("sound_tap.js")


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


def publish_clicks(run: Path) -> Path:
    """Publish a scene of six seconds with clicks; return the folder."""
    if not (VIEWER / PLAYER / "hgs-player.js").is_file():
        pytest.skip("the viewer is not built: run npm ci && npm run build in web_client")
    static, dynamic = (splats.map(lambda array: array.numpy()) for splats in synthetic_scene())
    camera = Camera("side", 320, 200, 300.0, 280.0, 160.0, 100.0, looking_at((0.3, -0.2, -3.2), np.zeros(3)))
    run.mkdir()
    encode_scene(
        HybridScene(static, (Segment(0.0, float(SECONDS), dynamic),)),
        run / "scene",
        cameras=[camera],
        times=np.linspace(0, SECONDS, 91),
        title="Clicks",
        audio=clicking(run / "clicks.mka"),
    )
    publish_to_folder(run, run / "site", player=VIEWER / PLAYER)
    return run / "site"


def ahead(page: Page, rate: float) -> float:
    """The lead of the picture over its sound, ms, in the median over three clicks.

    A busy machine shows single pictures late, an error of the clock lasts: up to four medians are taken, until one is
    within ``FARTHEST``.
    """
    for _ in range(4):
        found = _ahead_once(page, rate)
        if abs(found) <= FARTHEST:
            break
    return found


def _ahead_once(page: Page, rate: float) -> float:
    page.evaluate("() => { window.clicks.length = window.samples.length = 0; }")
    clicks, samples = page.wait_for_function(
        """(refresh) => {
          const { samples } = window;
          const clicks = window.clicks.filter((click) => samples[0]?.[0] < click - refresh).slice(0, 3);
          return clicks.length === 3 && samples.at(-1)[0] > clicks[2] + 50 && [clicks, samples];
        }""",
        arg=REFRESH,
    ).json_value()
    frames = np.array(samples)
    found = []
    for heard in clicks:
        at = int(np.searchsorted(frames[:, 0], heard - REFRESH)) - 1
        seen = frames[at, 1] + rate * (heard - REFRESH - frames[at, 0]) / 1000
        found.append(1000 / rate * float(min(seen - CLICKS, key=abs)))
    return float(np.median(found))
