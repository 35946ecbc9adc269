"""Parameters that are not numbers are refused by name, and only those that are looked at."""

from __future__ import annotations

import dataclasses
import math

import pytest
import torch

from hgs_core.errors import InputError
from hgs_core.render.types import View
from hgs_core.scene import DynamicSplats, StaticSplats
from tests.hgs_core.render.comparison import BACKENDS, every_backend
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats

STATIC = [field.name for field in dataclasses.fields(StaticSplats)]
DYNAMIC = [field.name for field in dataclasses.fields(DynamicSplats)]


@every_backend
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", STATIC)
def test_a_static_parameter_is_named(backend: str, field: str, value: float) -> None:
    splats = static_splats(40, dtype=torch.float32)
    getattr(splats, field)[17].view(-1)[-1] = value
    with pytest.raises(InputError, match=rf"^static splats: {field}\[17\] is {value}; remove"):
        BACKENDS[backend](splats, dynamic_splats(5, dtype=torch.float32), View(camera()))


@every_backend
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", DYNAMIC)
def test_a_dynamic_parameter_is_named(backend: str, field: str, value: float) -> None:
    splats = dynamic_splats(40, dtype=torch.float32)
    splats.time_log_precisions[:] = -5
    splats.opacity_logits[:] = 1
    getattr(splats, field)[17].view(-1)[-1] = value
    with pytest.raises(InputError, match=rf"^dynamic splats: {field}\[17\] is {value}; remove"):
        BACKENDS[backend](static_splats(5, dtype=torch.float32), splats, View(camera(), 0.4))


@every_backend
def test_the_first_of_several_is_named(backend: str) -> None:
    splats = static_splats(40, dtype=torch.float32)
    splats.rgb[2] = math.nan
    splats.log_scales[30] = math.inf
    splats.log_scales[20] = math.nan
    with pytest.raises(InputError, match=r"log_scales\[20\] is nan"):
        BACKENDS[backend](splats, None, View(camera()))


@every_backend
def test_statics_out_of_sight_are_looked_at(backend: str) -> None:
    splats = static_splats(40, dtype=torch.float32)
    splats.means[3, 2] = -5
    splats.rgb[3] = math.nan
    with pytest.raises(InputError, match=r"rgb\[3\] is nan"):
        BACKENDS[backend](splats, None, View(camera()))


@every_backend
def test_dead_splats_are_not_looked_at(backend: str) -> None:
    splats = dynamic_splats(40, dtype=torch.float32)
    splats.time_log_precisions[:] = 3
    splats.time_centers[::2] = 9
    for field in ("motion", "rotation", "log_scales", "rgb"):
        getattr(splats, field)[::2] = math.nan
    splats = splats.map(lambda array: array.requires_grad_())
    render = BACKENDS[backend](None, splats, View(camera(), 0.4))
    render.rgb.sum().backward()  # type: ignore[no-untyped-call]
    assert torch.isfinite(render.rgb).all()
    assert render.alpha.any()
    for name, array in splats.items():
        assert array.grad is not None, name
        assert torch.isfinite(array.grad).all(), name
        assert not array.grad[::2].any(), name


@pytest.mark.parametrize("time", [math.nan, math.inf])
def test_a_time_that_is_not_finite_is_refused(time: float) -> None:
    with pytest.raises(InputError, match=r"time: .* is not finite"):
        View(camera(), time)
