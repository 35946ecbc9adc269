"""The sound of a film against the tone that the scene was given."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec import load_manifest
from hgs_core.codec.format.audio import CodedAudio
from hgs_core.codec.format.scene_folder import read_audio
from hgs_core.film.film_sound import SAMPLE_RATE, film_sound


@pytest.fixture
def audio(sounding_scene: Path) -> CodedAudio:
    found = read_audio(sounding_scene, load_manifest(sounding_scene))
    assert found is not None
    return found


@pytest.mark.parametrize("start", [0.0, 0.1, -0.5])
def test_a_tone_is_heard_at_its_time(audio: CodedAudio, start: float) -> None:
    sound = film_sound(audio, start, 1.0)
    assert sound.shape == (1, round((1.0 - start) * SAMPLE_RATE))
    loud = np.flatnonzero(np.abs(sound[0]) > 0.1) / SAMPLE_RATE + start
    assert loud[0] == pytest.approx(0.25, abs=0.01)
    assert loud[-1] == pytest.approx(0.75, abs=0.01)


def test_a_part_of_the_scene_has_the_same_samples(audio: CodedAudio) -> None:
    whole, part = film_sound(audio, 0.0, 1.0), film_sound(audio, 0.5, 0.7)
    np.testing.assert_array_equal(part, whole[:, SAMPLE_RATE // 2 : round(0.7 * SAMPLE_RATE)])


def test_a_damaged_piece_is_named(audio: CodedAudio) -> None:
    piece = audio.entry.pieces[0]
    with pytest.raises(InputError, match=f"sound {piece.id}"):
        film_sound(CodedAudio(audio.entry, dict.fromkeys(audio.chunks, b"no sound")), 0.0, 1.0)


def test_an_unknown_codec_is_refused(audio: CodedAudio) -> None:
    with pytest.raises(InputError, match=r"audio\.codec"):
        film_sound(CodedAudio(dataclasses.replace(audio.entry, codec="flac"), audio.chunks), 0.0, 1.0)
