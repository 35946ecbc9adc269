"""A large capture made of a small one: its pictures resized, its time played to and fro.

    python -m scripts.make_large_capture samples/studio large --size 1352x1014 --frames 300
    python -m scripts.make_large_capture samples/studio long --size 256x192 --frames 300 --cameras 6

The default is the size of the N3DV captures. Enlarged pictures have less detail than filmed ones: they serve for times
and memory, not for qualities. The capture is one of LLFF's layout (docs/captures.md).
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from fractions import Fraction
from functools import partial
from pathlib import Path

import av
import numpy as np

__all__ = ["enlarged_video", "main"]

_RATE = 30  # frames per second
_POSES = "poses_bounds.npy"


def enlarged_video(source: Path, target: Path, size: tuple[int, int], frames: int, key_frames: int) -> None:
    """Write `frames` frames of `size` (width, height): those of `source` to and fro, a key frame every `key_frames`."""
    with av.open(str(source)) as video:
        width, height = size
        shown = [frame.reformat(width, height, "yuv420p", interpolation="LANCZOS") for frame in video.decode(video=0)]
    period = max(1, 2 * len(shown) - 2)
    with av.open(str(target), "w") as out:
        stream = out.add_stream("libx264", rate=_RATE)
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        stream.options = {"crf": "18", "preset": "veryfast", "g": str(key_frames)}
        stream.codec_context.thread_count = 1
        for number in range(frames):
            place = number % period
            frame = shown[min(place, period - place)]
            frame.pts, frame.time_base, frame.pict_type = number, Fraction(1, _RATE), av.video.frame.PictureType.NONE
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))


def _sized(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    return int(width), int(height)


def main() -> None:
    """Make the capture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=Path, help="a capture of LLFF's layout, with videos")
    parser.add_argument("target", type=Path, help="a new folder")
    parser.add_argument("--size", type=_sized, default=(1352, 1014), help="width x height, even (default 1352x1014)")
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--key-frames", type=int, default=250, help="frames between key frames")
    parser.add_argument("--cameras", type=int, help="how many, spread evenly over the capture's; by default all")
    given = parser.parse_args()
    given.target.mkdir(parents=True)
    videos, poses = sorted(given.source.glob("*.mp4")), np.load(given.source / _POSES)
    chosen = np.linspace(0, len(videos), given.cameras or len(videos), endpoint=False).astype(int)
    videos, poses = [videos[index] for index in chosen], poses[chosen]
    camera = poses[:, :15].reshape(-1, 3, 5)  # a view: rows of height, width and focal length in its last column
    width, height = given.size
    camera[:, 2, 4] *= width / camera[:, 1, 4]
    camera[:, 0, 4], camera[:, 1, 4] = height, width
    np.save(given.target / _POSES, poses)
    make = partial(enlarged_video, size=given.size, frames=given.frames, key_frames=given.key_frames)
    with ProcessPoolExecutor() as pool:
        list(pool.map(make, videos, [given.target / video.name for video in videos]))


if __name__ == "__main__":
    main()
