from __future__ import annotations

import pytest

from hgs_core.runs.sound_choice import camera_of_sound


@pytest.mark.parametrize(
    ("audio", "name"), [("camera:cam01", "cam01"), ("camera:", ""), ("auto", None), ("none", None), ("a.wav", None)]
)
def test_the_camera_whose_sound_is_asked_for_is_named_behind_a_colon(audio: str, name: str | None) -> None:
    assert camera_of_sound(audio) == name
