"""Training a whole capture in segments."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.progress import Progress, StageStopped, silent
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.train.capture_training import TrainingInputs, train_capture
from hgs_core.train.checkpoint import load_state
from hgs_core.train.train_config import DensityConfig, TrainConfig
from tests.hgs_core.train.test_trainer import points
from tests.synthetic import write_capture

CONFIG = TrainConfig(
    iterations=30,
    checkpoint_every=10,
    segment_frames=3,
    density=DensityConfig(every=10, max_static=400, max_dynamic=100, birth_rounds=0),
)


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    path = tmp_path_factory.mktemp("capture")
    write_capture(path)  # six frames: two segments of three
    return open_capture(path)


def inputs(capture: Capture, config: TrainConfig = CONFIG) -> TrainingInputs:
    return TrainingInputs(capture, dict(enumerate(capture.cameras)), config, 0, points(), 1)


def test_segments_share_the_statics_and_follow_each_other(capture: Capture, tmp_path: Path) -> None:
    heard: list[Progress] = []
    scene, summary = train_capture(inputs(capture), lambda i: tmp_path / f"{i}.pt", heard.append)
    assert [(s.start, s.end) for s in scene.segments] == [
        (capture.times[0], capture.times[3]),
        (capture.times[3], capture.times[5]),
    ]
    assert summary["iterations"] == 60
    assert summary["dynamic"] == sum(len(segment.dynamic) for segment in scene.segments)
    assert [p.done for p in heard if p.done % 10 == 0] == list(range(10, 61, 10))  # a slow machine reports in between
    assert {p.total for p in heard} == {60}


@pytest.mark.parametrize("learned", [True, False])
def test_the_summary_has_the_mean_falloff_of_the_lenses(capture: Capture, tmp_path: Path, learned: bool) -> None:
    path = tmp_path / "0.pt"
    config = dataclasses.replace(CONFIG, segment_frames=6, lens_falloff=learned)
    _, summary = train_capture(inputs(capture, config), lambda number: path, silent)
    correction = load_state(path).correction
    assert correction is not None
    if learned:
        assert correction.falloff is not None
        assert summary["lens_falloff"] == pytest.approx(correction.falloff.mean(0).tolist())
    else:
        assert summary["lens_falloff"] is None


def test_a_training_stopped_in_its_second_segment_resumes_to_the_same_bits(capture: Capture, tmp_path: Path) -> None:
    def run(name: str, progress: object = silent) -> object:
        (tmp_path / name).mkdir(exist_ok=True)
        place = tmp_path / name
        return train_capture(inputs(capture), lambda i: place / f"{i}.pt", progress)[0]  # type: ignore[arg-type]

    def stop(step: Progress) -> None:
        if step.done == 40:
            raise StageStopped

    whole = run("whole")
    with pytest.raises(StageStopped):
        run("stopped", stop)
    resumed = run("stopped")
    for one, two in zip(whole.segments, resumed.segments, strict=True):  # type: ignore[attr-defined]
        for (name, a), (_, b) in zip(one.dynamic.items(), two.dynamic.items(), strict=True):
            np.testing.assert_array_equal(a, b, err_msg=name)
