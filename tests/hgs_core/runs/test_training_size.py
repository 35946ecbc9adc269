"""The numbers that a training's cost grows with, of real captures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from PIL import Image

from hgs_core.capture.open import open_capture
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.training_size import SegmentSize, TrainingSize
from tests.conftest import REPOSITORY
from tests.synthetic import write_capture

STUDIO = REPOSITORY / "samples" / "studio"


def studio(**changes: object) -> TrainingSize:
    config = RunConfig.for_preset("preview", **{"capture.hold_out": ["cam00"], **changes})
    return TrainingSize.of(open_capture(STUDIO, downscale=config.capture.downscale), config)


def test_a_capture_is_counted_as_it_is_trained() -> None:
    size = studio()
    assert (size.cameras, size.training_cameras, size.frames) == (16, 15, 60)
    assert size.pixels == size.filmed_pixels == 512 * 384
    assert size.segments == (SegmentSize(60, 35_000, round(12_000 * 59 / 30)),)
    assert (size.iterations, size.moving_steps, size.straightened) == (3200, 1.0, 0.0)


def test_a_capture_that_is_not_open_has_the_size_of_the_open_one() -> None:
    config = RunConfig.for_preset("preview", **{"capture.hold_out": ["cam00"]})
    assert TrainingSize.announced(16, 60, 2.0, 512 * 384, config) == studio()


def test_a_reduced_picture_is_decoded_whole() -> None:
    size = studio(**{"capture.downscale": 2})
    assert (size.pixels, size.filmed_pixels) == (256 * 192, 512 * 384)


def test_a_long_capture_has_several_segments() -> None:
    size = studio(**{"train.segment_frames": 20})
    assert [one.frames for one in size.segments] == [20, 20, 20]


def test_given_masks_are_told(tmp_path: Path) -> None:
    write_capture(tmp_path / "capture")
    assert not TrainingSize.of(open_capture(tmp_path / "capture"), RunConfig()).masked
    for camera in range(5):
        (tmp_path / "masks" / str(camera)).mkdir(parents=True)
        for frame in range(6):
            Image.new("L", (64, 48)).save(tmp_path / "masks" / str(camera) / f"{frame:05d}.png")
    opened = open_capture(tmp_path / "capture", masks=tmp_path / "masks")
    assert TrainingSize.of(opened, RunConfig()).masked


def test_photographs_through_a_bent_lens_are_one_moment_and_straightened(tmp_path: Path) -> None:
    frames = []
    for number in range(3):
        Image.new("RGB", (64, 48), (number, 0, 0)).save(tmp_path / f"{number}.png")
        pose = np.eye(4)
        pose[0, 3] = number
        frames.append({"file_path": f"{number}.png", "transform_matrix": pose.tolist()})
    lens = {"w": 64, "h": 48, "fl_x": 50.0, "fl_y": 50.0, "cx": 32.0, "cy": 24.0, "k1": 0.1}
    (tmp_path / "transforms.json").write_text(json.dumps({**lens, "frames": frames}))
    size = TrainingSize.of(open_capture(tmp_path), RunConfig())
    assert (size.straightened, size.frames, size.moments) == (1.0, 1, 1)
    assert (size.moving_steps, size.first_dynamic, size.segments) == (0.0, 0, (SegmentSize(1, 80_000, 0),))
