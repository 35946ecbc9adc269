"""The files of a film: MP4 for editors and players, WebM with alpha, or a folder of PNG pictures."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Protocol

import av
import numpy as np
import numpy.typing as npt
from av.video.reformatter import ColorRange, Colorspace
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.files.container import new_container
from hgs_core.film.film_sound import SAMPLE_RATE

__all__ = ["FilmFile", "film_file", "png_folder"]

_BT709 = 1  # number of the standard in ITU-T H.273: primaries, transfer and matrix
_QUALITY = {"libx264": "16", "libvpx-vp9": "20"}  # constant rate factors: hardly any visible loss
_SOUND_FRAME = 960  # samples of a packet


class FilmFile(Protocol):
    """A file that takes pictures in their order."""

    def add(self, picture: npt.NDArray[np.uint8]) -> None:
        """Append a picture [H, W, 3], or [H, W, 4] with alpha that colours are not multiplied by; sRGB."""
        ...


@contextmanager
def film_file(
    path: Path, size: tuple[int, int], rate: Fraction, sound: npt.NDArray[np.float32] | None, *, alpha: bool
) -> Iterator[FilmFile]:
    """Open a film: H.264 and AAC in .mp4, VP9 and Opus in .webm. It appears under its name when it is whole.

    Args:
        path: ends in .mp4 or .webm.
        size: width and height, both even.
        rate: pictures per second.
        sound: [channels, samples] at `SAMPLE_RATE`, or None.
        alpha: pictures have alpha; .webm alone keeps it.
    """
    web = path.suffix.lower() == ".webm"
    codec = "libvpx-vp9" if web else "libx264"
    muxer, options = ("webm", {}) if web else ("mp4", {"movflags": "faststart"})
    part = path.with_name(f".{path.name}.part")
    part.parent.mkdir(parents=True, exist_ok=True)
    try:
        with new_container(part, muxer, options) as out:
            video = out.add_stream(codec, rate=rate)
            assert isinstance(video, av.VideoStream)
            video.width, video.height = size
            video.pix_fmt = "yuva420p" if alpha else "yuv420p"
            video.options = {"crf": _QUALITY[codec], "b": "0"} if web else {"crf": _QUALITY[codec]}
            if alpha:
                video.metadata["alpha_mode"] = "1"
            context = video.codec_context
            context.color_primaries = context.color_trc = context.colorspace = _BT709
            context.color_range = ColorRange.MPEG
            track = None if sound is None else _SoundTrack(out, sound, "libopus" if web else "aac")
            film = _VideoFile(out, video, rate, track)
            yield film
            film.finish()
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def png_folder(path: Path) -> Iterator[FilmFile]:
    """Open a film of PNG pictures, PATH/000000.png and so on; the folder appears when it is whole.

    Raises:
        InputError: there is such a folder already, and it holds files.
    """
    if path.exists() and any(path.iterdir()):
        raise InputError(path, "holds files already", "give a new or an empty folder")
    part = path.with_name(f".{path.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    try:
        yield _PngFolder(part)
        if path.exists():
            path.rmdir()
        part.replace(path)
    finally:
        shutil.rmtree(part, ignore_errors=True)


class _PngFolder:
    """Numbered pictures."""

    def __init__(self, path: Path) -> None:
        self._path, self._count = path, 0

    def add(self, picture: npt.NDArray[np.uint8]) -> None:
        Image.fromarray(picture).save(self._path / f"{self._count:06d}.png")
        self._count += 1


class _SoundTrack:
    """Sound that is written as far as the pictures have come."""

    def __init__(self, out: av.container.OutputContainer, sound: npt.NDArray[np.float32], codec: str) -> None:
        layout = "mono" if len(sound) == 1 else "stereo"
        self._out, self._sound, self._layout, self._done = out, np.ascontiguousarray(sound), layout, 0
        stream = out.add_stream(codec, rate=SAMPLE_RATE, layout=layout)
        assert isinstance(stream, av.AudioStream)
        self._stream = stream
        self._fifo = av.AudioResampler(format=stream.format, layout=layout, rate=SAMPLE_RATE)

    def advance(self, seconds: float) -> None:
        """Write the sound up to a second of the film."""
        while self._done < min(self._sound.shape[1], seconds * SAMPLE_RATE):
            samples = np.ascontiguousarray(self._sound[:, self._done : self._done + _SOUND_FRAME])
            frame = av.AudioFrame.from_ndarray(samples, format="fltp", layout=self._layout)
            frame.sample_rate, frame.pts, frame.time_base = SAMPLE_RATE, self._done, Fraction(1, SAMPLE_RATE)
            self._done += samples.shape[1]
            for part in self._fifo.resample(frame):
                self._out.mux(self._stream.encode(part))

    def finish(self) -> None:
        self.advance(float("inf"))
        self._out.mux(self._stream.encode(None))


class _VideoFile:
    """Pictures of a video stream, with the sound beside them."""

    def __init__(
        self, out: av.container.OutputContainer, video: av.VideoStream, rate: Fraction, sound: _SoundTrack | None
    ) -> None:
        self._out, self._video, self._rate, self._sound, self._count = out, video, rate, sound, 0

    def add(self, picture: npt.NDArray[np.uint8]) -> None:
        assert self._video.pix_fmt is not None
        frame = av.VideoFrame.from_ndarray(picture, format="rgba" if picture.shape[2] == 4 else "rgb24")
        frame = frame.reformat(
            format=self._video.pix_fmt, dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.MPEG
        )
        frame.pts, frame.time_base = self._count, 1 / self._rate
        self._count += 1
        self._out.mux(self._video.encode(frame))
        if self._sound is not None:
            self._sound.advance(float(self._count / self._rate))

    def finish(self) -> None:
        self._out.mux(self._video.encode(None))
        if self._sound is not None:
            self._sound.finish()
