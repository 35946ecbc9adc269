"""A large capture made of a small one: its pictures resized, its time played to and fro.

    python -m scripts.make_large_capture samples/studio large --size 1352x1014 --frames 300
    python -m scripts.make_large_capture samples/studio long --size 256x192 --frames 300 --cameras 6

The default is the size of the N3DV captures. Pictures of another aspect are cropped, and a line says so: their middle
is kept, as calibrations of LLFF's layout need (docs/captures.md). Enlarged pictures have less detail than filmed
ones: they serve for times and memory, not for qualities.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from fractions import Fraction
from functools import partial
from pathlib import Path

import av
import numpy as np
import numpy.typing as npt

__all__ = ["covering", "enlarged_video", "main", "scaled_row"]

_RATE = 30  # frames per second
_POSES = "poses_bounds.npy"


def covering(source: tuple[int, int], size: tuple[int, int]) -> tuple[int, int]:
    """Return the size that pictures of `source` are brought to, of their own aspect, before their middle is kept.

    It is the least that covers `size`, and exceeds it by even numbers: the middle stays the middle.
    """
    scale = max(size[0] / source[0], size[1] / source[1])
    width, height = (own + 2 * round((side * scale - own) / 2) for side, own in zip(source, size, strict=True))
    return width, height


def scaled_row(row: npt.NDArray[np.float64], size: tuple[int, int]) -> npt.NDArray[np.float64]:
    """Return a row of poses_bounds.npy for pictures that were brought to cover `size`, and cropped to it."""
    scaled = row.copy()
    height, width, focal = row[4:15:5]
    scaled[4:15:5] = size[1], size[0], focal * covering((round(width), round(height)), size)[0] / width
    return scaled


def enlarged_video(source: Path, target: Path, size: tuple[int, int], frames: int, key_frames: int) -> None:
    """Write `frames` frames of `size` (width, height): those of `source` to and fro, a key frame every `key_frames`."""
    width, height = size
    with av.open(str(source)) as video:
        shown = [_resized(frame, size) for frame in video.decode(video=0)]
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


def _resized(frame: av.VideoFrame, size: tuple[int, int]) -> av.VideoFrame:
    width, height = covering((frame.width, frame.height), size)
    if (width, height) == size:
        return frame.reformat(width, height, "yuv420p", interpolation="LANCZOS")
    left, top = (width - size[0]) // 2, (height - size[1]) // 2
    whole = frame.reformat(width, height, "rgb24", interpolation="LANCZOS").to_ndarray()
    middle = np.ascontiguousarray(whole[top : top + size[1], left : left + size[0]])
    return av.VideoFrame.from_ndarray(middle, format="rgb24").reformat(format="yuv420p")


def _sized(text: str) -> tuple[int, int]:
    sides = text.split("x")
    if len(sides) != 2 or not all(side.isdecimal() and int(side) > 0 and int(side) % 2 == 0 for side in sides):
        raise argparse.ArgumentTypeError(f"{text!r} is not two even numbers, as in 1352x1014")
    return int(sides[0]), int(sides[1])


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
    np.save(given.target / _POSES, np.stack([scaled_row(row, given.size) for row in poses]))
    whole = {covering((round(row[9]), round(row[4])), given.size) for row in poses}
    for width, height in sorted(whole - {given.size}):
        kept = f"{given.size[0]}x{given.size[1]}"
        print(f"pictures of another aspect are cropped: of {width}x{height} pixels the middle {kept} are kept")
    make = partial(enlarged_video, size=given.size, frames=given.frames, key_frames=given.key_frames)
    with ProcessPoolExecutor() as pool:
        list(pool.map(make, videos, [given.target / video.name for video in videos]))


if __name__ == "__main__":
    main()
