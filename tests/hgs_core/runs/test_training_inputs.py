"""The inputs of a training, from the folder of its run."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.runs.creation import create_run
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.runs.stages import initialise
from hgs_core.runs.training_inputs import masks_of_run, segment_starts, training_inputs
from hgs_core.train.segment_cuts import cut_into_segments
from tests.synthetic import write_capture

CONFIG = RunConfig.from_json(
    {
        "capture": {"hold_out": ["2"]},
        "points": {"static": 200, "dynamic": 40, "interval": 0.1},
        "train": {"segment_frames": 2},
    }
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    path = tmp_path_factory.mktemp("inputs")
    write_capture(path / "capture")
    create_run(path / "run", path / "capture", CONFIG)
    initialise(path / "run", silent)
    return RunFolder(path / "run")


def test_segments_start_where_training_cuts(folder: RunFolder) -> None:
    assert segment_starts(folder.read_spec().open_capture(), CONFIG) == [0, 2, 4]


def test_masks_are_those_of_the_training_cameras(folder: RunFolder) -> None:
    masks = masks_of_run(folder, folder.read_spec().open_capture(), CONFIG)
    assert masks.cameras == (0, 1, 3, 4)
    assert all(masks.mask(1, frame).shape == (48, 64) for frame in range(6))


def test_near_planes_leave_out_what_is_before_the_scene(folder: RunFolder) -> None:
    inputs = training_inputs(folder, folder.read_spec().open_capture(), CONFIG)
    assert list(inputs.cameras) == [0, 1, 3, 4]
    first = cut_into_segments(inputs.capture.times, 2)[0]
    depths = {i: camera.project(inputs.points(first).xyz)[1] for i, camera in inputs.cameras.items()}
    for i, camera in inputs.cameras.items():
        assert 0.01 < camera.near < np.median(depths[i])


def test_a_segment_has_the_points_of_its_own_file_alone(folder: RunFolder, tmp_path: Path) -> None:
    run = RunFolder(shutil.copytree(folder.path, tmp_path / "run"))
    inputs = training_inputs(run, run.read_spec().open_capture(), CONFIG)
    for other in (0, 2):
        (run.points / f"{other}.npz").unlink()
    first, second, _ = cut_into_segments(inputs.capture.times, 2)
    assert len(inputs.points(second)) >= 200
    with pytest.raises(InputError, match=r"points/0\.npz"):
        inputs.points(first)
