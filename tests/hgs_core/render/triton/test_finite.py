"""The Triton kernels refuse parameters that no picture can show, as the other backends do."""

from __future__ import annotations

import dataclasses
import math

import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.render.triton.rasterize import rasterize_triton
from hgs_core.render.types import View
from hgs_core.scene import DynamicSplats, StaticSplats
from tests.hgs_core.render.dead_splats import check_the_dead_are_not_looked_at
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats

VIEW = View(camera(16, 16), 0.4)
BAD = {"rgb": 1.01e18, "means": math.nan, "motion": -math.inf}  # any other: infinity


def living() -> DynamicSplats[torch.Tensor]:
    splats = dynamic_splats(40, dtype=torch.float32)
    splats.time_log_precisions[:] = -5
    splats.opacity_logits[:] = 1
    return splats


@pytest.mark.parametrize("field", [field.name for field in dataclasses.fields(StaticSplats)])
def test_a_static_parameter_is_named_wherever_it_is(field: str) -> None:
    splats = static_splats(40, dtype=torch.float32)
    splats.means[17, 2] = -5
    getattr(splats, field)[17].view(-1)[-1] = BAD.get(field, math.inf)
    with pytest.raises(InputError, match=rf"^static splats: {field}\[17\] is "):
        rasterize_triton(splats, None, VIEW)


@pytest.mark.parametrize("field", [field.name for field in dataclasses.fields(DynamicSplats)])
def test_a_dynamic_parameter_is_named(field: str) -> None:
    splats = living()
    getattr(splats, field)[17].view(-1)[-1] = BAD.get(field, math.inf)
    with pytest.raises(InputError, match=rf"^dynamic splats: {field}\[17\] is "):
        rasterize_triton(None, splats, VIEW)


def test_dead_splats_are_not_looked_at() -> None:
    splats = living()
    splats.time_log_precisions[::2] = 3
    check_the_dead_are_not_looked_at(splats, lambda splats: rasterize_triton(None, splats, VIEW))
