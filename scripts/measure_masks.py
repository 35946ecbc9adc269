"""The quality of automatic masks, on a capture as it is and made worse; prints a Markdown table.

    python -m scripts.measure_masks CAPTURE TRUTH [--cameras cam00,cam09] [--plain]

TRUTH has one folder of PNG masks per camera, as `hgs train --masks` takes them.
"""

from __future__ import annotations

import argparse
import io
from collections.abc import Callable, Mapping
from pathlib import Path

import av
import numpy as np
import numpy.typing as npt

from hgs_core.capture.open import open_capture
from hgs_core.decompose.background import estimate_background, moving_pixels, sample_frames

__all__ = ["DEGRADATIONS", "flickering", "noisy", "recompressed", "scores", "shadowed"]

Video = npt.NDArray[np.uint8]  # [F, H, W, 3]
_FRAMES = 12  # frames of each camera compared with the truth


def noisy(video: Video, deviation: float) -> Video:
    """Add Gaussian noise of so many levels of 255."""
    numbers = np.random.default_rng(0)
    worse = np.empty_like(video)
    for frame, picture in enumerate(video):
        noise = numbers.normal(0, deviation, picture.shape).astype(np.float32)
        worse[frame] = (picture + noise).round().clip(0, 255)
    return worse


def flickering(video: Video, share: float) -> Video:
    """Multiply every frame by a gain of its own, up to `share` above or below 1."""
    gains = 1 + np.random.default_rng(0).uniform(-share, share, len(video)).astype(np.float32)
    return np.stack([(p * g).round().clip(0, 255).astype(np.uint8) for p, g in zip(video, gains, strict=True)])


def shadowed(video: Video, depth: float = 0.35) -> Video:
    """Let a soft round shadow cross the picture from left to right."""
    frames, height, width, _ = video.shape
    row, column = np.mgrid[0:height, 0:width].astype(np.float32)
    worse = np.empty_like(video)
    for frame in range(frames):
        away = (column - width * (-0.2 + 1.4 * frame / frames)) ** 2 + (row - 0.55 * height) ** 2
        worse[frame] = video[frame] * (1 - depth * np.exp(-away / (2 * (0.12 * width) ** 2)))[..., None]
    return worse


def recompressed(video: Video, crf: int) -> Video:
    """Encode with H.264 in 4:2:0 at a constant rate factor, with its blocks, and decode again."""
    data = io.BytesIO()
    with av.open(data, "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=30, options={"crf": str(crf), "preset": "fast"})
        stream.height, stream.width, stream.pix_fmt = video.shape[1], video.shape[2], "yuv420p"
        for picture in video:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode())
    data.seek(0)
    with av.open(data) as container:
        return np.stack([frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)])


DEGRADATIONS: Mapping[str, Callable[[Video], Video]] = {
    "as it is": lambda video: video,
    "noise, sigma 5": lambda video: noisy(video, 5),
    "noise, sigma 10": lambda video: noisy(video, 10),
    "exposure flicker of 5 %": lambda video: flickering(video, 0.05),
    "flicker and noise, sigma 5": lambda video: noisy(flickering(video, 0.05), 5),
    "soft moving shadow": shadowed,
    "H.264, crf 38": lambda video: recompressed(video, 38),
}
"""Ways to make a video worse, by name."""


def scores(found: npt.NDArray[np.bool_], truth: npt.NDArray[np.bool_]) -> tuple[float, float, float]:
    """Return intersection over union, recall and precision of masks of one shape."""
    both = float((found & truth).sum())
    return both / max(1, (found | truth).sum()), both / max(1, truth.sum()), both / max(1, found.sum())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("capture", type=Path)
    parser.add_argument("truth", type=Path)
    parser.add_argument("--cameras", default="", help="names; default: all that have a truth")
    parser.add_argument("--plain", action="store_true", help="only the capture as it is")
    options = parser.parse_args()
    capture = open_capture(options.capture, masks=options.truth)
    given = [c.name for i, c in enumerate(capture.cameras) if capture.mask(i, 0) is not None]
    cameras = [capture.camera_index(name) for name in (options.cameras.split(",") if options.cameras else given)]
    chosen = sample_frames(len(capture.times), _FRAMES)
    ways = {"as it is": DEGRADATIONS["as it is"]} if options.plain else DEGRADATIONS
    found: dict[str, list[npt.NDArray[np.bool_]]] = {name: [] for name in ways}
    truth = []
    for camera in cameras:
        truth += [capture.mask(camera, frame) for frame in chosen]
        video = np.stack([capture.frame(camera, frame) for frame in range(len(capture.times))])
        for name, degrade in ways.items():
            worse = degrade(video)
            background = estimate_background(lambda frame, worse=worse: worse[frame], len(worse))
            found[name] += [moving_pixels(worse[frame], background) for frame in chosen]
    print("| video | IoU | recall | precision | marked |\n|---|---|---|---|---|")
    for name, masks in found.items():
        row = scores(np.stack(masks), np.stack(truth))
        print(f"| {name} | {row[0]:.3f} | {row[1]:.3f} | {row[2]:.3f} | {np.mean(masks):.3f} |")
    print(f"\nTruth: {np.mean(truth):.3f} of the pixels; {len(cameras)} cameras, {len(chosen)} frames each.")


if __name__ == "__main__":
    main()
