"""Clocks of cameras that are late by a part of a frame."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from hgs_core.render.rasterize import rasterize
from hgs_core.scene.splats import DynamicSplats
from hgs_core.train.time_shifts import TimeShifts
from tests.synthetic import ring_of_cameras, synthetic_scene

LATE = [0.03, -0.01, -0.02]
"""Seconds; a segment of one second."""


def drawn(dynamic: DynamicSplats[Tensor], place: int, moment: float) -> Tensor:
    static, _ = synthetic_scene()
    return rasterize(static, dynamic, ring_of_cameras(3, 64, 48)[place], moment, gradients="dynamic").rgb


def test_the_clock_of_every_camera_is_found() -> None:
    _, dynamic = synthetic_scene()
    moments = [0.2, 0.4, 0.6, 0.8]
    truths = {(place, t): drawn(dynamic, place, t + LATE[place]).detach() for place in range(3) for t in moments}
    shifts = TimeShifts(3)
    for turn in range(240):
        place, moment = turn % 3, moments[turn // 3 % 4]
        learning = dynamic.map(lambda array: array.clone().requires_grad_(True))
        picture = drawn(learning, place, moment + shifts.of(place))
        (picture - truths[place, moment]).square().mean().backward()  # type: ignore[no-untyped-call]
        shifts.step(place, learning, 0.002 * (1 - turn / 240))
    assert shifts.seconds.tolist() == pytest.approx(LATE, abs=0.003)


def test_the_mean_of_the_clocks_stays_where_it_is() -> None:
    _, dynamic = synthetic_scene()
    dynamic.time_centers.grad = torch.ones_like(dynamic.time_centers)
    shifts = TimeShifts(3)
    shifts.step(1, dynamic, 0.01)
    assert shifts.of(0) < 0 < shifts.of(1)
    assert float(shifts.seconds.sum()) == pytest.approx(0.0, abs=1e-7)


def test_splats_that_did_not_learn_leave_the_clocks_alone() -> None:
    shifts = TimeShifts(2)
    shifts.step(0, synthetic_scene()[1], 0.01)
    assert shifts.seconds.tolist() == [0.0, 0.0]


def test_clocks_come_back_as_they_were() -> None:
    _, dynamic = synthetic_scene()
    dynamic.time_centers.grad = torch.ones_like(dynamic.time_centers)
    shifts = TimeShifts(2)
    shifts.step(0, dynamic, 0.01)
    again = TimeShifts.restored(shifts.state())
    for one in (shifts, again):
        one.step(0, dynamic, 0.01)
    assert torch.equal(again.seconds, shifts.seconds)
