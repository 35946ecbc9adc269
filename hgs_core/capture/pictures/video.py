"""Frames of one video file by number, decoded with PyAV (FFmpeg)."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.files.container import open_container
from hgs_core.capture.files.encoding_again import encode_again
from hgs_core.capture.files.unreadable import unreadable
from hgs_core.capture.pictures.frame_display import opacity
from hgs_core.capture.pictures.picture_cache import Neighbour
from hgs_core.capture.pictures.video_index import indexed_packets

if TYPE_CHECKING:
    import av
    from av.container import InputContainer
    from av.video.stream import VideoStream

__all__ = ["VideoReader"]


class VideoReader:
    """Random access to the frames of a video.

    The decoder stays open until the last frame, and runs forward while that is the shortest way to the next frame asked
    for; otherwise it seeks to the key frame before it. Pictures are upright, as players show them: turned as the file's
    display matrix says, and `width` and `height` are theirs. Wide colours and high dynamic range are brought to BT.709.
    Not safe for several threads at once.
    """

    def __init__(self, path: Path, *, square: bool = False, index: Path | None = None) -> None:
        """Read the packets' time stamps, and the display that the first frame states.

        With `square` the pictures have square pixels, as players show them. `index` is a folder that keeps the stamps.

        Raises:
            InputError: the file is missing, no video, truncated, its frames cannot be told apart, or are to be shown
                mirrored or tilted.
        """
        from av.video.reformatter import VideoReformatter

        self.path = path
        self._packets = packets = indexed_packets(path, index)
        self.files = [(path, path.stat().st_size)]
        self.notes = list(packets.notes)  # choices, for people; the packets are other readers' too
        self.rate, self.timecode, self.interlaced = packets.rate, packets.timecode, packets.interlaced
        self._container: InputContainer | None = None
        self._frames: Iterator[av.VideoFrame] | None = None
        self._next = 0  # the frame that the open decoder will give next
        self._reformatter = VideoReformatter()
        assert packets.display is not None
        self._display = packets.display
        if self._display.turns is None:
            cure = f"store it as it should look: {encode_again(path)}"
            raise InputError(path, "the video is to be shown mirrored or tilted", cure)
        self._turns = self._display.turns
        self.wide_colours = self._display.wide_colours
        if self._display.seen_through:
            self.notes.append("what is transparent in the video is black")
        self._stored = packets.size  # width and height that frames are brought to before they are turned
        self.width, self.height = self._turned(packets.size)
        if square and self.square_size != (self.width, self.height):
            self.show_square()

    @property
    def square_size(self) -> tuple[int, int]:
        """Width and height with square pixels, as players show it; none are lost."""
        width, height = self._packets.size
        aspect = self._packets.aspect
        wide = (round(width * aspect), height) if aspect >= 1 else (width, round(height / aspect))
        return self._turned(wide)

    def show_square(self) -> None:
        """Stretch pictures from now on, so that their pixels are square."""
        self.width, self.height = self.square_size
        self._stored = self._turned(self.square_size)
        self.notes.append(f"pixels of {self._packets.aspect} are stretched to {self.width}x{self.height} square ones")

    def _turned(self, size: tuple[int, int]) -> tuple[int, int]:
        return (size[1], size[0]) if self._turns % 2 else size

    @cached_property
    def seconds(self) -> npt.NDArray[np.float64]:
        """The time stamps of the frames [N], seconds; exact multiples of the period where they are rounded ones."""
        numerator, denominator = self._packets.tick.as_integer_ratio()
        stamps = np.array([stamp * numerator / denominator for stamp in self._packets.stamps])
        even = stamps[0] + np.arange(len(stamps)) / float(self.rate)
        return even if np.abs(stamps - even).max() <= self.resolution else stamps

    @property
    def frame_rate(self) -> float:
        """Frames per second: as the file states it, unless its time stamps say otherwise; then their mean."""
        seconds = self.seconds
        if len(seconds) < 2 or abs((seconds[-1] - seconds[0]) * float(self.rate) - len(seconds) + 1) < 0.5:
            return float(self.rate)
        return (len(seconds) - 1) / float(seconds[-1] - seconds[0])

    @property
    def resolution(self) -> float:
        """The unit of the file's time stamps, seconds."""
        return float(self._packets.tick)

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self._packets.stamps)

    def read(self, index: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], list[Neighbour]]:
        """Return frame `index` [H, W, 3], and the last `neighbours` frames that were decoded on the way to it.

        Raises:
            InputError: the video is damaged.
        """
        frame, passed = self._found(index, neighbours)
        return self._picture(frame), passed

    def _found(self, index: int, neighbours: int) -> tuple[av.VideoFrame, list[Neighbour]]:
        key = self._packets.stamps.index(
            self._packets.keys[max(0, bisect_right(self._packets.keys, self._packets.stamps[index]) - 1)]
        )
        for start in dict.fromkeys((key, 0)):  # FFmpeg may seek too far, without an index, in MPEG-PS
            found = self._decoded(index, start, neighbours)
            if found is not None:
                return found
            self._close()
        raise InputError(self.path, f"frame {index} cannot be decoded", "export the camera's video again")

    def lines(self, index: int) -> npt.NDArray[np.uint8]:
        """Return the brightness of frame `index` [H, W] as stored: neither turned nor stretched.

        Raises:
            InputError: the video is damaged.
        """
        frame, _ = self._found(index, 0)
        plain = self._reformatter.reformat(frame, *self._packets.size, "gray", threads=1)
        return np.asarray(plain.to_ndarray(), np.uint8)

    def _decoded(self, index: int, key: int, neighbours: int) -> tuple[av.VideoFrame, list[Neighbour]] | None:
        """Return frame `index` as `read` does, decoded from where the decoder is or from `key`; None: it did not come.

        Raises:
            InputError: the video is damaged.
        """
        import av

        passed: list[Neighbour] = []
        try:
            # Frames that the caller keeps on the way are worth decoding, even where a key frame would skip them.
            if self._frames is None or self._next > index or key - self._next > neighbours:
                self._seek(key)
            start = self._next
            assert self._frames is not None
            for frame in self._frames:
                shown = self._index(frame)
                if shown is None or shown < start:
                    continue  # a leading frame after a seek may refer to pictures before the key frame
                if frame.is_corrupt:
                    raise InputError(self.path, f"frame {shown} is damaged", "export the camera's video again")
                self._next = shown + 1
                if shown == index:
                    if index == len(self._packets.stamps) - 1:
                        self._close()  # the open decoders of a large rig are half a gigabyte
                    return frame, passed
                if shown > index:
                    break
                if index - shown <= neighbours:
                    passed.append((shown, self._picture(frame)))
        except (av.FFmpegError, OSError) as error:
            self._close()
            raise self._unreadable(error, index) from error
        return None

    def _seek(self, key: int) -> None:
        if self._packets.counted or key == 0:
            self._close()
        if self._container is None:
            self._container = open_container(self.path)
            context = self._video(self._container).codec_context
            context.thread_count = 1  # frame threads would hold several pictures for each of many cameras
            context.options = {"err_detect": "explode"}  # damage is an error, never a guessed picture
        stream = self._video(self._container)
        if not self._packets.counted and key > 0:
            self._container.seek(self._packets.stamps[key], stream=stream, backward=True)
        self._frames = self._container.decode(stream)
        self._next = key

    def _video(self, container: InputContainer) -> VideoStream:
        stream = container.streams[self._packets.stream]
        assert stream.type == "video"
        return cast("VideoStream", stream)

    def _close(self) -> None:
        if self._container is not None:
            self._container.close()
        self._container = self._frames = None

    def _index(self, frame: av.VideoFrame) -> int | None:
        """Return the number of a decoded frame."""
        if self._packets.counted:
            return self._next
        if frame.pts is None:
            return None
        index = bisect_left(self._packets.stamps, frame.pts)
        return index if index < len(self._packets.stamps) and self._packets.stamps[index] == frame.pts else None

    def _picture(self, frame: av.VideoFrame) -> npt.NDArray[np.uint8]:
        from av.video.reformatter import ColorPrimaries, Colorspace, Interpolation

        # Without these flags chroma of half resolution is repeated instead of interpolated, and sums are cut off.
        best = Interpolation.BICUBIC | Interpolation.FULL_CHR_H_INT | Interpolation.FULL_CHR_H_INP
        best |= Interpolation.ACCURATE_RND
        width, height = self._stored
        if self.wide_colours is not None:
            matrix = Colorspace.BT2020 if self.wide_colours.primaries == ColorPrimaries.BT2020 else None
            deep = self._reformatter.reformat(
                frame,
                width=width,
                height=height,
                format="rgb48le",
                interpolation=best,
                threads=1,
                src_colorspace=matrix,
            )
            picture = self.wide_colours.shown(np.asarray(deep.to_ndarray(), np.uint16))
        else:
            plain = self._reformatter.reformat(frame, width, height, "rgb24", interpolation=best, threads=1)
            picture = np.asarray(plain.to_ndarray(), np.uint8)
        if self._display.transparent:
            shown = opacity(frame, self._stored, self._reformatter)
            picture = ((picture.astype(np.uint16) * shown + 127) // 255).astype(np.uint8)
        return np.ascontiguousarray(np.rot90(picture, self._turns))

    def _unreadable(self, error: Exception, index: int | None = None) -> InputError:
        what = "the video" if index is None else f"frame {index}"
        return unreadable(self.path, error, "copy or export the camera's video again", f"{what} is unreadable")
