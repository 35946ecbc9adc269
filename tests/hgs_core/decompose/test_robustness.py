"""Automatic masks of a sample camera with a degraded video, against the renderer's object masks.

Shadows and reflections move but are not in the truth: recall is what counts, and that little else is marked.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.capture.open import open_capture
from hgs_core.decompose.background import estimate_background, moving_pixels
from scripts.measure_masks import DEGRADATIONS, scores

ROWS = slice(100, 384)  # the part of the picture with the man, the bowl and the turntable: half the work


@pytest.fixture(scope="module")
def sample() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One camera's video, the frames with truth, and the truth."""
    capture = open_capture(Path(__file__).resolve().parents[3] / "samples" / "studio")
    with np.load(Path(__file__).parent / "studio_truth.npz") as file:
        truth = np.unpackbits(file["bits"], count=int(file["shape"].prod())).reshape(file["shape"]).astype(bool)
        camera, frames = int(file["cameras"][0]), file["frames"]
    return np.stack([capture.frame(camera, f)[ROWS] for f in range(60)]), frames, truth[0][:, ROWS]


@pytest.mark.parametrize(
    ("name", "recall", "marked"),
    [
        ("as it is", 0.92, 0.22),
        ("noise, sigma 5", 0.86, 0.22),
        ("noise, sigma 10", 0.75, 0.22),
        ("exposure flicker of 5 %", 0.92, 0.22),
        ("flicker and noise, sigma 5", 0.86, 0.22),
        ("soft moving shadow", 0.92, 0.40),  # the shadow is marked, as it should be
        ("H.264, crf 38", 0.88, 0.24),
    ],
)
def test_what_moves_is_found_all_the_same(
    sample: tuple[np.ndarray, np.ndarray, np.ndarray], name: str, recall: float, marked: float
) -> None:
    video, frames, truth = sample
    worse = DEGRADATIONS[name](video)
    background = estimate_background(lambda frame: worse[frame], len(worse))
    found = np.stack([moving_pixels(worse[frame], background) for frame in frames])
    result = scores(found, truth)
    assert result[1] > recall, (result, found.mean())
    assert found.mean() < marked, (result, found.mean())
