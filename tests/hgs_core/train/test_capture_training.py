"""Training a whole capture in segments."""

from __future__ import annotations

import dataclasses
import gc
import weakref
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.arrays import Floats
from hgs_core.base.progress import Progress, StageStopped, silent
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.scene.files import load_scene
from hgs_core.scene.splats import HybridScene
from hgs_core.train import capture_training
from hgs_core.train.capture_training import TrainingInputs, save_trained, train_capture
from hgs_core.train.checkpoint import TrainState, load_state
from hgs_core.train.density_config import DensityConfig
from hgs_core.train.train_config import TrainConfig
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
    return TrainingInputs(
        capture, dict(enumerate(capture.cameras)), config, 0, lambda segment: segment.points(points()), 1
    )


def saved(capture: Capture, folder: Path) -> HybridScene[Floats]:
    save_trained(folder / "scene.npz", inputs(capture), lambda i: folder / f"{i}.pt")
    return load_scene(folder / "scene.npz")


def test_segments_share_the_statics_and_follow_each_other(capture: Capture, tmp_path: Path) -> None:
    heard: list[Progress] = []
    summary = train_capture(inputs(capture), lambda i: tmp_path / f"{i}.pt", heard.append)
    scene = saved(capture, tmp_path)
    assert [(s.start, s.end) for s in scene.segments] == [
        (capture.times[0], capture.times[3]),
        (capture.times[3], capture.times[5]),
    ]
    assert summary["iterations"] == 60
    assert summary["dynamic"] == sum(len(segment.dynamic) for segment in scene.segments)
    assert [p.done for p in heard if p.done % 10 == 0] == list(range(10, 61, 10))  # a slow machine reports in between
    assert {p.total for p in heard} == {60}


@pytest.mark.parametrize("learned", [True, False])
def test_the_summary_has_the_median_colour_map_of_the_cameras(capture: Capture, tmp_path: Path, learned: bool) -> None:
    path = tmp_path / "0.pt"
    config = dataclasses.replace(CONFIG, segment_frames=6, colour_correction=learned)
    summary = train_capture(inputs(capture, config), lambda number: path, silent)
    correction = load_state(path).correction
    if learned:
        assert correction is not None
        assert np.ravel(summary["colour_map"]) == pytest.approx(np.median(correction.affine.numpy(), axis=0).ravel())
    else:
        assert summary["colour_map"] is None


@pytest.mark.parametrize("learned", [True, False])
def test_the_summary_names_the_clocks_that_all_segments_share(capture: Capture, tmp_path: Path, learned: bool) -> None:
    files = {number: tmp_path / f"{number}.pt" for number in range(2)}
    chosen = inputs(capture, dataclasses.replace(CONFIG, time_shifts=learned))
    summary = train_capture(chosen, files.__getitem__, silent)
    first, second = (load_state(file).time_shifts for file in files.values())
    if learned:
        assert first is not None
        assert second is not None
        assert first.seconds.tolist() == second.seconds.tolist()
        names = [capture.cameras[index].name for index in chosen.cameras]
        assert summary["time_shifts"] == dict(zip(names, first.seconds.tolist(), strict=True))
    else:
        assert first is second is summary["time_shifts"] is None


@pytest.mark.parametrize("learned", [True, False])
def test_the_summary_has_the_mean_falloff_of_the_lenses(capture: Capture, tmp_path: Path, learned: bool) -> None:
    path = tmp_path / "0.pt"
    config = dataclasses.replace(CONFIG, segment_frames=6, lens_falloff=learned)
    summary = train_capture(inputs(capture, config), lambda number: path, silent)
    correction = load_state(path).correction
    assert correction is not None
    if learned:
        assert correction.falloff is not None
        assert summary["lens_falloff"] == pytest.approx(correction.falloff.mean(0).tolist())
    else:
        assert summary["lens_falloff"] is None


def test_a_training_stopped_in_its_second_segment_resumes_to_the_same_bits(capture: Capture, tmp_path: Path) -> None:
    def run(name: str, progress: object = silent) -> HybridScene[Floats]:
        (tmp_path / name).mkdir(exist_ok=True)
        place = tmp_path / name
        train_capture(inputs(capture), lambda i: place / f"{i}.pt", progress)  # type: ignore[arg-type]
        return saved(capture, place)

    def stop(step: Progress) -> None:
        if step.done == 40:
            raise StageStopped

    whole = run("whole")
    with pytest.raises(StageStopped):
        run("stopped", stop)
    resumed = run("stopped")
    for one, two in zip(whole.segments, resumed.segments, strict=True):
        for (name, a), (_, b) in zip(one.dynamic.items(), two.dynamic.items(), strict=True):
            np.testing.assert_array_equal(a, b, err_msg=name)


def test_trained_segments_are_read_one_at_a_time_and_stay_as_they_are(
    capture: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def checkpoint(number: int) -> Path:
        return tmp_path / f"{number}.pt"

    asked = inputs(capture, dataclasses.replace(CONFIG, segment_frames=2, iterations=1))
    summary = train_capture(asked, checkpoint, silent)
    before = [checkpoint(number).stat().st_mtime_ns for number in range(3)]
    loaded: list[weakref.ref[TrainState]] = []
    most = 0

    def counted(path: Path) -> TrainState:
        nonlocal most
        state = load_state(path)
        loaded.append(weakref.ref(state))
        gc.collect()
        most = max(most, sum(one() is not None for one in loaded))
        return state

    monkeypatch.setattr(capture_training, "load_state", counted)
    again = train_capture(asked, checkpoint, silent)
    save_trained(tmp_path / "scene.npz", asked, checkpoint)
    assert again == summary
    assert len(load_scene(tmp_path / "scene.npz").segments) == 3
    assert [checkpoint(number).stat().st_mtime_ns for number in range(3)] == before
    assert most == 2  # the first one and another


def test_later_segments_may_take_a_share_of_the_iterations(capture: Capture, tmp_path: Path) -> None:
    heard: list[Progress] = []
    asked = inputs(capture, dataclasses.replace(CONFIG, later_share=0.5))
    summary = train_capture(asked, lambda i: tmp_path / f"{i}.pt", heard.append)
    assert summary["iterations"] == 30 + 15
    assert [load_state(tmp_path / f"{i}.pt").iteration for i in range(2)] == [30, 15]
    assert heard[-1].done == 60
    assert {p.total for p in heard} == {60}
    again = train_capture(asked, lambda i: tmp_path / f"{i}.pt", silent)
    assert again == summary
