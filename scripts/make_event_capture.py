"""Makes a capture in which something happens between two frames, from one in which it does not.

    .venv/bin/python -m scripts.make_event_capture samples/studio /tmp/ball --event ball --place 0.45,-0.1,1.2
    .venv/bin/python -m scripts.make_event_capture samples/studio /tmp/lamp --event lamp

`ball`: a striped ball hangs at one place in space in the frames from FIRST to LAST, and is not there before and after.
It is traced in every camera and painted over the picture, so nothing may stand between it and a camera. Where it is, in
pixels, is written for all frames, whether it is there or not: `hgs eval RUN --masks OUT/event` then says by frame how
right that place is, ghosts included.
`lamp`: everything is brighter by a third in those frames.

OUT is in the PanopticSports layout, with lossless PNG pictures and 30 frames per second.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.scene.camera import Camera

__all__ = ["Ball", "brightened", "capture_meta", "save_picture", "write_event_capture"]

_SAMPLES = 4  # samples of a pixel along either side
_STRIPES = 8  # around the ball
_GAIN = 1.35

Picture = npt.NDArray[np.uint8]
Floats = npt.NDArray[np.float64]


class Ball:
    """A ball with coloured stripes around a vertical axis, shaded from above; z points up.

    Args:
        place: [3] of its centre, world units.
        radius: world units.
    """

    def __init__(self, place: npt.ArrayLike, radius: float) -> None:
        self._place, self._radius = np.asarray(place, np.float64), radius

    def seen_by(self, camera: Camera) -> tuple[Floats, Floats]:
        """Return the ball's colours times their coverage [H, W, 3], and the coverage [H, W], both in [0, 1]."""
        rows, columns = ((np.arange(n * _SAMPLES) + 0.5) / _SAMPLES for n in (camera.height, camera.width))
        local = np.stack(
            np.broadcast_arrays(
                (columns[None] - camera.cx) / camera.fx, (rows[:, None] - camera.cy) / camera.fy, np.float64(1)
            ),
            axis=-1,
        )
        rays = local @ camera.world_to_camera[:3, :3]  # row vectors: to the world
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        towards = self._place - camera.position
        nearest = rays @ towards
        under = nearest**2 - (towards @ towards - self._radius**2)
        hit = (under > 0) & (nearest > 0)
        normals = (camera.position - self._place + rays[hit] * (nearest - np.sqrt(np.maximum(under, 0)))[hit, None]) / (
            self._radius
        )
        colours = np.zeros((*hit.shape, 3))
        colours[hit] = _colours(normals)
        return _block_means(colours), _block_means(hit[..., None].astype(np.float64))[..., 0]

    def painted(self, picture: Picture, seen: tuple[Floats, Floats]) -> Picture:
        """Return a picture [H, W, 3] with the ball as `seen_by` its camera in front of everything."""
        colours, coverage = seen
        mixed = picture * (1 - coverage[..., None]) + 255 * colours
        return np.asarray(mixed.round().clip(0, 255), np.uint8)


def brightened(picture: Picture) -> Picture:
    """Return a picture under the lamp."""
    return np.asarray((picture * _GAIN).round().clip(0, 255), np.uint8)


def write_event_capture(capture: Capture, out: Path, first: int, last: int, ball: Ball | None) -> None:
    """Write the capture to the new folder `out`, with the ball, or else the lamp, in the frames `first` to `last`.

    Raises:
        InputError: the folder exists, the frames are not in the capture, or no camera sees the ball.
    """
    frames = len(capture.times)
    if not 0 <= first <= last < frames:
        raise InputError(
            "--frames", f"{first}:{last} is not within 0:{frames - 1}", "give the first and the last frame"
        )
    seen = {} if ball is None else {camera.name: ball.seen_by(camera) for camera in capture.cameras}
    if ball is not None and not any(coverage.any() for _, coverage in seen.values()):
        raise InputError("--place", "no camera sees the ball", "give a place before the cameras, in world units")
    if out.exists():
        raise InputError(out, "the folder exists", "name a new one")
    out.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(dir=out.parent, prefix=f".{out.name}-") as staging:
        there = Path(staging) / out.name
        there.mkdir()
        for index, camera in enumerate(capture.cameras):
            for frame in range(frames):
                picture = capture.frame(index, frame)
                if first <= frame <= last:
                    picture = brightened(picture) if ball is None else ball.painted(picture, seen[camera.name])
                save_picture(there / "ims" / camera.name / f"{frame:06d}.png", picture)
                if ball is not None:
                    covered = np.asarray((seen[camera.name][1] > 0) * 255, np.uint8)
                    save_picture(there / "event" / camera.name / f"{frame:04d}.png", covered)
        (there / "train_meta.json").write_text(json.dumps(capture_meta(capture)))
        there.rename(out)


def _colours(normals: Floats) -> Floats:
    """Return the colours [P, 3] of points of the ball with the given normals [P, 3]."""
    around = np.floor((np.arctan2(normals[:, 1], normals[:, 0]) / (2 * np.pi) + 0.5) * _STRIPES).astype(int)
    band = np.floor((normals[:, 2] + 1) * 2.5).astype(int)
    palette = np.array([[1.0, 0.85, 0.1], [0.95, 0.2, 0.6], [0.2, 0.9, 0.95], [1.0, 1.0, 1.0]])
    light = 0.75 + 0.25 * normals[:, 2:]
    return np.asarray(palette[(around + band) % len(palette)] * light)


def _block_means(values: Floats) -> Floats:
    """Return the means of all blocks of samples [H n, W n, K] of a pixel, [H, W, K]."""
    height, width, channels = values.shape
    blocks = values.reshape(height // _SAMPLES, _SAMPLES, width // _SAMPLES, _SAMPLES, channels)
    return np.asarray(blocks.mean((1, 3)))


def save_picture(path: Path, picture: Picture) -> None:
    """Write a picture as a PNG file; its folder is made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(picture).save(path, compress_level=1)


def capture_meta(capture: Capture) -> Mapping[str, Any]:
    """Return the contents of train_meta.json."""
    cameras, frames = capture.cameras, range(len(capture.times))
    return {
        "w": cameras[0].width,
        "h": cameras[0].height,
        "fn": [[f"{camera.name}/{frame:06d}.png" for camera in cameras] for frame in frames],
        "k": [[[[c.fx, 0, c.cx], [0, c.fy, c.cy], [0, 0, 1]] for c in cameras] for _ in frames],
        "w2c": [[camera.world_to_camera.tolist() for camera in cameras] for _ in frames],
        "cam_id": [[camera.name for camera in cameras] for _ in frames],
    }


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; 2 for bad input."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("capture", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--event", choices=("ball", "lamp"), default="ball")
    parser.add_argument("--frames", default="20:39", help="first and last frame of the event")
    parser.add_argument("--place", default="0,0,0", help="x,y,z of the ball's centre")
    parser.add_argument("--radius", type=float, default=0.1)
    given = parser.parse_args(arguments)
    try:
        first, last = (int(number) for number in given.frames.split(":"))
        place = [float(number) for number in given.place.split(",")]
        ball = Ball(np.array(place).reshape(3), given.radius) if given.event == "ball" else None
        write_event_capture(open_capture(given.capture), given.out, first, last, ball)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
