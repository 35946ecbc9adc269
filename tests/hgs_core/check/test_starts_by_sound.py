"""Synthesised tracks: the sounds of one scene, begun at known times, with other gains, noise and rooms."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from hgs_core.capture.sound.sound_track import SOUND_RATE
from hgs_core.check.starts_by_sound import sound_starts

Track = npt.NDArray[np.float32]
LENGTH = 8  # seconds of a track


def scene(seed: int) -> npt.NDArray[np.float64]:
    """Twelve seconds with two dozen sounds of sudden beginnings."""
    random = np.random.default_rng(seed)
    sound = np.zeros(12 * SOUND_RATE)
    for _ in range(24):
        begin, length = int(random.integers(0, len(sound) - 4000)), 4000
        fade = np.exp(-np.arange(length) / random.uniform(100, 900))
        sound[begin : begin + length] += fade * random.standard_normal(length) * random.uniform(0.2, 1)
    return sound


def heard(
    sound: npt.NDArray[np.float64], start: float, *, gain: float = 1.0, noise: float = 0.0, echo: int | None = None
) -> Track:
    """Return the sound of a camera that begins at `start`, to parts of a sample; `echo` is the seed of a room."""
    random = np.random.default_rng(round(1e6 * start))
    if echo is not None:
        room = np.zeros(4800)
        walls = np.random.default_rng(echo).integers(200, 4800, 60)
        room[walls] = np.random.default_rng(echo).standard_normal(60) * 0.5 * np.exp(-walls / 2000)
        room[0] = 1.0
        sound = np.convolve(sound, room)[: len(sound)]
    frequencies = np.fft.rfftfreq(len(sound), 1 / SOUND_RATE)
    moved = np.fft.irfft(np.fft.rfft(sound) * np.exp(2j * np.pi * frequencies * start), len(sound))
    track = moved[: LENGTH * SOUND_RATE] + noise * np.std(sound) * random.standard_normal(LENGTH * SOUND_RATE)
    return (gain * track).astype(np.float32)


@pytest.mark.parametrize("seed", [0, 1])
def test_starts_are_told_to_a_tenth_of_a_millisecond_whatever_gain_noise_and_room(seed: int) -> None:
    true = [0.0, 1.23456, 0.01667, 2.5]
    tracks = [
        heard(scene(seed), true[0]),
        heard(scene(seed), true[1], gain=0.02, noise=0.5),
        heard(scene(seed), true[2], noise=1.0, echo=seed),
        heard(scene(seed), true[3], gain=0.3, noise=0.1, echo=seed + 9),
    ]
    found = sound_starts(tracks)
    assert [one is not None for one in found.cameras] == [True] * 4
    np.testing.assert_allclose([one.seconds for one in found.cameras if one], true, atol=1e-4)
    assert all(one.confidence > 0.5 and one.partners == 3 for one in found.cameras if one)
    assert found.disagreeing == ()


def test_a_camera_without_track_a_silent_one_and_one_elsewhere_are_not_told() -> None:
    silent = np.zeros(LENGTH * SOUND_RATE, np.float32)
    sound = scene(2)
    found = sound_starts([heard(sound, 0.0), None, silent, heard(sound, 0.7), heard(scene(3), 0.0)])
    assert [one is not None for one in found.cameras] == [True, False, False, True, False]


def test_of_noise_and_of_a_metronome_nothing_is_told() -> None:
    random = np.random.default_rng(0)
    noises = [random.standard_normal(LENGTH * SOUND_RATE).astype(np.float32) for _ in range(3)]
    assert sound_starts(noises).cameras == (None, None, None)
    ticks = np.zeros(12 * SOUND_RATE)
    for begin in range(0, len(ticks), SOUND_RATE // 2):
        ticks[begin : begin + 400] = random.standard_normal(400)
    assert sound_starts([heard(ticks, start) for start in (0.0, 0.3, 1.1)]).cameras == (None, None, None)


def test_tracks_that_contradict_each_other_around_a_triangle_are_named() -> None:
    """The first hears one source, the second another that is 80 ms late by cable, the others both."""
    stage, cable = scene(7), scene(8)

    def mixed(cable_late: float, first: float, second: float) -> Track:
        return (first * heard(stage, 0.0) + second * heard(cable, cable_late)).astype(np.float32)

    found = sound_starts([mixed(0, 1, 0.05), mixed(0.08, 0.05, 1), mixed(0, 0.7, 0.7), mixed(0.08, 0.7, 0.7)])
    assert found.disagreeing


def test_a_track_of_two_takes_is_not_believed() -> None:
    sound = scene(7)
    two_takes = np.concatenate([heard(sound, 0.2)[: 4 * SOUND_RATE], heard(sound, 3.5)[: 4 * SOUND_RATE]])
    found = sound_starts([heard(sound, 0.0), heard(sound, 0.4), heard(sound, 0.8), two_takes])
    assert found.cameras[3] is None or 3 in found.disagreeing
    assert all(found.cameras[:3])
