"""Small videos with sound."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import numpy.typing as npt

from hgs_core.capture.sound.sound_track import SOUND_RATE

RATE = 30


def write_sounding_video(
    path: Path, frames: int, sound: npt.NDArray[np.float32] | None, *, codec: str = "pcm_s16le", seed: int = 0
) -> Path:
    """Write grey frames of 32x32 pixels, and mono sound [N] at `SOUND_RATE` if there is any."""
    random = np.random.default_rng(seed)
    with av.open(str(path), "w") as container:
        video = container.add_stream("mpeg4", rate=RATE)
        video.width, video.height, video.pix_fmt = 32, 32, "yuv420p"
        audio = None if sound is None else container.add_stream(codec, rate=SOUND_RATE, layout="mono")
        for _ in range(frames):
            grey = np.full((32, 32, 3), random.integers(40, 200), np.uint8)
            container.mux(video.encode(av.VideoFrame.from_ndarray(grey, format="rgb24")))
        container.mux(video.encode())
        if audio is not None and sound is not None:
            levels = (sound * 30000).clip(-32768, 32767).astype(np.int16)[None]
            resampler = av.AudioResampler(format=audio.format, layout="mono", rate=SOUND_RATE)
            for start in range(0, levels.shape[1], 1024):
                frame = av.AudioFrame.from_ndarray(
                    np.ascontiguousarray(levels[:, start : start + 1024]), format="s16", layout="mono"
                )
                frame.sample_rate, frame.pts = SOUND_RATE, start
                for part in resampler.resample(frame):
                    container.mux(audio.encode(part))
            container.mux(audio.encode())
    return path
