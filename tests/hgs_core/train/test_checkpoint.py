"""The content of a checkpoint; test_trainer.py tests that a training resumes to the same bits."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.render.types import ScreenStatistics
from hgs_core.train.checkpoint import TrainState, load_state, save_state
from hgs_core.train.time_shifts import TimeShifts
from tests.hgs_core.render.scenes import dynamic_splats, static_splats
from tests.hgs_core.train.conftest import state_of


@pytest.fixture
def state() -> TrainState:
    made = state_of(static_splats(7, dtype=torch.float32), dynamic_splats(4, dtype=torch.float32))
    made.iteration, made.seconds = 12, 3.5
    made.statistics.count[:] = range(11)
    made.static_optimiser.moments.rgb[2] = 0.25
    return made


def test_a_state_comes_back_as_it_was(state: TrainState, tmp_path: Path) -> None:
    save_state(tmp_path / "a.pt", state)
    back = load_state(tmp_path / "a.pt")
    assert (back.iteration, back.seconds, back.correction) == (12, 3.5, None)
    for mine, theirs in (
        (state.static, back.static),
        (state.dynamic, back.dynamic),
        (state.static_optimiser.moments, back.static_optimiser.moments),
        (state.dynamic_optimiser.moments, back.dynamic_optimiser.moments),
    ):
        for (name, one), (_, two) in zip(mine.items(), theirs.items(), strict=True):
            assert torch.equal(one, two), name
    np.testing.assert_array_equal(back.statistics.count, state.statistics.count)


def test_clocks_come_back_as_they_were(state: TrainState, tmp_path: Path) -> None:
    state.time_shifts = TimeShifts(2)
    state.time_shifts.seconds[:] = torch.tensor([0.25, -0.25])
    save_state(tmp_path / "a.pt", state)
    back = load_state(tmp_path / "a.pt").time_shifts
    assert back is not None
    assert back.seconds.tolist() == [0.25, -0.25]


def test_means_come_back_as_they_were(state: TrainState, tmp_path: Path) -> None:
    state.follow_means(statics=True)
    state.static.rgb.mul_(0.5)
    state.dynamic.motion.mul_(0.5)
    state.follow_means(statics=True)
    save_state(tmp_path / "a.pt", state)
    back = load_state(tmp_path / "a.pt")
    for one in (state, back):
        one.become_means()
    assert not torch.equal(state.static.rgb, load_state(tmp_path / "a.pt").static.rgb)
    assert torch.equal(back.static.rgb, state.static.rgb)
    assert torch.equal(back.dynamic.motion, state.dynamic.motion)


def test_splats_become_their_means_once(state: TrainState) -> None:
    before = state.dynamic.rgb.clone()
    state.follow_means(statics=True)
    state.dynamic.rgb.add_(1.0)
    state.become_means()
    assert torch.equal(state.dynamic.rgb, before)
    state.dynamic.rgb.add_(1.0)
    state.become_means()
    assert torch.equal(state.dynamic.rgb, before + 1.0)


def test_statics_that_do_not_learn_are_no_mean(state: TrainState) -> None:
    state.follow_means(statics=False)
    static = state.static
    state.become_means()
    assert state.static is static


def test_means_move_with_the_splats(state: TrainState) -> None:
    state.follow_means(statics=True)
    state.to(torch.device("meta"))
    for mean in (state.static_mean, state.dynamic_mean):
        assert mean.sums is not None
        assert mean.sums.rgb.device.type == "meta"


def test_what_was_loaded_can_be_changed_in_place(state: TrainState, tmp_path: Path) -> None:
    save_state(tmp_path / "a.pt", state)
    back = load_state(tmp_path / "a.pt")
    back.statistics.pull_sum[:] += 1
    assert back.statistics.pull_sum.sum() == 11


def test_the_old_checkpoint_stays_until_the_new_one_is_complete(
    state: TrainState, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save_state(tmp_path / "a.pt", state)

    def cut_short(value: object, file: object) -> None:
        file.write(b"half")  # type: ignore[attr-defined]
        raise OSError("no space left on device")

    monkeypatch.setattr(torch, "save", cut_short)
    with pytest.raises(OSError, match="no space"):
        save_state(tmp_path / "a.pt", state)
    assert load_state(tmp_path / "a.pt").iteration == 12


def test_a_file_that_is_no_checkpoint_is_named_with_the_cure(tmp_path: Path) -> None:
    file = tmp_path / "checkpoint.pt"
    for content in (b"", b"not a checkpoint", pickle.dumps([1], 2)):
        file.write_bytes(content)
        with pytest.raises(InputError, match=r"checkpoint\.pt: unreadable checkpoint .*; delete it to start over"):
            load_state(file)


def test_a_checkpoint_of_another_version_is_refused(state: TrainState, tmp_path: Path) -> None:
    save_state(tmp_path / "a.pt", state)
    value = torch.load(tmp_path / "a.pt", weights_only=True)
    torch.save({**value, "format": 99}, tmp_path / "a.pt")
    with pytest.raises(InputError, match="checkpoint format 99, expected 6; start a new run"):
        load_state(tmp_path / "a.pt")


def test_moving_dynamics_changes_their_rows_alone(state: TrainState) -> None:
    before = state.dynamic.rgb.clone()
    rows = torch.tensor([1, 3])
    living = state.dynamic.map(lambda array: array[rows].clone())
    living.rgb.grad = torch.ones_like(living.rgb)
    seen = ScreenStatistics.zeros(2)
    seen.count[:] = [5, 6]
    counted = state.statistics.count.copy()
    opacities = state.dynamic.opacity_logits.clone()
    state.move_dynamic(living, rows, {name: 0.01 for name, _ in living.items()}, seen, 0.5)
    moved = (state.dynamic.rgb != before).any(1)
    assert moved.tolist() == [False, True, False, True]
    assert (state.statistics.count - counted).tolist() == [0] * 7 + [0, 5, 0, 6]
    faded = opacities - state.dynamic.opacity_logits
    assert faded.tolist() == pytest.approx([0, 0.005, 0, 0.005], abs=1e-6)


def test_moving_statics_fades_those_that_no_picture_shows_too(state: TrainState) -> None:
    before = state.static.map(torch.clone)
    state.static.rgb.grad = torch.ones_like(state.static.rgb)
    state.move_static(dict.fromkeys(("rgb", "opacity_logits"), 0.01), ScreenStatistics.zeros(len(before)), 0.5)
    assert (state.static.rgb < before.rgb).all()
    assert (before.opacity_logits - state.static.opacity_logits).tolist() == pytest.approx([0.005] * 7, abs=1e-6)


def test_other_splats_begin_with_statistics_of_their_own(state: TrainState) -> None:
    state.replace(static_splats(3, dtype=torch.float32), state.dynamic)
    assert state.statistics.count.tolist() == [0] * 7


def test_means_of_other_splats_begin_anew(state: TrainState) -> None:
    state.follow_means(statics=True)
    state.replace(state.static, dynamic_splats(3, dtype=torch.float32))
    state.follow_means(statics=True)
    assert (state.static_mean.count, state.dynamic_mean.count) == (1, 1)


def test_without_a_correction_pictures_are_shown_as_they_are(state: TrainState) -> None:
    picture = torch.rand(3, 4, 5)
    assert state.shown(picture, None) is picture  # type: ignore[arg-type]
