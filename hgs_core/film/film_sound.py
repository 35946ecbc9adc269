"""The sound of a scene as one stretch of samples for a film."""

from __future__ import annotations

import av
import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.files.container import open_sound_piece
from hgs_core.codec.format.audio import AudioPiece, CodedAudio

__all__ = ["SAMPLE_RATE", "film_sound"]

SAMPLE_RATE = 48_000
"""Samples per second of a film's sound."""

_CONTAINERS = {"opus": "ogg", "aac": "aac"}  # docs/format.md, "Sound"
_LAYOUTS = {1: "mono", 2: "stereo"}


def film_sound(audio: CodedAudio, start: float, end: float) -> npt.NDArray[np.float32]:
    """Return the sound [channels, samples] of a stretch of the scene's clock, in [-1, 1]; silence where there is none.

    Args:
        audio: the scene's sound; more than two channels are mixed to two.
        start: seconds of the scene's clock.
        end: seconds.

    Raises:
        InputError: a codec that the format does not have, or a piece that cannot be decoded.
    """
    entry = audio.entry
    if entry.codec not in _CONTAINERS:
        raise InputError("audio.codec", f"is {entry.codec!r}, expected {' or '.join(_CONTAINERS)}")
    channels = min(2, entry.channels)
    sound = np.zeros((channels, max(0, round((end - start) * SAMPLE_RATE))), np.float32)
    for piece in entry.pieces:
        if piece.end > start and piece.start < end:
            _place(sound, _decoded(audio.chunks[piece.id], piece, entry.codec, channels), piece, start)
    return sound


def _place(sound: npt.NDArray[np.float32], samples: npt.NDArray[np.float32], piece: AudioPiece, start: float) -> None:
    """Put a piece's samples in their place; they count from its end, and none lies before its start."""
    last = round((piece.end - start) * SAMPLE_RATE)
    length = min(samples.shape[1], round((piece.end - piece.start) * SAMPLE_RATE))
    first = last - length
    begin, end = max(0, first), min(sound.shape[1], last)
    if begin < end:
        from_first = samples.shape[1] - length + (begin - first)
        sound[:, begin:end] = samples[:, from_first : from_first + end - begin]


def _decoded(data: bytes, piece: AudioPiece, codec: str, channels: int) -> npt.NDArray[np.float32]:
    """Return the samples [channels, N] of a piece's file."""
    resampler = av.AudioResampler(format="fltp", layout=_LAYOUTS[channels], rate=SAMPLE_RATE)
    parts = []
    try:
        with open_sound_piece(data, _CONTAINERS[codec]) as container:
            for frame in container.decode(audio=0):
                frame.pts = None  # the resampler would fill what the codec's delay leaves out
                parts += [part.to_ndarray() for part in resampler.resample(frame)]
        parts += [part.to_ndarray() for part in resampler.resample(None)]
    except (av.FFmpegError, IndexError) as error:
        raise InputError(f"sound {piece.id}", f"cannot be decoded ({error})", "encode the scene again") from error
    return np.concatenate(parts, axis=1) if parts else np.zeros((channels, 0), np.float32)
