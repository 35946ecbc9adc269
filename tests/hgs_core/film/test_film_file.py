"""Files of films, read back."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.film.film_file import film_file, png_folder
from hgs_core.film.film_sound import SAMPLE_RATE

RATE = Fraction(30000, 1001)
SQUARE = np.full((48, 64, 4), (220, 40, 30, 255), np.uint8)
SQUARE[:, :32, 3] = 0


@pytest.mark.parametrize("suffix", [".mp4", ".webm"])
def test_colours_times_and_sound_are_kept(suffix: str, tmp_path: Path) -> None:
    tone = np.sin(2 * np.pi * 440 * np.arange(SAMPLE_RATE // 2) / SAMPLE_RATE, dtype=np.float32)[None] / 2
    with film_file(tmp_path / f"x{suffix}", (64, 48), RATE, tone, alpha=False) as film:
        for _ in range(15):
            film.add(SQUARE[..., :3].copy())
    with av.open(str(tmp_path / f"x{suffix}")) as file:
        video, sound = file.streams.video[0], file.streams.audio[0]
        assert abs(float(video.average_rate or 0) - float(RATE)) < 0.01
        assert video.codec_context.colorspace == 1  # BT.709
        pictures = [frame.to_ndarray(format="rgb24") for frame in file.decode(video)]
        file.seek(0)
        heard = sum(frame.samples / frame.sample_rate for frame in file.decode(sound))
    assert len(pictures) == 15
    assert np.abs(pictures[7].astype(int) - SQUARE[..., :3]).max() <= 6
    assert heard == pytest.approx(0.5, abs=0.06)


@pytest.mark.parametrize(("name", "form"), [("new/folder/x.WEBM", "webm"), ("X.MP4", "mp4")])
def test_a_film_is_what_its_suffix_says_in_capitals_too_and_makes_its_folder(
    name: str, form: str, tmp_path: Path
) -> None:
    with film_file(tmp_path / name, (64, 48), RATE, None, alpha=False) as film:
        film.add(SQUARE[..., :3].copy())
    with av.open(str(tmp_path / name)) as file:
        assert form in file.format.name.split(",")


def test_webm_keeps_alpha(tmp_path: Path) -> None:
    with film_file(tmp_path / "x.webm", (64, 48), RATE, None, alpha=True) as film:
        film.add(SQUARE)
    with av.open(str(tmp_path / "x.webm")) as file:
        decoder = av.CodecContext.create("libvpx-vp9", "r")  # FFmpeg's own decoder leaves alpha out
        packets = [packet for packet in file.demux(video=0) if packet.size]
        frames = [frame for packet in packets for frame in decoder.decode(packet)]
    assert isinstance(frames[0], av.VideoFrame)
    alpha = frames[0].to_ndarray(format="rgba")[..., 3]
    assert alpha[:, :24].max() < 16
    assert alpha[:, 40:].min() > 240


@pytest.mark.parametrize("pictures", [True, False])
def test_a_film_that_fails_leaves_nothing(pictures: bool, tmp_path: Path) -> None:
    video = film_file(tmp_path / "x.mp4", (64, 48), RATE, None, alpha=False)

    def fail() -> None:
        with png_folder(tmp_path / "x") if pictures else video as film:
            film.add(SQUARE[..., :3].copy())
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        fail()
    assert list(tmp_path.iterdir()) == []


def test_pictures_of_a_folder_are_exact(tmp_path: Path) -> None:
    with png_folder(tmp_path / "frames") as film:
        film.add(SQUARE)
        film.add(SQUARE)
    assert sorted(path.name for path in (tmp_path / "frames").iterdir()) == ["000000.png", "000001.png"]
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "frames" / "000001.png")), SQUARE)


def test_pictures_go_into_an_empty_folder(tmp_path: Path) -> None:
    with png_folder(tmp_path) as film:
        film.add(SQUARE)
    assert [path.name for path in tmp_path.iterdir()] == ["000000.png"]


def test_a_folder_that_holds_files_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("x")
    with pytest.raises(InputError, match="holds files already"), png_folder(tmp_path):
        pass
