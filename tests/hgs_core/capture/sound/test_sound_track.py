from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.sound.sound_track import SOUND_RATE, read_sound
from tests.hgs_core.capture.sounding import write_sounding_video


@pytest.mark.parametrize(("ending", "codec"), [("mkv", "pcm_s16le"), ("mp4", "aac"), ("mov", "pcm_s16le")])
def test_a_click_is_where_it_was_after_the_first_frame(tmp_path: Path, ending: str, codec: str) -> None:
    click = np.zeros(2 * SOUND_RATE, np.float32)
    click[SOUND_RATE : SOUND_RATE + 40] = 0.9
    sound = read_sound(write_sounding_video(tmp_path / f"a.{ending}", 60, click, codec=codec))
    assert sound is not None
    assert abs(int(np.abs(sound).argmax()) - SOUND_RATE - 20) < 40


def test_a_video_without_sound_has_none_and_a_damaged_file_is_named(tmp_path: Path) -> None:
    assert read_sound(write_sounding_video(tmp_path / "a.mp4", 5, None)) is None
    (tmp_path / "b.mp4").write_bytes(b"no video")
    with pytest.raises(InputError, match=r"b\.mp4.*the sound is unreadable"):
        read_sound(tmp_path / "b.mp4")
