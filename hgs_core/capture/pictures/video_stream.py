"""The video among the streams of a file: cameras and phones store thumbnails, covers and proxies beside it."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from hgs_core.base.errors import InputError
from hgs_core.capture.files.container import is_bare, open_container
from hgs_core.capture.files.encoding_again import encode_again

if TYPE_CHECKING:
    from av.container import InputContainer
    from av.video.stream import VideoStream

__all__ = ["even_rate", "stated_rate", "video_stream"]

_LONG = 0.2  # share of the longest stream's packets; a stream with more is a video, too
_ROUNDED = Fraction(1, 2)  # frames by which rounded stamps may shift a whole video


def video_stream(path: Path, container: InputContainer) -> tuple[VideoStream | None, str]:
    """Return the only long stream of pictures in an open file, and notes on others; None: there is none.

    Raises:
        InputError: two streams or more are long.
    """
    from av.stream import Disposition

    apart = Disposition.attached_pic | Disposition.timed_thumbnails
    streams = [stream for stream in container.streams.video if not stream.disposition & apart]
    if len(streams) < 2:
        return (streams[0] if streams else None), ""
    indices = [stream.index for stream in streams]
    with open_container(path) as whole:
        counts = Counter(packet.stream.index for packet in whole.demux(indices) if packet.size)
    longest = max(streams, key=lambda s: (counts[s.index], s.codec_context.width * s.codec_context.height))
    if sum(counts[index] >= _LONG * counts[longest.index] for index in indices) > 1:
        sizes = ", ".join(
            f"0:{s.index} of {s.codec_context.width}x{s.codec_context.height}, {counts[s.index]} frames"
            for s in streams
        )
        command = encode_again(path, writing=f"-map 0:{longest.index} -c copy")
        problem = f"the file has {len(streams)} video streams, and nothing says which is the camera's: {sizes}"
        raise InputError(path, problem, f"keep one of them: {command}")
    size = f"{longest.codec_context.width}x{longest.codec_context.height}"
    said = f"of its {len(streams)} video streams the longest is read: {size}, {counts[longest.index]} frames"
    return longest, said


def stated_rate(container: InputContainer, stream: VideoStream) -> Fraction:
    """Return the frames per second that a file states, in its container or else in its stream; 0 if it does not."""
    rates = (stream.codec_context.framerate,) if is_bare(container) else (stream.average_rate, stream.guessed_rate)
    return next((Fraction(rate) for rate in rates if rate), Fraction(0))


def even_rate(stream: VideoStream) -> Fraction | None:
    """Return the rate, frames per second, at which all stamps of a stream lie up to their rounding; None: at no rate.

    The mean rate of a short video is off by percents where stamps are rounded, for its header counts the last frame's
    time as it likes.
    """
    mean, even = stream.average_rate, stream.base_rate
    if mean and even and stream.frames and abs(mean / even - 1) * stream.frames < _ROUNDED:
        return Fraction(even)
    return None
