"""Pieces are compared with PyAV's decoding of the whole file, which heeds its edit lists and its codecs' delays."""

from __future__ import annotations

import io
import itertools
from pathlib import Path

import av
import numpy as np
import numpy.typing as npt
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.sound.sound_pieces import SoundPiece, cut_sound
from hgs_core.capture.sound.sound_track import SOUND_RATE, read_sound, sound_begin
from tests.hgs_core.capture.sounding import write_sounding_video

CLICKS = (0.3, 0.9, 1.4, 2.2, 2.9, 3.3)  # seconds


def clicking() -> npt.NDArray[np.float32]:
    """Four seconds with bursts of noise."""
    sound = np.zeros(4 * SOUND_RATE, np.float32)
    for number, time in enumerate(CLICKS):
        place = round(time * SOUND_RATE)
        sound[place : place + 64] = np.random.default_rng(number).normal(size=64) * 0.3
    return sound


def decoded(data: bytes, rate: int = SOUND_RATE) -> npt.NDArray[np.float32]:
    """The decoded sound of a file, mono."""
    with av.open(io.BytesIO(data)) as container:
        resampler = av.AudioResampler(format="flt", layout="mono", rate=rate)
        frames = [part for frame in container.decode(audio=0) for part in resampler.resample(frame)]
        return np.concatenate([part.to_ndarray().reshape(-1) for part in (*frames, *resampler.resample(None))])


def heard(piece: SoundPiece) -> npt.NDArray[np.float32]:
    return decoded(piece.data)[-round((piece.end - piece.start) * SOUND_RATE) :]


@pytest.mark.parametrize(
    ("ending", "codec", "kept"),
    [("mp4", "aac", "aac"), ("ts", "aac", "aac"), ("mkv", "libopus", "opus"), ("mov", "pcm_s16le", "opus")],
)
def test_every_piece_sounds_as_the_file_does_at_its_time(tmp_path: Path, ending: str, codec: str, kept: str) -> None:
    file = write_sounding_video(tmp_path / f"a.{ending}", 120, clicking(), codec=codec)
    truth = read_sound(file)
    assert truth is not None
    cut = cut_sound(file, 10.5, 13.5, offset=10.0 - sound_begin(file))
    assert cut is not None
    assert (cut.codec, cut.encoded_from) == (kept, "" if codec in ("aac", "libopus") else codec)
    pieces = cut.pieces
    assert all(a.end == pytest.approx(b.start, abs=1e-3) for a, b in itertools.pairwise(pieces))
    assert 10.4 < pieces[0].start <= 10.5
    assert 13.5 <= pieces[-1].end < 13.6
    for piece in pieces:
        own, at = heard(piece), round((piece.start - 10.0) * SOUND_RATE)
        likeness = {lag: np.dot(own, truth[at + lag : at + lag + len(own)]) for lag in range(-100, 101)}
        lag = max(likeness, key=lambda lag: likeness[lag])
        assert abs(lag) <= 16  # a millisecond
        same = truth[at + lag : at + lag + len(own)]
        assert likeness[lag] > 0.8 * np.linalg.norm(own) * np.linalg.norm(same)


def test_pieces_join_without_a_step(tmp_path: Path) -> None:
    """A tone obeys x[i + 1] + x[i - 1] = 2 cos(w) x[i]; a seam that missed a single sample would break that by 0.06."""
    tone = (0.5 * np.sin(2 * np.pi * 1000 * np.arange(4 * SOUND_RATE) / SOUND_RATE)).astype(np.float32)
    cut = cut_sound(write_sounding_video(tmp_path / "a.mkv", 120, tone, codec="libopus"), 0.0, 3.9)
    assert cut is not None
    joined = np.concatenate(
        [decoded(piece.data, 48_000)[-round((piece.end - piece.start) * 48_000) :] for piece in cut.pieces]
    )
    broken = np.abs(joined[2:] + joined[:-2] - 2 * np.cos(2 * np.pi * 1000 / 48_000) * joined[1:-1])
    seams = np.cumsum([round((piece.end - piece.start) * 48_000) for piece in cut.pieces])[:-1]
    assert len(seams) == 3
    assert max(broken[seam - 3 : seam + 3].max() for seam in seams) < 0.01


def test_pieces_last_about_a_second_and_are_the_same_each_time(tmp_path: Path) -> None:
    file = write_sounding_video(tmp_path / "a.mov", 120, clicking())
    cut = cut_sound(file, 0.0, 3.3)
    assert cut is not None
    assert [round(piece.end - piece.start, 1) for piece in cut.pieces] == [1.0, 1.0, 1.3]
    assert cut_sound(file, 0.0, 3.3) == cut


def test_a_stretch_or_a_file_without_sound_has_none(tmp_path: Path) -> None:
    assert cut_sound(write_sounding_video(tmp_path / "a.mp4", 9, None), 0.0, 1.0) is None
    assert cut_sound(write_sounding_video(tmp_path / "b.mp4", 30, clicking(), codec="aac"), 20.0, 30.0) is None


def test_a_damaged_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "c.mp4").write_bytes(b"no sound")
    with pytest.raises(InputError, match=r"c\.mp4.*the sound is unreadable.*--audio none"):
        cut_sound(tmp_path / "c.mp4", 0.0, 1.0)
