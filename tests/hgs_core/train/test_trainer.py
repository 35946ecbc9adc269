"""The trainer on a tiny synthetic capture: it learns, it resumes to the same bits, and it keeps labels apart."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch

import hgs_core.train.trainer
from hgs_core.base.config_fields import with_fields
from hgs_core.base.progress import Progress, StageStopped, silent, stop_if_interruptible
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.decompose.masks import motion_masks
from hgs_core.points.point_cloud import PointCloud
from hgs_core.scene import HybridScene
from hgs_core.scene.camera import Camera
from hgs_core.scene.motion import coefficients_of_order
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control import Round, RoundContext
from hgs_core.train.control.infill import InfillRound
from hgs_core.train.control.pruning import PruningRound
from hgs_core.train.control.relabelling import LabelRound
from hgs_core.train.density_config import DensityConfig
from hgs_core.train.initial_splats import initial_splats
from hgs_core.train.schedule import share_alive
from hgs_core.train.segment_cuts import cut_into_segments
from hgs_core.train.train_config import LearningRates, TrainConfig
from hgs_core.train.trainer import Trainer
from tests.synthetic import write_capture

Whole = Callable[..., HybridScene[np.ndarray]]
"""The fixture `whole`."""


@pytest.fixture(scope="module")
def capture_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("capture")
    write_capture(path)
    return path


def config(**overrides: object) -> TrainConfig:
    density = DensityConfig(every=10, start=0.1, max_static=400, max_dynamic=100)
    return with_fields(TrainConfig(iterations=60, checkpoint_every=20, density=density), overrides, "config.train")


AVERAGED = {"average_from": 0.5, "density": {"prune_contribution": 0.0}}
"""The result is the mean of the splats after 40, 50 and 60 iterations; no round replaces them in between."""


def seen(capture: Capture) -> dict[int, Camera]:
    """All cameras but one, which is held out."""
    return {i: camera for i, camera in enumerate(capture.cameras) if camera.name != "2"}


def points(seed: int = 0) -> PointCloud:
    r = np.random.default_rng(seed)
    count = 300
    moving = (np.arange(count) % 5 == 0).astype(np.float32)
    return PointCloud.at_rest(
        xyz=r.uniform(-1, 1, (count, 3)).astype(np.float32),
        rgb=r.uniform(0, 1, (count, 3)).astype(np.float32),
        times=r.choice([0.0, 0.1], count).astype(np.float32),
        dynamic=moving,
        spacing=np.full(count, 0.1, np.float32),
    )


def trainer(capture_folder: Path, checkpoint: Path, settings: TrainConfig, sampled_frames: int = 2) -> Trainer:
    capture = open_capture(capture_folder)
    (segment,) = cut_into_segments(capture.times, settings.segment_frames)
    coefficients = coefficients_of_order(settings.motion_order)
    start = initial_splats(points(), segment.clock, sampled_frames, coefficients=coefficients)
    return Trainer(capture, seen(capture), settings, 0, segment, start, checkpoint)


@pytest.fixture(scope="module")
def whole(capture_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Whole:
    """Return a function that trains without a stop, once for each config."""
    found: dict[str, HybridScene[np.ndarray]] = {}

    def trained(settings: TrainConfig, sampled_frames: int = 2) -> HybridScene[np.ndarray]:
        key = f"{settings} {sampled_frames}"
        if key not in found:
            checkpoint = tmp_path_factory.mktemp("whole") / "checkpoint.pt"
            found[key] = trainer(capture_folder, checkpoint, settings, sampled_frames).run(silent)
        return found[key]

    return trained


def same_bits(one: HybridScene[np.ndarray], two: HybridScene[np.ndarray]) -> bool:
    pairs = zip(
        [*one.static.items(), *one.segments[0].dynamic.items()],
        [*two.static.items(), *two.segments[0].dynamic.items()],
        strict=True,
    )
    return all(np.array_equal(a, b) for (_, a), (_, b) in pairs)


def test_pictures_get_closer_to_the_truth(capture_folder: Path, tmp_path: Path) -> None:
    figures: list[float] = []
    training = trainer(capture_folder, tmp_path / "checkpoint.pt", config(coarse_until=0.0, iterations=150))
    training.run(lambda progress: figures.append(progress.figures["psnr"]))
    assert figures[-1] > figures[0] + 2


@pytest.mark.parametrize("elongation", [3.0, 1e6])
def test_no_axis_is_longer_than_the_middle_one_times_the_elongation(
    capture_folder: Path, tmp_path: Path, elongation: float
) -> None:
    settings = config(elongation=elongation, learning_rates=LearningRates(log_scale=0.1))
    scene = trainer(capture_folder, tmp_path / "checkpoint.pt", settings).run(silent)
    for splats in (scene.static, scene.segments[0].dynamic):
        axes = np.sort(np.exp(splats.log_scales.astype(np.float64)), axis=1)
        longest = (axes[:, 2] / axes[:, 1]).max()
        assert longest <= 3.0 + 1e-4 if elongation == 3.0 else longest > 4  # the length of the pictures


def test_a_mean_of_short_needles_is_one(capture_folder: Path, tmp_path: Path) -> None:
    """Splats short along the first and along the second axis have a mean that is short along both."""
    settings = config(**AVERAGED, iterations=1, elongation=3.0)
    training = trainer(capture_folder, tmp_path / "checkpoint.pt", settings)
    for sizes in ([0.0, -10.0, 1.0], [-10.0, 0.0, 1.0]):
        training.state.static.log_scales[:] = torch.tensor(sizes)
        training.state.follow_means(statics=True)
    axes = np.sort(training.run(silent).static.log_scales, axis=1)
    assert (axes[:, 2] - axes[:, 1]).max() <= np.log(3.0) + 1e-6


def test_a_later_segment_leaves_the_needles_of_the_first_alone(capture_folder: Path, tmp_path: Path) -> None:
    first = trainer(capture_folder, tmp_path / "first.pt", config(iterations=1)).state
    first.static.log_scales[:, 0] += 5.0
    before = first.static.log_scales.clone()
    settings = config(iterations=5, elongation=3.0)
    capture = open_capture(capture_folder)
    (segment,) = cut_into_segments(capture.times, settings.segment_frames)
    start = initial_splats(points(), segment.clock, 2)
    second = Trainer(capture, seen(capture), settings, 0, segment, start, tmp_path / "second.pt", after=first)
    assert torch.equal(second.state.static.log_scales, before)


def test_equal_configs_give_equal_bits(capture_folder: Path, tmp_path: Path, whole: Whole) -> None:
    assert same_bits(whole(config()), trainer(capture_folder, tmp_path / "again.pt", config()).run(silent))


@pytest.mark.parametrize(
    ("stop_at", "changes"),
    [
        (10, {}),
        (30, {}),
        (50, {}),
        (30, {"stages": "interleaved"}),
        (30, {"motion_order": 5}),
        (50, AVERAGED),
        (60, AVERAGED),
    ],
)
def test_a_stopped_training_resumes_to_the_same_bits(
    capture_folder: Path, tmp_path: Path, whole: Whole, stop_at: int, changes: dict[str, object]
) -> None:
    settings = config(**changes)

    def begun(name: str) -> Trainer:  # short lives, for steps by life
        return trainer(capture_folder, tmp_path / name, settings, sampled_frames=6)

    def stop(progress: Progress) -> None:
        if progress.done >= stop_at:
            raise StageStopped

    with pytest.raises(StageStopped):
        begun("stopped.pt").run(stop)
    resumed = begun("stopped.pt")
    assert resumed.state.iteration == stop_at
    assert float(share_alive(resumed.state.dynamic).min()) < 0.8
    expected = whole(settings, sampled_frames=6)
    assert same_bits(expected, resumed.run(silent))
    assert expected.segments[0].dynamic.motion.shape[1] == coefficients_of_order(settings.motion_order)
    assert expected.segments[0].dynamic.motion[:, settings.motion_order].any()


def test_the_result_is_the_mean_of_the_splats_of_the_last_iterations(capture_folder: Path, tmp_path: Path) -> None:
    settings = config(**AVERAGED, elongation=1e6)
    as_they_are = trainer(capture_folder, tmp_path / "last.pt", dataclasses.replace(settings, average_from=1.0))
    told: dict[int, HybridScene[np.ndarray]] = {}
    as_they_are.run(lambda progress: told.update({progress.done: as_they_are.scene()}))
    scenes = [scene for done, scene in told.items() if done % 10 == 0 and done > 0]
    averaged = trainer(capture_folder, tmp_path / "mean.pt", settings)
    result = averaged.run(silent)
    for kind in ("static", "dynamic"):
        sets = [scene.static if kind == "static" else scene.segments[0].dynamic for scene in (*scenes[3:], result)]
        for name, array in sets.pop().items():
            expected = np.mean([getattr(splats, name).astype(np.float64) for splats in sets], axis=0)
            np.testing.assert_allclose(array, expected, rtol=1e-6, atol=1e-7, err_msg=f"{kind} {name}")
    assert same_bits(result, trainer(capture_folder, tmp_path / "mean.pt", settings).scene())  # the checkpoint's


def test_the_mean_begins_anew_where_splats_are_removed(capture_folder: Path, tmp_path: Path) -> None:
    """The pruning after 85 % of the iterations comes after the 50th: only the last one is left to average."""
    settings = config(average_from=0.5, density={"prune_contribution": 0.3})
    counts: list[float] = []
    mean = trainer(capture_folder, tmp_path / "mean.pt", settings).run(lambda p: counts.append(p.figures["static"]))
    last = trainer(capture_folder, tmp_path / "last.pt", dataclasses.replace(settings, average_from=1.0)).run(silent)
    assert counts[-1] < counts[-2]
    assert same_bits(mean, last)


def test_killing_loses_no_more_than_the_iterations_since_the_checkpoint(
    capture_folder: Path, tmp_path: Path, whole: Whole
) -> None:
    def kill(progress: Progress) -> None:
        if progress.done >= 30:
            raise RuntimeError("killed")

    checkpoint = tmp_path / "killed.pt"
    with pytest.raises(RuntimeError, match="killed"):
        trainer(capture_folder, checkpoint, config()).run(kill)
    resumed = trainer(capture_folder, checkpoint, config())
    assert 20 <= resumed.state.iteration < 30
    assert same_bits(whole(config()), resumed.run(silent))


@pytest.mark.parametrize("control", [PruningRound, InfillRound, LabelRound])
def test_a_stop_amid_a_long_round_loses_no_iteration(
    capture_folder: Path, tmp_path: Path, whole: Whole, monkeypatch: pytest.MonkeyPatch, control: type[Round]
) -> None:
    """The round has changed the state already; that state is not kept."""
    expected = whole(config())
    apply, stopped = control.apply, list[int]()

    def stop(self: Round, state: TrainState, context: RoundContext) -> None:
        apply(self, state, context)
        if not stopped:
            stopped.append(context.iteration)
            stop_if_interruptible()

    monkeypatch.setattr(control, "apply", stop)
    checkpoint = tmp_path / "stopped.pt"
    with pytest.raises(StageStopped):
        trainer(capture_folder, checkpoint, config()).run(silent)
    resumed = trainer(capture_folder, checkpoint, config())
    assert [resumed.state.iteration] == stopped
    assert same_bits(expected, resumed.run(silent))


def test_a_slow_training_reports_more_often_than_every_ten_iterations(
    capture_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So that it can be stopped: a stop waits ten seconds."""
    monkeypatch.setattr(hgs_core.train.trainer, "_LONGEST_SILENCE", 0.0)
    told: list[int] = []
    training = trainer(capture_folder, tmp_path / "checkpoint.pt", config(iterations=12))
    training.run(lambda progress: told.append(progress.done))
    assert sorted(set(told)) == list(range(13))  # 0 while pictures are decoded
    assert training.state.history.curves["iteration"] == [10, 12]


def test_training_draws_with_antialiasing_where_the_config_says_so(capture_folder: Path, tmp_path: Path) -> None:
    plain, antialiased = (
        trainer(capture_folder, tmp_path / str(wanted), config(iterations=2, antialiased=wanted)).run(silent)
        for wanted in (False, True)
    )
    assert not same_bits(plain, antialiased)


@pytest.mark.parametrize("stages", ["together", "interleaved", "separate"])
def test_both_sets_learn_in_all_stages(capture_folder: Path, tmp_path: Path, stages: str) -> None:
    """Without rounds of control, which reorder rows: a changed row has learnt."""
    settings = config(
        stages=stages,
        iterations=40,
        coarse_until=0.0,
        density={"end": 0.0, "prune_contribution": 0.0, "birth_rounds": 0},
    )
    capture = open_capture(capture_folder)
    masks = motion_masks(capture, (0, 1, 3, 4), progress=silent)
    (segment,) = cut_into_segments(capture.times, settings.segment_frames)
    start = initial_splats(points(), segment.clock, 2)
    before = start[0].rgb.clone(), start[1].rgb.clone()
    training = Trainer(capture, seen(capture), settings, 0, segment, start, tmp_path / "checkpoint.pt", masks=masks)
    training.run(silent)
    for splats, first in zip((training.state.static, training.state.dynamic), before, strict=True):
        assert splats.rgb.shape == first.shape
        assert float((splats.rgb - first).abs().max()) > 0.01


@pytest.mark.parametrize("stages", ["together", "interleaved"])
def test_a_segment_after_the_first_leaves_the_statics_as_they_are(
    capture_folder: Path, tmp_path: Path, stages: str
) -> None:
    first = trainer(capture_folder, tmp_path / "first.pt", config(iterations=30, stages=stages, **AVERAGED))
    trained = first.run(silent)
    capture, settings = open_capture(capture_folder), first.config
    start = initial_splats(points(1), first.segment.clock, 2)
    first_colours = start[1].rgb[:10].numpy().copy()
    second = Trainer(
        capture, seen(capture), settings, 0, first.segment, start, tmp_path / "second.pt", after=first.state
    )
    scene = second.run(silent)
    for (name, array), (_, before) in zip(scene.static.items(), trained.static.items(), strict=True):
        np.testing.assert_array_equal(array, before, err_msg=name)
    assert not np.array_equal(scene.segments[0].dynamic.rgb[:10], first_colours)


@pytest.mark.parametrize(
    ("stages", "steps"), [("together", {"all step"}), ("interleaved", {"static step", "dynamic step", "tiles"})]
)
def test_the_history_says_what_happened(capture_folder: Path, tmp_path: Path, stages: str, steps: set[str]) -> None:
    training = trainer(capture_folder, tmp_path / "checkpoint.pt", config(stages=stages))
    training.run(silent)
    history = training.state.history
    assert history.curves["iteration"] == [10, 20, 30, 40, 50, 60]
    assert history.curves["static"][-1] == len(training.state.static)
    assert {"frames", "optimiser", "density"} | steps <= set(history.profile)


def with_and_without(field: str, capture_folder: Path, tmp_path: Path) -> list[Trainer]:
    """Return two short trainings, the first with the field turned on."""
    both = [trainer(capture_folder, tmp_path / str(on), config(iterations=20, **{field: on})) for on in (True, False)]
    for training in both:
        training.run(silent)
    return both


def test_cameras_are_corrected_only_where_that_is_wanted(capture_folder: Path, tmp_path: Path) -> None:
    wanted, plain = with_and_without("colour_correction", capture_folder, tmp_path)
    assert wanted.state.correction is not None
    assert float((wanted.state.correction.affine - torch.eye(3, 4)).abs().max()) > 0
    assert plain.state.correction is None


def test_falloffs_are_learned_only_where_that_is_wanted(capture_folder: Path, tmp_path: Path) -> None:
    wanted, plain = with_and_without("lens_falloff", capture_folder, tmp_path)
    for training in (wanted, plain):
        assert training.state.correction is not None
    assert wanted.state.correction.falloff.abs().min() > 0
    assert plain.state.correction.falloff is None


def test_clocks_are_learned_only_where_that_is_wanted(capture_folder: Path, tmp_path: Path) -> None:
    wanted, plain = with_and_without("time_shifts", capture_folder, tmp_path)
    assert wanted.state.time_shifts is not None
    assert wanted.views.time_shifts is wanted.state.time_shifts
    assert float(wanted.state.time_shifts.seconds.abs().min()) > 0
    assert plain.state.time_shifts is None


def test_held_out_cameras_are_never_read(capture_folder: Path, tmp_path: Path) -> None:
    training = trainer(capture_folder, tmp_path / "checkpoint.pt", config())
    held_out = open_capture(capture_folder).camera_index("2")
    assert all(training.views.order.view(iteration)[0] != held_out for iteration in range(500))


def test_a_scene_without_dynamic_points_stays_static(capture_folder: Path, tmp_path: Path) -> None:
    capture = open_capture(capture_folder)
    cloud = points()
    still = dataclasses.replace(cloud, dynamic=np.zeros_like(cloud.dynamic))
    settings = config(iterations=20, labels={"adaptive": False})
    (segment,) = cut_into_segments(capture.times, settings.segment_frames)
    start = initial_splats(still, segment.clock, 2)
    scene = Trainer(capture, seen(capture), settings, 0, segment, start, tmp_path / "checkpoint.pt").run(silent)
    assert len(scene.segments[0].dynamic) == 0
    assert len(scene.static) > 0
