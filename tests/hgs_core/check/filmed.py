"""Pictures of five fixed cameras that see a bar move, and ways in which a camera dies."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from hgs_core.check.picture_changes import Picture

SIZE = (96, 128)
CAMERAS = 5

Film = list[np.ndarray]
Fault = Callable[[Film], Film]


def films(frames: int, noise: float = 0.0) -> list[Film]:
    """A bar that moves inside of each camera's picture, before its own wall."""
    numbers = np.random.default_rng(3)
    places = 10 + 23 * np.arange(frames) % 61  # never twice nearby
    walls = numbers.integers(40, 160, (CAMERAS, *SIZE)).astype(float)
    return [
        [_picture(walls[camera], place + 6 * camera, noise, numbers) for place in places] for camera in range(CAMERAS)
    ]


def _picture(wall: np.ndarray, place: float, noise: float, numbers: np.random.Generator) -> np.ndarray:
    grey = wall.copy()
    grey[30:70, int(place) : int(place) + 14] = 230
    grey += numbers.normal(0, noise, SIZE) if noise else 0
    return np.repeat(grey.clip(0, 255).astype(np.uint8)[..., None], 3, axis=2)


def pictures(all_of: Sequence[Film]) -> list[Picture]:
    return [film.__getitem__ for film in all_of]


def frozen(first: int, last: int) -> Fault:
    return lambda film: film[:first] + [film[first]] * (last - first + 1) + film[last + 1 :]


def blank(first: int, last: int, level: int) -> Fault:
    flat = np.full((*SIZE, 3), level, np.uint8)
    return lambda film: film[:first] + [flat] * (last - first + 1) + film[last + 1 :]


def every(step: int) -> Fault:
    return lambda film: [film[frame - frame % step] for frame in range(len(film))]
